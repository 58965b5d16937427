// SPDX-License-Identifier: Apache-2.0
// Lights with size: faces, closed forms at a point, visibility by sample places, and frames of which the light is
// known.
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
        ASSERT_TRUE(light.is_flat());
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

// A fan of triangles around the origin in the plane y = 0, with a hole up to a part of its radius.
scene::Mesh fan(int corners, float hole)
{
    scene::Mesh mesh;
    for (int k = 0; k < corners; ++k)
        for (const float radius : {1.0f, hole}) {
            const double turn = 2 * k_pi * k / corners;
            mesh.positions.emplace_back(radius * static_cast<float>(std::cos(turn)), 0,
                                        -radius * static_cast<float>(std::sin(turn)));
        }
    const auto at = [&](int k, int inner) { return static_cast<std::uint32_t>(2 * (k % corners) + inner); };
    for (int k = 0; k < corners; ++k) {
        mesh.triangles.emplace_back(at(k, 1), at(k, 0), at(k + 1, 0));
        if (hole > 0) mesh.triangles.emplace_back(at(k, 1), at(k + 1, 0), at(k + 1, 1));
    }
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

TEST(SizedLights, FlatFiguresAreOneLight)
{
    const scene::SizedLights disc = lights_of(emitter(fan(48, 0)));
    ASSERT_EQ(disc.lights().size(), 1u);
    const scene::SizedLight& light = disc.lights()[0];
    EXPECT_TRUE(light.is_flat());
    EXPECT_GT(light.faces.size(), 20u);
    EXPECT_EQ(light.outline.corners, 4);
    EXPECT_NEAR(light.outline.area, 4, 0.05);
    EXPECT_NEAR(area_of(light), k_pi, 0.02);
    EXPECT_NEAR(light.outline.normal.y, 1, 1e-6);
    for (const scene::SizedFace& face : light.faces)
        for (const glm::vec3& p : face.corner) EXPECT_LE(std::max(std::abs(p.x), std::abs(p.z)), 1.01f);

    // A thin ring fills too little of the rectangle around it.
    EXPECT_GT(lights_of(emitter(fan(24, 0.95f))).lights().size(), 10u);
    // A ball has no two faces in one plane.
    const auto ball = lights_of(emitter(test::ball(0, 4, 6)));
    EXPECT_FALSE(ball.lights().empty());
    for (const scene::SizedLight& of_ball : ball.lights()) EXPECT_EQ(of_ball.faces.size(), 1u);
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
    for (const glm::vec3& cell : light.cell_radiance) EXPECT_TRUE(cell.x < 0.15f || cell.x > 1.85f) << cell.x;
}

shading::SurfacePoint surface(float roughness, float cosine, const glm::vec3& specular)
{
    shading::SurfacePoint s;
    s.normal = s.geometric_normal = s.smooth_normal = {0, 0, 1};
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
            const glm::vec3 p =
                face.at((static_cast<float>(i) + 0.5f) / k_side, (static_cast<float>(j) + 0.5f) / k_side);
            const float square = glm::dot(p, p);
            const glm::vec3 direction = p / std::sqrt(square);
            const float emitted = -glm::dot(direction, face.normal);
            sum += static_cast<double>(shading::reflect_glossy(s, direction).x * emitted / square);
        }
    return static_cast<float>(sum * static_cast<double>(face.area) / (k_side * k_side));
}

TEST(PolygonLight, TransformedCosinesReflectLightsAsTheLobeDoes)
{
    for (const float roughness : {0.15f, 0.2f, 0.3f, 0.4f, 0.6f, 0.8f, 1.0f})
        for (const float cosine : {1.0f, 0.9f, 0.7f, 0.45f, 0.25f}) {
            const shading::SurfacePoint s = surface(roughness, cosine, glm::vec3(1));
            const glm::vec3 mirror(-s.to_viewer.x, 0, s.to_viewer.z);
            for (const glm::vec3& off : {glm::vec3(0), glm::vec3(0.3f, 0, 0), glm::vec3(0, 0.5f, 0)})
                for (const float half : {0.15f, 0.5f}) {
                    const scene::SizedLight light = square_light(2.0f * glm::normalize(mirror + off), half);
                    const float truth = integrated(s, light), found = shading::unshadowed(s, light, true).lobe.x;
                    // Near grazing, the lobe is least like a cosine.
                    const float least = cosine < 0.3f ? 0.05f : 0.02f;
                    EXPECT_NEAR(found, truth, least + 0.05f * truth)
                        << roughness << ' ' << cosine << ' ' << off.x << ' ' << off.y << ' ' << half;
                }
        }
}

