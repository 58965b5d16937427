// SPDX-License-Identifier: Apache-2.0
#include "shading/shading.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace gnomon::shading {
namespace {

SurfacePoint flat(scene::ShadingModel model)
{
    SurfacePoint s;
    s.geometric_normal = s.normal = s.smooth_normal = {0, 0, 1};
    s.to_viewer = glm::normalize(glm::vec3(0.3f, 0, 1));
    s.model = model;
    s.diffuse = glm::vec3(0.5f);
    return s;
}

glm::vec3 upper_direction(Random& random)
{
    const float z = random.uniform(), a = random.uniform(0, static_cast<float>(2 * k_pi));
    const float r = std::sqrt(1 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
}

TEST(Shading, WhittedDiffuseEqualsColourTimesCosine)
{
    const SurfacePoint s = flat(scene::ShadingModel::whitted);
    const glm::vec3 to_light = glm::normalize(glm::vec3(0, 1, 1));
    EXPECT_NEAR(reflect_light(s, to_light, glm::vec3(2)).x, 0.5f * 2 * std::sqrt(0.5f), 1e-6f);
    EXPECT_EQ(reflect_light(s, {0, 0, -1}, glm::vec3(2)), glm::vec3(0));
}

TEST(Shading, WhittedHighlightLiesAlongTheMirrorDirection)
{
    SurfacePoint s = flat(scene::ShadingModel::whitted);
    s.diffuse = glm::vec3(0);
    s.specular = glm::vec3(0.25f);
    s.shine = 50;
    const glm::vec3 mirror(-s.to_viewer.x, -s.to_viewer.y, s.to_viewer.z);
    EXPECT_NEAR(reflect_light(s, mirror, glm::vec3(1)).x, 0.25f, 1e-5f);
    EXPECT_LT(reflect_light(s, s.to_viewer, glm::vec3(1)).x, 0.01f);
}

// Schlick's approximation, with the fifth power, of a smooth dielectric.
TEST(Shading, MirrorsFollowSchlick)
{
    SurfacePoint s = flat(scene::ShadingModel::metallic_roughness);
    s.roughness = 0;
    s.specular = glm::vec3(0.04f);
    for (const float cosine : {0.9f, 0.5f, 0.2f, 0.05f}) {
        s.to_viewer = {std::sqrt(1 - cosine * cosine), 0, cosine};
        EXPECT_NEAR(continue_from(s).reflected_weight.x, 0.04f + 0.96f * std::pow(1 - cosine, 5.0f), 1e-5f) << cosine;
    }
}

// The polynomial of Chiang et al. (2019), eq. 4, where shading and smooth normal differ.
TEST(Shading, TerminatorFollowsItsPolynomial)
{
    SurfacePoint s = flat(scene::ShadingModel::whitted);
    s.normal = glm::normalize(glm::vec3(0.5f, 0, 1));
    for (const float low : {0.2f, 0.05f}) {
        const glm::vec3 to_light = glm::normalize(glm::vec3(1, 0, low));
        const float shading = glm::dot(s.normal, to_light), smooth = glm::dot(s.smooth_normal, to_light);
        const float g = std::min(1.0f, smooth / (shading * glm::dot(s.normal, s.smooth_normal)));
        ASSERT_LT(g, 1);
        EXPECT_NEAR(reflect_light(s, to_light, glm::vec3(1)).x, 0.5f * shading * (g + g * g - g * g * g), 1e-6f) << low;
    }
}

// No surface may reflect more light than it receives: integrate the GGX reflectance over the hemisphere.
TEST(Shading, GgxDoesNotGainEnergy)
{
    for (const float roughness : {0.3f, 0.6f, 1.0f})
        for (const float f0 : {0.04f, 1.0f}) {
            SurfacePoint s = flat(scene::ShadingModel::metallic_roughness);
            s.diffuse = glm::vec3(f0 < 1 ? 1.0f : 0.0f);
            s.specular = glm::vec3(f0);
            s.roughness = roughness;
            Random random(7);
            double sum = 0;
            constexpr int n = 200'000;
            for (int i = 0; i < n; ++i) sum += reflect_light(s, upper_direction(random), glm::vec3(1)).x;
            const double albedo = sum / n * 2 * k_pi;
            EXPECT_LT(albedo, 1.02) << roughness << ' ' << f0;
            // Single scattering loses light on rough surfaces: at roughness 1, seen from above, 1 - ln 2 remains.
            EXPECT_GT(albedo, roughness < 1 || f0 < 1 ? 0.8 : 1 - std::log(2.0)) << roughness << ' ' << f0;
        }
}

TEST(Shading, FresnelEqualsKnownValues)
{
    EXPECT_NEAR(fresnel_dielectric(1, 1.5f), 0.04f, 1e-6f);
    EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5f), 0.04f, 1e-6f);
    EXPECT_EQ(fresnel_dielectric(0.5f, 1 / 1.5f), 1.0f);   // beyond the critical angle of 41.8 degrees
    EXPECT_NEAR(fresnel_dielectric(0.3f, 1.0f), 0.0f, 1e-6f);
}

