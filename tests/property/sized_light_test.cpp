// SPDX-License-Identifier: Apache-2.0
// Lights with size: faces, closed forms at a point, visibility by sample places, and frames of which the light is known.
#include "scene/sized_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gnomon/gnomon.h"
#include "scene_helpers.h"
#include "shading/glossy.h"
#include "shading/polygon_light.h"
#include "shading/transformed_cosines.h"

namespace gnomon {
namespace {

// A rectangle in y = 0 around the origin, facing up, with half its side lengths in `half`.
scene::Mesh rectangle(const glm::vec2& half)
{
    scene::Mesh mesh;
    mesh.positions = {{-half.x, 0, -half.y}, {-half.x, 0, half.y}, {half.x, 0, half.y}, {half.x, 0, -half.y}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{0, 0, 2}};
    return mesh;
}

// A scene of one emitter of this mesh: material 0.
scene::Scene emitter(scene::Mesh mesh, const glm::dmat4& transform = glm::dmat4(1))
{
    scene::Scene scene;
    scene.materials.resize(1);
    scene.materials[0].emissive = {2, 1, 0.5f};
    scene.meshes.push_back(std::move(mesh));
    test::add_object(scene, 0, scene::none, transform);
    return scene;
}

scene::SizedLights lights_of(scene::Scene scene, const scene::SizedLightOptions& options = {})
{
    const scene::SceneState state(test::finished(scene), 0);
    scene::SizedLights lights(options);
    lights.update(state);
    return lights;
}

float area_of(const scene::SizedLight& light)
{
    float sum = 0;
    for (const scene::SizedPlace& place : light.places) sum += place.area;
    return sum;
}

TEST(SizedLights, TwoTrianglesOfAPlaneAreOneQuadrilateral)
{
    for (const double mirrored : {1.0, -1.0}) {
        const glm::dmat4 transform = glm::scale(test::translation(3, 1, 2), {2, 1, mirrored});
        const scene::SizedLights lights = lights_of(emitter(rectangle({0.5f, 0.25f}), transform));
        ASSERT_EQ(lights.lights().size(), 1u);
        const scene::SizedLight& light = lights.lights()[0];
        ASSERT_TRUE(light.is_polygon());
        EXPECT_EQ(light.faces[0].corners, 4);
        EXPECT_NEAR(light.faces[0].area, 1, 1e-5);
        EXPECT_NEAR(area_of(light), 1, 1e-4);
        EXPECT_NEAR(light.faces[0].normal.y, 1, 1e-6) << mirrored;   // a mirrored mesh keeps its front
        EXPECT_EQ(light.places.size(), 256u);
        EXPECT_EQ(light.faces[0].radiance, glm::vec3(2, 1, 0.5f));
    }
}

TEST(SizedLights, PlacesOfATriangleAreUniform)
{
    scene::Mesh mesh = rectangle({0.5f, 0.5f});
    mesh.triangles.resize(1);
    mesh.parts[0].triangle_count = 1;
    const scene::SizedLights lights = lights_of(emitter(mesh));
    const scene::SizedLight& light = lights.lights()[0];
    EXPECT_EQ(light.faces[0].corners, 3);
    EXPECT_NEAR(area_of(light), 0.5, 1e-5);
    glm::vec3 mean(0);
    for (const scene::SizedPlace& place : light.places) mean += place.position / 256.0f;
    const glm::vec3 centroid = (mesh.positions[0] + mesh.positions[1] + mesh.positions[2]) / 3.0f;
    EXPECT_LT(glm::length(mean - centroid), 2e-3);
}

TEST(SizedLights, ManyTrianglesBecomeFewClustersOfTheSameFlux)
{
    const scene::SizedLights lights = lights_of(emitter(test::ball(0, 12, 18)));
    EXPECT_GT(lights.counts().polygons, 64u);
    EXPECT_EQ(lights.lights().size(), 16u);
    float faces = 0, places = 0;
    for (const scene::SizedLight& light : lights.lights()) {
        for (const scene::SizedFace& face : light.faces) faces += face.area;
        places += area_of(light);
        EXPECT_EQ(light.places.size(), 64u);
    }
    EXPECT_NEAR(places, faces, 1e-3f * faces);
}

TEST(SizedLights, FollowWhatMovesAndWhatShines)
{
    scene::Scene scene = emitter(rectangle({0.5f, 0.5f}));
    scene.nodes[0].animated = true;
    scene.materials.emplace_back();
    scene::SceneState state(test::finished(scene), 0);
    scene::SizedLights lights;
    lights.update(state);
    EXPECT_TRUE(lights.lights()[0].dynamic);
    const std::uint32_t version = lights.version();
    state.advance(0);
    lights.update(state);
    EXPECT_EQ(lights.version(), version);   // nothing changed
    const glm::dmat4 there = test::translation(0, 5, 0);
    state.override_transform(0, &there);
    state.advance(0);
    lights.update(state);
    EXPECT_NE(lights.version(), version);
    EXPECT_EQ(lights.lights()[0].faces[0].corner[0].y, 5);
    scene::Material dark = state.scene().materials[0];
    dark.emissive = glm::vec3(0);
    state.set_material(0, dark);
    state.advance(0);
    lights.update(state);
    EXPECT_TRUE(lights.empty());
}

TEST(SizedLights, TexturedEmissionIsAveragedByCells)
{
    scene::Mesh mesh = rectangle({0.5f, 0.5f});
    mesh.texcoords[0] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    scene::Scene scene = emitter(mesh);
    Image8 image(64, 64, 3);   // the left half is white, the right half black
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = x < 32 ? 255 : 0;
    scene.textures.push_back(scene::Texture("half", image, true, {}));
    scene.materials[0].emissive_texture.texture = 0;
    const scene::SizedLights lights = lights_of(std::move(scene));
    const scene::SizedLight& light = lights.lights()[0];
    ASSERT_EQ(light.cell_radiance.size(), 64u);
    EXPECT_NEAR(light.faces[0].radiance.x, 1, 0.02);
    for (const glm::vec3& cell : light.cell_radiance)
        EXPECT_TRUE(cell.x < 0.15f || cell.x > 1.85f) << cell.x;
}

shading::SurfacePoint surface(float roughness, float cosine, const glm::vec3& specular)
{
    shading::SurfacePoint s;
    s.normal = s.geometric_normal = {0, 0, 1};
    s.to_viewer = {std::sqrt(1 - cosine * cosine), 0, cosine};
    s.specular = specular;
    s.roughness = roughness;
    s.offset = 1e-6f;
    return s;
}

// A light of radiance 1: a square of this half-width, facing the origin from `centre`.
scene::SizedLight square_light(const glm::vec3& centre, float half)
{
    scene::SizedLight light;
    scene::SizedFace face;
    face.corners = 4;
    face.normal = -glm::normalize(centre);
    glm::vec3 x, y;
    make_basis(face.normal, x, y);
    face.corner = {centre - half * x - half * y, centre + half * x - half * y, centre + half * x + half * y,
                   centre - half * x + half * y};
    face.area = 4 * half * half;
    face.radiance = glm::vec3(1);
    light.faces = {face};
    light.centre = centre;
    light.radius = 2 * half;
    for (const glm::vec2& p : scene::sequence_in_morton_order(256))
        light.places.push_back({face.at(p.x, p.y), 0, glm::vec3(1), face.area / 256});
    return light;
}

// The lobe over a polygon, by a fine grid.
float integrated(const shading::SurfacePoint& s, const scene::SizedLight& light)
{
    constexpr int k_side = 400;
    double sum = 0;
    const scene::SizedFace& face = light.faces[0];
    for (int i = 0; i < k_side; ++i)
        for (int j = 0; j < k_side; ++j) {
            const glm::vec3 p = face.at((static_cast<float>(i) + 0.5f) / k_side, (static_cast<float>(j) + 0.5f) / k_side);
            const float square = glm::dot(p, p);
            const glm::vec3 direction = p / std::sqrt(square);
            const float emitted = -glm::dot(direction, face.normal);
            sum += static_cast<double>(shading::reflect_glossy(s, direction).x * emitted / square);
        }
    return static_cast<float>(sum * static_cast<double>(face.area) / (k_side * k_side));
}

TEST(PolygonLight, TransformedCosinesReflectLightsAsTheLobeDoes)
{
    double worst = 0;
    for (const float roughness : {0.15f, 0.2f, 0.3f, 0.4f, 0.6f, 0.8f, 1.0f})
        for (const float cosine : {1.0f, 0.9f, 0.7f, 0.45f, 0.25f}) {
            const shading::SurfacePoint s = surface(roughness, cosine, glm::vec3(1));
            const glm::vec3 mirror(-s.to_viewer.x, 0, s.to_viewer.z);
            for (const glm::vec3& off : {glm::vec3(0), glm::vec3(0.3f, 0, 0), glm::vec3(0, 0.5f, 0)})
                for (const float half : {0.15f, 0.5f}) {
                    const scene::SizedLight light = square_light(2.0f * glm::normalize(mirror + off), half);
                    const float truth = integrated(s, light), found = shading::unshadowed(s, light, true).lobe.x;
                    EXPECT_NEAR(found, truth, 0.02f + 0.05f * truth)
                        << roughness << ' ' << cosine << ' ' << off.x << ' ' << off.y << ' ' << half;
                    worst = std::max(worst, static_cast<double>(std::abs(found - truth)));
                }
        }
    RecordProperty("worst", std::to_string(worst));
    std::printf("worst %g\n", worst);
}

TEST(PolygonLight, LobesSeeAllOfAnEvenSurrounding)
{
    // Six squares around the point: the lobe reflects its whole albedo.
    for (const float roughness : {0.15f, 0.3f, 0.6f, 1.0f})
        for (const float cosine : {1.0f, 0.6f, 0.3f}) {
            const shading::SurfacePoint s = surface(roughness, cosine, {0.8f, 0.5f, 0.2f});
            glm::vec3 sum(0);
            for (const glm::vec3& centre : {glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0),
                                            glm::vec3(0, -1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)})
                sum += shading::unshadowed(s, square_light(centre, 1), true).lobe;
            const glm::vec3 albedo = shading::glossy_albedo(s);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], albedo[c], 0.02f * albedo[c]) << roughness << ' ' << cosine;
        }
}

}   // namespace
}   // namespace gnomon