// A dielectric reflects far more of what is low before it than of what is high: up to five times too much or too little
// of a square was left by the mean reflectance alone.
TEST(PolygonLight, DielectricsReflectMoreOfWhatIsLow)
{
    for (const float roughness : {0.3f, 0.5f, 0.7f})
        for (const float slant : {45.0f, 60.0f, 75.0f}) {
            const auto radians = [](float degrees) { return degrees * static_cast<float>(k_pi) / 180; };
            const shading::SurfacePoint s = surface(roughness, std::cos(radians(slant)), glm::vec3(0.04f));
            double found = 0, truth = 0;
            for (const float height : {20.0f, 45.0f, 70.0f}) {
                const glm::vec3 way(-std::cos(radians(height)), 0, std::sin(radians(height)));
                const scene::SizedLight light = square_light(3.0f * way, 0.3f);
                const float one = shading::unshadowed(s, light, true).lobe.x, right = integrated(s, light);
                // Of what is far from the lobe's axis, its tails are too short or too long for any lobe.
                EXPECT_NEAR(one / right, 1, 0.4) << roughness << ' ' << slant << ' ' << height;
                found += static_cast<double>(one), truth += static_cast<double>(right);
            }
            EXPECT_NEAR(found / truth, 1, 0.25) << roughness << ' ' << slant;
        }
}

// Groups of faces that count as discs give what the faces give, near a glowing body as far away, for any lobe.
TEST(PolygonLight, GroupsOfFacesBringWhatTheFacesBring)
{
    scene::SizedLightOptions options;
    options.most_clusters = 2;
    scene::Mesh sphere = test::ball(0, 40, 60);
    for (glm::vec3& p : sphere.positions) p = glm::normalize(p);
    const scene::SizedLights made = lights_of(emitter(sphere), options);
    ASSERT_EQ(made.lights().size(), 2u);
    Random random(11);
    const auto direction = [&] {
        const float z = random.uniform(-1, 1), turn = random.uniform(0, 2 * static_cast<float>(k_pi));
        const float r = std::sqrt(std::max(0.0f, 1 - z * z));
        return glm::vec3(r * std::cos(turn), r * std::sin(turn), z);
    };
    glm::dvec2 all(0), error[2] = {glm::dvec2(0), glm::dvec2(0)};   // of irradiance and lobes; fine and coarse
    std::size_t unlike = 0;
    for (int i = 0; i < 400; ++i) {
        shading::SurfacePoint s = surface(random.uniform(0.15f, 1), 0, glm::vec3(1));
        const float height = random.uniform();
        s.position = direction() * (1.002f + 2 * height * height * height);
        s.normal = s.geometric_normal = s.smooth_normal = direction();
        s.to_viewer = direction();
        if (glm::dot(s.to_viewer, s.normal) < 0) s.to_viewer = -s.to_viewer;
        for (const scene::SizedLight& light : made.lights()) {
            scene::SizedLight alone = light;
            alone.tree = {};
            shading::PolygonLightOptions near;
            near.far = 1e9f;   // no sum over places
            const shading::UnshadowedLight truth = shading::unshadowed(s, alone, true, near);
            all += glm::dvec2(truth.irradiance.x, truth.lobe.x);
            for (const bool coarse : {false, true}) {
                near.coarse = coarse;
                const shading::UnshadowedLight found = shading::unshadowed(s, light, true, near);
                error[coarse] += glm::dvec2(found.irradiance.x - truth.irradiance.x, found.lobe.x - truth.lobe.x);
                if (coarse) continue;
                // The irradiance of a point that sees nothing else is 2 pi.
                EXPECT_NEAR(found.irradiance.x, truth.irradiance.x, 0.03f * truth.irradiance.x + 0.002f) << i;
                EXPECT_NEAR(found.lobe.x, truth.lobe.x, 0.02f * truth.lobe.x + 0.002f) << i << ' ' << s.roughness;
                if (found.irradiance != truth.irradiance) ++unlike;
            }
        }
    }
    for (const int part : {0, 1}) {
        EXPECT_NEAR(error[0][part] / all[part], 0, 0.002) << part;
        EXPECT_NEAR(error[1][part] / all[part], 0, 0.04) << part;
    }
    EXPECT_GT(unlike, 200u);   // there were groups
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
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], albedo[c], 0.03f * albedo[c]) << roughness << ' ' << cosine;
        }
    // And of a dielectric about all of it, although squares to its sides have reflectances of their own.
    for (const float roughness : {0.15f, 0.3f, 0.6f, 1.0f})
        for (const float cosine : {1.0f, 0.6f, 0.3f}) {
            const shading::SurfacePoint s = surface(roughness, cosine, glm::vec3(0.04f));
            float sum = 0;
            for (const glm::vec3& centre : {glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0),
                                            glm::vec3(0, -1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)})
                sum += shading::unshadowed(s, square_light(centre, 1), true).lobe.x;
            EXPECT_NEAR(sum / shading::glossy_albedo(s).x, 1, 0.13) << roughness << ' ' << cosine;
        }
}