TEST(Shading, RefractionFollowsSnell)
{
    SurfacePoint s = flat(scene::ShadingModel::whitted);
    s.diffuse = glm::vec3(0);
    s.transmitted = glm::vec3(1);
    s.ior = 1.5f;
    for (const bool front : {true, false}) {
        s.front = front;
        const Continuation c = continue_from(s);
        const float eta = front ? 1.5f : 1 / 1.5f;
        const float sine_in = std::sqrt(1 - s.to_viewer.z * s.to_viewer.z);
        EXPECT_NEAR(-c.refracted.x, sine_in / eta, 1e-5f);
        EXPECT_LT(c.refracted.z, 0);
        EXPECT_NEAR(c.reflected_weight.x + c.refracted_weight.x, 1, 1e-5f);
    }
}

TEST(Shading, IndexOneDoesNotRefract)
{
    SurfacePoint s = flat(scene::ShadingModel::whitted);
    s.transmitted = glm::vec3(0.85f);
    s.ior = 1;
    const Continuation c = continue_from(s);
    EXPECT_NEAR(glm::distance(c.refracted, -s.to_viewer), 0, 1e-5f);
    EXPECT_NEAR(c.refracted_weight.x, 0.85f, 1e-5f);
}

TEST(Shading, TerminatorFadesBeforeTheGeometricHorizon)
{
    SurfacePoint s = flat(scene::ShadingModel::whitted);
    s.normal = glm::normalize(glm::vec3(0.5f, 0, 1));
    float before = 1;
    for (const float height : {0.5f, 0.1f, 0.01f, 0.001f}) {
        const float light = reflect_light(s, glm::normalize(glm::vec3(1, 0, height)), glm::vec3(1)).x;
        EXPECT_LT(light, before);
        before = light;
    }
    EXPECT_LT(before, 0.005f);
}

TEST(Shading, BackdropEmitsItsAmbientColourOnly)
{
    scene::Scene scene;
    scene.ambient = glm::vec3(2);
    SurfacePoint s = flat(scene::ShadingModel::whitted);
    s.coverage = 1;
    s.ambient = glm::vec3(0.25f);
    EXPECT_EQ(ambient_light(s, scene, true), glm::vec3(0.5f));
    EXPECT_EQ(ambient_light(s, scene, false), glm::vec3(0));   // surfaces that are lit get it from the lights
    s.diffuse = glm::vec3(0);
    EXPECT_EQ(ambient_light(s, scene, false), glm::vec3(0.5f));
    s.specular = glm::vec3(1);
    EXPECT_EQ(ambient_light(s, scene, false), glm::vec3(0));
}

// A triangle that faces +z, whose normal map tilts it along u everywhere, and a little upwards, seen from the front or
// from behind. @param tangent  the file's own, if not 0
glm::vec3 mapped_normal(float rotation, const glm::vec4& tangent, bool front, bool mirrored = false)
{
    scene::Scene scene;
    Image8 leans(1, 1, 3);
    const std::uint8_t texel[] = {218, 138, 218};
    std::copy_n(texel, 3, leans.pixel(0, 0));
    scene.textures.emplace_back("leans", leans, false, scene::Sampler());
    scene::Material material;
    material.double_sided = true;
    material.normal_texture.texture = 0;
    material.normal_texture.rotation = rotation;
    scene.materials.push_back(material);
    scene::Mesh mesh;
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}};
    mesh.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}};
    if (tangent != glm::vec4(0)) mesh.tangents.assign(3, tangent);
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    ray::ObjectGeometry geometry;
    geometry.mesh = &mesh;
    geometry.positions = mesh.positions.data();
    geometry.tangents = mesh.tangents.empty() ? nullptr : mesh.tangents.data();
    geometry.mirrored = mirrored;
    SurfacePoint s;
    surface_at(scene, geometry, 0, 0.3f, 0.3f, 1, {0, 0, front ? -1 : 1}, {}, s);
    return s.normal;
}

// The same as the whole surface has, to the bit: on either side, of mirrored objects, with each model and its textures.
TEST(Shading, ReflectanceOfATriangleIsThatOfItsSurfaces)
{
    Random random(6);
    scene::Scene scene;
    for (int i = 0; i < 3; ++i) {
        Image8 noise(32, 32, 4);
        for (std::uint8_t& value : noise.data) value = static_cast<std::uint8_t>(random.uniform() * 255);
        scene.textures.emplace_back("noise", noise, i == 0, scene::Sampler());
    }
    scene::Material material;
    material.base_color_texture.texture = 0;
    material.base_color_texture.scale = {3, 2};
    material.metallic_roughness_texture.texture = 1;
    material.normal_texture.texture = 2;
    material.emissive_texture.texture = 0, material.occlusion_texture.texture = 1;
    material.emissive = glm::vec3(1);
    material.metallic = 0.7f;
    for (const auto model :
         {scene::ShadingModel::whitted, scene::ShadingModel::metallic_roughness, scene::ShadingModel::unlit}) {
        material.model = model;
        scene.materials.push_back(material);
    }
    scene::Mesh mesh;
    mesh.positions = {{-1, -1, 0.2f}, {1, -1, 0}, {1, 1, -0.3f}};
    mesh.texcoords[0] = {{0, 1}, {1, 1}, {1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}};
    mesh.parts = {{0, 0, 1}, {1, 1, 1}, {2, 2, 1}};
    int colours = 0;
    for (int i = 0; i < 300; ++i) {
        ray::ObjectGeometry geometry;
        geometry.mesh = &mesh;
        geometry.positions = mesh.positions.data();
        geometry.mirrored = i % 2 == 1;
        const auto triangle = static_cast<std::uint32_t>(i % 3);
        const TriangleReflectance reflectance(scene, geometry, triangle);
        const float u = random.uniform(-0.2f, 1), v = random.uniform(-0.2f, 1), distance = random.uniform(0.1f, 5);
        const glm::vec3 direction = glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1),
                                                             random.uniform(0.1f, 1) * (i % 4 < 2 ? -1.0f : 1.0f)));
        const RayCone cone{0.001f, random.uniform(0, 0.1f)};
        SurfacePoint whole, alone;
        surface_at(scene, geometry, triangle, u, v, distance, direction, cone, whole);
        reflectance.find(u, v, distance, direction, cone, alone);
        ASSERT_EQ(alone.model, whole.model) << i;
        ASSERT_EQ(alone.diffuse, whole.diffuse) << i;
        ASSERT_EQ(alone.specular, whole.specular) << i;
        colours += whole.diffuse.x != whole.diffuse.y;
    }
    EXPECT_GT(colours, 150);
}

TEST(Shading, NormalMapsRotateWithTheirImageAndFlipOnBackFaces)
{
    const float half_turn = static_cast<float>(k_pi);
    const glm::vec4 none(0);
    const glm::vec3 leans = mapped_normal(0, none, true);
    EXPECT_NEAR(leans.x, std::sqrt(0.5f), 0.01f);
    EXPECT_GT(leans.y, 0.02f);
    EXPECT_GT(leans.z, 0);
    EXPECT_LT(glm::length(mapped_normal(0, none, false) + leans), 1e-3f);   // a bump in front is a dent behind
    EXPECT_LT(mapped_normal(half_turn, none, true).x, -0.69f);
}

TEST(Shading, NormalMapsFollowTheTangentsOfTheFile)
{
    const auto expect_near = [](const glm::vec3& got, const glm::vec3& expected) {
        EXPECT_LT(glm::length(got - expected), 1e-3f) << got.x << ' ' << got.y << ' ' << got.z;
    };
    const glm::vec3 leans = mapped_normal(0, glm::vec4(0), true);
    // Those along the texture coordinates say the same as these, whatever the texture's transform.
    expect_near(mapped_normal(0, {1, 0, 0, 1}, true), leans);
    expect_near(mapped_normal(static_cast<float>(k_pi), {1, 0, 0, 1}, true), leans);
    expect_near(mapped_normal(0, {1, 0, 0, 1}, false), -leans);
    // Others turn the bump; their sense mirrors it.
    expect_near(mapped_normal(0, {0, 1, 0, 1}, true), {-leans.y, leans.x, leans.z});
    expect_near(mapped_normal(0, {1, 0, 0, -1}, true), {leans.x, -leans.y, leans.z});
    expect_near(mapped_normal(0, {1, 0, 0, -1}, false), {-leans.x, leans.y, -leans.z});
    // Mirrored along z, its front faces -z, and what leans along x and y still does.
    expect_near(mapped_normal(0, {1, 0, 0, 1}, false, true), {leans.x, leans.y, -leans.z});
}

}   // namespace
}   // namespace gnomon::shading