// Frames.

// Irradiance at a place of the floor y = 0 under a square emitter of half-width .5 and radiance 1 at some height, of
// its part from x = `from` on [Lambert 1760].
double under_square(const glm::dvec2& place, double height, double from = -0.5)
{
    from = std::clamp(from, -0.5, 0.5);
    if (!(from < 0.5)) return 0;
    const glm::dvec3 corner[4] = {{from - place.x, height, -0.5 - place.y},
                                  {0.5 - place.x, height, -0.5 - place.y},
                                  {0.5 - place.x, height, 0.5 - place.y},
                                  {from - place.x, height, 0.5 - place.y}};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 a = glm::normalize(corner[i]), b = glm::normalize(corner[(i + 1) % 4]);
        const glm::dvec3 axis = glm::cross(a, b);
        const double sine = glm::length(axis);
        if (sine > 0) sum += std::atan2(sine, glm::dot(a, b)) * axis.y / sine;
    }
    return std::abs(sum) / 2;
}

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<Vec2> k_square_texcoords{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
const std::vector<std::uint32_t> k_down{0, 1, 2, 0, 2, 3}, k_up{0, 2, 1, 0, 3, 2};
constexpr float k_albedo = 0.5f;
constexpr double k_side = 3;   // of the floor that the camera sees

Material matte(float albedo)
{
    // Without a specular reflection.
    return {.base_color = {albedo, albedo, albedo}, .roughness = 1, .ior = 1};
}

struct FloorOptions {
    float radiance = 1, height = 1, size = 20;
    bool weak_light = false, edge = false, textured = false;
};

// A floor seen from above, through the back of a square emitter that faces down.
Scene floor_scene(const FloorOptions& o)
{
    SceneBuilder builder;
    Material shining{.base_color = {0, 0, 0}, .emissive = {o.radiance, o.radiance, o.radiance}};
    if (o.textured) {
        const std::vector<std::uint8_t> white(4 * 4 * 3, 255);
        shining.emissive_texture.texture = builder.texture({.width = 4, .height = 4, .channels = 3, .pixels = white});
    }
    const MaterialId emitter = builder.material(shining), floor = builder.material(matte(k_albedo));
    builder.instance(builder.mesh({.positions = k_square, .indices = k_down, .texcoords = {k_square_texcoords}}),
                     emitter, Transform::translation(0, o.height, 0));
    const MeshId plane = builder.mesh({.positions = k_square, .indices = k_up});
    builder.instance(plane, floor, Transform::scaling(o.size, 1, o.size));
    // A half-plane over x < 0, seen from below alone.
    if (o.edge) {
        const MeshId blind = builder.mesh({.positions = k_square, .indices = k_down});
        builder.instance(blind, floor, Transform::translation(-50, 0.5, 0) * Transform::scaling(100, 1, 100));
    }
    if (o.weak_light) builder.light({.color = {1e-3f, 1e-3f, 1e-3f}}, Transform::translation(0.2, 0.5, 0));
    Camera camera;
    camera.transform = Transform::look_at({0, 5, 0}, {0, 0, 0}, {0, 0, -1});
    camera.orthographic_height = k_side;
    builder.camera(camera);
    return builder.finish();
}

// Root of the mean squared difference from the truth, over the mean truth.
double floor_error(const FloorOptions& o, int size = 40)
{
    RenderOptions options;
    options.size = {size, size};
    options.indirect = Indirect::off;
    const Frame frame = Renderer(options).render(floor_scene(o), 1);
    const auto values = frame.layers.front().values();
    double square = 0, sum = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const glm::dvec2 place = k_side * ((glm::dvec2(x, y) + 0.5) / static_cast<double>(size) - 0.5);
            // A ray to the emitter passes the edge's height at a place between: it must lie beyond the edge.
            const double from = o.edge ? place.x - place.x * static_cast<double>(o.height) / 0.5 : -0.5;
            const double truth = static_cast<double>(k_albedo * o.radiance) / k_pi *
                                 under_square(place, static_cast<double>(o.height), from);
            const double value = static_cast<double>(values[static_cast<std::size_t>(3 * (y * size + x))]);
            square += (value - truth) * (value - truth), sum += truth;
        }
    const double count = size * size;
    return std::sqrt(square / count) / (sum / count);
}

TEST(SizedLightFrame, SquareLightGivesTheFloorWhatLambertSays)
{
    EXPECT_LE(floor_error({.height = 2}), 0.01);
    EXPECT_LE(floor_error({.height = 0.5f}), 0.02);
    EXPECT_LE(floor_error({.height = 0.15f}), 0.05);
}

TEST(SizedLightFrame, PenumbraOfAStraightEdgeIsTheVisiblePartOfTheLight)
{
    EXPECT_LE(floor_error({.edge = true}), 0.02);
}

TEST(SizedLightFrame, EmissionLightsHoweverDimAndBesideAnyOtherLight)
{
    EXPECT_LE(floor_error({.radiance = 4, .weak_light = true}), 0.02);
    EXPECT_LE(floor_error({.radiance = 0.99f}), 0.02);
    EXPECT_LE(floor_error({.radiance = 0.99f, .textured = true}), 0.02);
    EXPECT_LE(floor_error({.radiance = 0.99f, .size = 100}), 0.02);
}

// A square emitter as a metal plane shows it: as bright as it is.
TEST(SizedLightFrame, MetalShowsAnAreaLightAsBrightAsItIs)
{
    for (const float roughness : {0.0f, 0.04f, 0.06f, 0.1f, 0.14f, 0.2f, 0.3f, 0.4f}) {
        SceneBuilder builder;
        const MaterialId emitter = builder.material({.base_color = {0, 0, 0}, .emissive = {1, 1, 1}});
        const MaterialId metal = builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = roughness});
        builder.instance(builder.mesh({.positions = k_square, .indices = k_down}), emitter,
                         Transform::translation(0, 1, 0) * Transform::scaling(12, 1, 12));
        builder.instance(builder.mesh({.positions = k_square, .indices = k_up}), metal, Transform::scaling(20, 1, 20));
        Camera camera;
        camera.transform = Transform::look_at({-0.4f, 0.8f, 0}, {0, 0, 0});
        camera.vertical_fov = 0.02;
        builder.camera(camera);
        RenderOptions options;
        options.size = {4, 4};
        options.indirect = Indirect::off;
        const Frame frame = Renderer(options).render(builder.finish(), 1);
        for (const float value : frame.layers.front().values()) {
            EXPECT_GE(value, 0.95f) << roughness;
            EXPECT_LE(value, 1.05f) << roughness;
        }
    }
}

// In a closed box of emissive walls, every point gets pi of each wall's radiance, and that of one bounce: e (1 +
// albedo) is the radiance that the walls show beside their own.
TEST(SizedLightFrame, ClosedBoxOfEmissiveWalls)
{
    for (const Indirect indirect : {Indirect::off, Indirect::visible}) {
        SceneBuilder builder;
        Material wall = matte(k_albedo);
        wall.emissive = {1, 1, 1};
        const MaterialId material = builder.material(wall);
        const MeshId mesh = builder.mesh({.positions = k_square, .indices = k_up});
        for (const Transform& turn :
             {Transform(), Transform::rotation({1, 0, 0}, k_pi), Transform::rotation({1, 0, 0}, k_pi / 2),
              Transform::rotation({1, 0, 0}, -k_pi / 2), Transform::rotation({0, 0, 1}, k_pi / 2),
              Transform::rotation({0, 0, 1}, -k_pi / 2)})
            builder.instance(mesh, material, turn * Transform::translation(0, -1, 0) * Transform::scaling(2, 1, 2));
        Camera camera;
        camera.transform = Transform::look_at({0.2f, 0.1f, 0.7f}, {-0.3f, -0.2f, -1});
        camera.vertical_fov = 1;
        builder.camera(camera);
        RenderOptions options;
        options.size = {24, 24};
        options.indirect = indirect;
        options.bounces = 1;
        const Frame frame = Renderer(options).render(builder.finish(), 1);
        double square = 0, sum = 0;
        const double truth = 1 + static_cast<double>(k_albedo) + (indirect == Indirect::off ? 0 : 0.25);
        const auto values = frame.layers.front().values();
        for (const float value : values) {
            square += std::pow(static_cast<double>(value) - truth, 2);
            sum += static_cast<double>(value);
        }
        const auto count = static_cast<double>(values.size());
        EXPECT_NEAR(sum / count, truth, 0.02 * truth) << static_cast<int>(indirect);
        EXPECT_LE(std::sqrt(square / count) / truth, 0.03) << static_cast<int>(indirect);
    }
}

}   // namespace
}   // namespace gnomon
