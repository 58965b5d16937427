// SPDX-License-Identifier: Apache-2.0
// KHR_animation_pointer on lights, materials and cameras: values against closed forms, what changes are reported, and
// what files may get wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "gnomon/error.h"
#include "pointer_document.h"
#include "scene/material_layers.h"
#include "scene/state.h"
#include "scene/value_tracks.h"

namespace gnomon {
namespace {

using scene::SceneState;
using test::PointerDocument;
using Ids = std::vector<std::uint32_t>;

const std::string k_light = test::k_light_pointer;
constexpr double k_times[] = {0, 0.1, 0.5, 0.75, 1, 1.5, 2, 3, 0.25};   // there and back

std::shared_ptr<const scene::Scene> loaded(PointerDocument& d, const std::string& materials)
{
    auto scene = std::make_shared<const scene::Scene>(d.load(materials));
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
    return scene;
}

std::shared_ptr<const scene::Scene> loaded(PointerDocument& d)
{
    return loaded(d, R"({},{"emissiveFactor":[0.5,0.25,1]},{})");
}

void expect_near(const glm::vec3& got, const glm::dvec3& expected, double time)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], expected[c], 1e-5 * (1 + expected[c])) << c << " at " << time;
}

// Linear from a to b between times 0 and 2.
double ramp(double a, double b, double time)
{
    const double u = std::clamp(time / 2, 0.0, 1.0);
    return a * (1 - u) + b * u;
}

TEST(GltfPointers, LightsFollowTheirTracks)
{
    PointerDocument d;
    d.animate(k_light + "0/intensity", {0, 2}, {4, 10}, "SCALAR");
    d.animate(k_light + "0/range", {0, 2}, {3, 7}, "SCALAR");
    d.animate(k_light + "1/color", {0, 1, 2}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", "STEP");
    // A Hermite curve from 0.6 to 0.6 that leaves with slope 0.4 and arrives with slope 0.
    d.animate(k_light + "1/spot/outerConeAngle", {0, 2}, {0, 0.6f, 0.4f, 0, 0.6f, 0}, "SCALAR", "CUBICSPLINE");
    d.animate(k_light + "1/spot/innerConeAngle", {0, 2}, {0.1f, 0.3f}, "SCALAR");
    const auto scene = loaded(d);
    EXPECT_EQ(scene->timeline.end, 2);
    SceneState walked(scene, 0);
    for (const double t : k_times) {
        walked.advance(t);
        const SceneState cold(scene, t);
        for (const SceneState* state : std::initializer_list<const SceneState*>{&walked, &cold}) {
            const scene::Light &point = state->scene().lights[0], &spot = state->scene().lights[1];
            expect_near(point.color, ramp(4, 10, t) * glm::dvec3(1, 0.5, 0.25), t);
            EXPECT_NEAR(point.range, ramp(3, 7, t), 1e-5) << t;
            expect_near(spot.color, 6.0 * glm::dvec3(t < 1, t >= 1 && t < 2, t >= 2), t);
            const double u = std::min(t / 2, 1.0);
            EXPECT_NEAR(spot.outer_angle, 0.6 + 0.4 * 2 * (u * u * u - 2 * u * u + u), 1e-5) << t;
            EXPECT_NEAR(spot.inner_angle, ramp(0.1, 0.3, t), 1e-5) << t;
        }
    }
}

TEST(GltfPointers, MaterialsFollowTheirTracks)
{
    PointerDocument d;
    d.animate("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 2}, {1, 0, 0.5f, 1, 0, 1, 0.5f, 1}, "VEC4");
    d.animate("/materials/0/pbrMetallicRoughness/metallicFactor", {0, 2}, {0.25f, 0.75f}, "SCALAR");
    d.animate("/materials/0/pbrMetallicRoughness/roughnessFactor", {0, 2}, {1, 0.5f}, "SCALAR");
    d.animate("/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength", {0, 2}, {0, 8}, "SCALAR");
    d.animate("/materials/2/emissiveFactor", {0, 2}, {0, 0, 0, 1, 0.5f, 0.25f}, "VEC3");
    const auto scene = loaded(d);
    SceneState walked(scene, 0);
    for (const double t : k_times) {
        walked.advance(t);
        const SceneState cold(scene, t);
        for (const SceneState* state : std::initializer_list<const SceneState*>{&walked, &cold}) {
            const auto& m = state->scene().materials;
            expect_near(m[0].base_color, {ramp(1, 0, t), ramp(0, 1, t), 0.5}, t);
            EXPECT_NEAR(m[0].metallic, ramp(0.25, 0.75, t), 1e-6);
            EXPECT_NEAR(m[0].roughness, ramp(1, 0.5, t), 1e-6);
            expect_near(m[1].emissive, ramp(0, 8, t) * glm::dvec3(0.5, 0.25, 1), t);
            expect_near(m[2].emissive, ramp(0, 1, t) * glm::dvec3(1, 0.5, 0.25), t);
        }
    }
}

TEST(GltfPointers, CamerasFollowTheirTracks)
{
    PointerDocument d;
    d.animate("/cameras/0/perspective/yfov", {0, 2}, {0.9f, 0.3f}, "SCALAR");
    d.animate("/cameras/1/orthographic/ymag", {0, 2}, {1, 3}, "SCALAR");
    d.animate("/cameras/0/perspective/znear", {0, 2}, {0.125f, 0.5f}, "SCALAR");
    d.animate("/cameras/1/orthographic/zfar", {0, 2}, {50, 90}, "SCALAR");
    const auto scene = loaded(d);
    SceneState walked(scene, 0);
    for (const double t : k_times) {
        const double before = walked.time();
        walked.advance(t);
        EXPECT_EQ(walked.changes().camera_moved, std::min(before, 2.0) != std::min(t, 2.0)) << before << " to " << t;
        EXPECT_FALSE(walked.changes().anything());
        EXPECT_NEAR(walked.scene().cameras[0].vertical_fov, ramp(0.9, 0.3, t), 1e-6);
        EXPECT_NEAR(walked.scene().cameras[1].orthographic_height, ramp(2, 6, t), 1e-5);
        EXPECT_NEAR(walked.scene().cameras[0].near, ramp(0.125, 0.5, t), 1e-6);
        EXPECT_NEAR(walked.scene().cameras[1].far, ramp(50, 90, t), 1e-4);
        EXPECT_EQ(SceneState(scene, t).scene().cameras[0].vertical_fov, walked.scene().cameras[0].vertical_fov);
    }
}

// Every number, colour and place of a texture that an extension of materials has, and those of the core.
TEST(GltfPointers, AllFactorsOfMaterialsFollowTheirTracks)
{
    struct Number {
        const char* pointer;
        float from, to;
        float scene::Material::*own;
        float scene::MaterialLayers::*layer;
    };
    using M = scene::Material;
    using L = scene::MaterialLayers;
    const Number numbers[] = {
        {"normalTexture/scale", 1, 3, &M::normal_scale, nullptr},
        {"occlusionTexture/strength", 0.25f, 0.75f, &M::occlusion_strength, nullptr},
        {"extensions/KHR_materials_ior/ior", 1.25f, 2, &M::ior, nullptr},
        {"extensions/KHR_materials_transmission/transmissionFactor", 0.25f, 1, &M::transmission, nullptr},
        {"extensions/KHR_materials_volume/thicknessFactor", 1, 2, nullptr, &L::thickness},
        {"extensions/KHR_materials_volume/attenuationDistance", 1, 8, nullptr, &L::attenuation_distance},
        {"extensions/KHR_materials_specular/specularFactor", 0, 1, nullptr, &L::specular},
        {"extensions/KHR_materials_clearcoat/clearcoatFactor", 0, 1, nullptr, &L::clearcoat},
        {"extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor", 0, 0.5f, nullptr, &L::clearcoat_roughness},
        {"extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", 1, 2, nullptr, &L::clearcoat_normal_scale},
        {"extensions/KHR_materials_sheen/sheenRoughnessFactor", 0.25f, 1, nullptr, &L::sheen_roughness},
        {"extensions/KHR_materials_anisotropy/anisotropyStrength", 0, 1, nullptr, &L::anisotropy},
        {"extensions/KHR_materials_anisotropy/anisotropyRotation", -1, 4, nullptr, &L::anisotropy_rotation},
        {"extensions/KHR_materials_iridescence/iridescenceFactor", 0, 1, nullptr, &L::iridescence},
        {"extensions/KHR_materials_iridescence/iridescenceIor", 1.25f, 2, nullptr, &L::iridescence_ior},
        {"extensions/KHR_materials_iridescence/iridescenceThicknessMinimum", 50, 90, nullptr,
         &L::iridescence_thickness_least},
        {"extensions/KHR_materials_iridescence/iridescenceThicknessMaximum", 200, 800, nullptr,
         &L::iridescence_thickness_most},
        {"extensions/KHR_materials_dispersion/dispersion", 0, 2, nullptr, &L::dispersion}};
    const std::pair<const char*, glm::vec3 L::*> colors[] = {
        {"extensions/KHR_materials_volume/attenuationColor", &L::attenuation_color},
        {"extensions/KHR_materials_specular/specularColorFactor", &L::specular_color},
        {"extensions/KHR_materials_sheen/sheenColorFactor", &L::sheen_color}};
    const std::pair<const char*, scene::TextureUse M::*> textures[] = {
        {"pbrMetallicRoughness/baseColorTexture", &M::base_color_texture},
        {"pbrMetallicRoughness/metallicRoughnessTexture", &M::metallic_roughness_texture},
        {"normalTexture", &M::normal_texture},
        {"occlusionTexture", &M::occlusion_texture}};
    const std::pair<const char*, scene::TextureUse L::*> layer_textures[] = {
        {"extensions/KHR_materials_clearcoat/clearcoatTexture", &L::clearcoat_texture},
        {"extensions/KHR_materials_sheen/sheenColorTexture", &L::sheen_color_texture},
        {"extensions/KHR_materials_transmission/transmissionTexture", &L::transmission_texture}};

    PointerDocument d;
    const auto pointer = [](const std::string& rest) { return "/materials/0/" + rest; };
    for (const Number& n : numbers) d.animate(pointer(n.pointer), {0, 2}, {n.from, n.to}, "SCALAR");
    for (const auto& [rest, member] : colors) d.animate(pointer(rest), {0, 2}, {1, 0, 0.5f, 0, 1, 0.5f}, "VEC3");
    const auto move = [&](const std::string& texture) {
        const std::string place = pointer(texture) + "/extensions/KHR_texture_transform/";
        d.animate(place + "offset", {0, 2}, {0, 1, 4, 3}, "VEC2");
        d.animate(place + "scale", {0, 2}, {1, 1, 2, 5}, "VEC2");
        d.animate(place + "rotation", {0, 2}, {0, -3}, "SCALAR");
    };
    for (const auto& [texture, member] : textures) move(texture);
    for (const auto& [texture, member] : layer_textures) move(texture);
    const auto scene = loaded(d);

    SceneState walked(scene, 0);
    const auto expect_moved = [](const scene::TextureUse& use, double t) {
        EXPECT_NEAR(use.offset.x, ramp(0, 4, t), 1e-5) << t;
        EXPECT_NEAR(use.offset.y, ramp(1, 3, t), 1e-5) << t;
        EXPECT_NEAR(use.scale.y, ramp(1, 5, t), 1e-5) << t;
        EXPECT_NEAR(use.rotation, ramp(0, -3, t), 1e-5) << t;
    };
    for (const double t : k_times) {
        const bool moves = std::min(walked.time(), 2.0) != std::min(t, 2.0);
        walked.advance(t);
        EXPECT_EQ(walked.changes().materials_changed, moves ? Ids{0} : Ids{}) << t;
        const SceneState cold(scene, t);
        for (const SceneState* state : std::initializer_list<const SceneState*>{&walked, &cold}) {
            const scene::Material& m = state->scene().materials[0];
            ASSERT_NE(m.layers, nullptr);
            EXPECT_FALSE(m.layers->thin_walled) << "its thickness is animated";
            for (const Number& n : numbers)
                EXPECT_NEAR(n.own ? m.*n.own : (*m.layers).*n.layer, ramp(n.from, n.to, t), 1e-5 * (1 + n.to))
                    << n.pointer << " at " << t;
            for (const auto& [rest, member] : colors)
                expect_near((*m.layers).*member, {ramp(1, 0, t), ramp(0, 1, t), 0.5}, t);
            for (const auto& [texture, member] : textures) expect_moved(m.*member, t);
            for (const auto& [texture, member] : layer_textures) expect_moved((*m.layers).*member, t);
            EXPECT_TRUE(same_to_rays(m, scene->materials[0]));
        }
    }
}

// A surface whose transmission begins at 0 is one that rays pass from the first frame on.
TEST(GltfPointers, TransmissionThatBeginsAtZeroIsGlassAtAllTimes)
{
    PointerDocument d;
    d.animate("/materials/0/extensions/KHR_materials_transmission/transmissionFactor", {0, 2}, {0, 1}, "SCALAR");
    const auto scene = loaded(d);
    EXPECT_EQ(scene->materials[0].surface_class(), scene::SurfaceClass::transparent);
    EXPECT_TRUE(thins_light(scene->materials[0]));
    EXPECT_LT(SceneState(scene, 0).scene().materials[0].transmission, 1e-5f);
    EXPECT_EQ(SceneState(scene, 2).scene().materials[0].transmission, 1);
}

// Weights of a mesh move all nodes that have it and none of their own.
TEST(GltfPointers, WeightsOfAMeshMoveItsNodes)
{
    test::Document d;
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0}), up = d.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 3, true);
    const int input = d.times({0, 2}), output = d.floats({0, 1}, "SCALAR", 1);
    const auto scene = std::make_shared<const scene::Scene>(d.load(
        fmt::format(
            R"("meshes":[{{"weights":[0],"primitives":[{{"attributes":{{"POSITION":{}}},)"
            R"("targets":[{{"POSITION":{}}}]}}]}}],"nodes":[{{"mesh":0}},{{"mesh":0}},{{"mesh":0,"weights":[0.5]}}],)"
            R"("animations":[{{"channels":[{{"sampler":0,"target":{{"path":"pointer","extensions":)"
            R"({{"KHR_animation_pointer":{{"pointer":"/meshes/0/weights"}}}}}}}}],)"
            R"("samplers":[{{"input":{},"output":{}}}]}}])",
            p, up, input, output),
        R"("extensionsUsed":["KHR_animation_pointer"],)"));
    EXPECT_TRUE(scene->warnings.empty()) << scene->warnings.front();
    SceneState state(scene, 1);
    for (const scene::ObjectId object : {0u, 1u, 2u}) EXPECT_NEAR(state.deformed(object).positions[0].z, 0.5f, 1e-6f);
    state.advance(2);
    EXPECT_NEAR(state.deformed(0).positions[0].z, 1, 1e-6f);
    EXPECT_NEAR(state.deformed(1).positions[0].z, 1, 1e-6f);
    EXPECT_NEAR(state.deformed(2).positions[0].z, 0.5f, 1e-6f);
}

// A spline leaves the range of its keys; what the renderer cannot use is limited.
TEST(GltfPointers, SplinesStayWithinWhatTheRendererCanUse)
{
    PointerDocument d;
    const auto wild = [](float slope) { return std::vector<float>{0, 0.5f, slope, slope, 0.5f, 0}; };
    d.animate("/materials/0/pbrMetallicRoughness/roughnessFactor", {0, 2}, wild(90), "SCALAR", "CUBICSPLINE");
    d.animate(k_light + "0/intensity", {0, 2}, wild(-3e38f), "SCALAR", "CUBICSPLINE");
    d.animate(k_light + "0/range", {0, 2}, wild(-90), "SCALAR", "CUBICSPLINE");
    d.animate(k_light + "1/spot/outerConeAngle", {0, 2}, wild(-90), "SCALAR", "CUBICSPLINE");
    d.animate("/cameras/0/perspective/yfov", {0, 2}, wild(90), "SCALAR", "CUBICSPLINE");
    SceneState state(loaded(d), 0);
    for (double t = 0; t < 2.1; t += 0.05) {
        state.advance(t);
        const scene::Light &point = state.scene().lights[0], &spot = state.scene().lights[1];
        const float roughness = state.scene().materials[0].roughness;
        EXPECT_TRUE(roughness >= 0 && roughness <= 1) << roughness;
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(point.color[c] >= 0 && std::isfinite(point.color[c]));
        EXPECT_TRUE(point.range > 0 && std::isfinite(point.range)) << point.range;
        EXPECT_TRUE(spot.outer_angle >= 0 && spot.outer_angle < 1.6f && spot.inner_angle <= spot.outer_angle);
        const double fov = state.scene().cameras[0].vertical_fov;
        EXPECT_TRUE(fov > 0 && fov <= scene::k_widest_fov) << fov;
    }
    state.advance(2);
    EXPECT_EQ(state.scene().lights[1].inner_angle, 0.2f) << "what the cone's angle limited comes back";
}

// Lists are as long as what changed, and values that stay cost nothing.
TEST(GltfPointers, OnlyWhatChangesIsReported)
{
    PointerDocument d;
    d.animate(k_light + "0/intensity", {0, 1, 2, 3}, {4, 4, 8, 8}, "SCALAR");   // between 1 and 2
    d.animate(k_light + "1/range", {0, 3}, {5, 5}, "SCALAR");                   // never
    d.animate("/materials/1/emissiveFactor", {0, 2}, {0, 0, 0, 1, 1, 1}, "VEC3", "STEP");
    SceneState state(loaded(d), 0);
    EXPECT_EQ(state.scene().lights[1].range, 5) << "though it never changes";
    EXPECT_FALSE(state.advance(0.5).anything());
    EXPECT_EQ(state.changes().touched_nodes, 0u);
    EXPECT_FALSE(state.advance(0.5).anything());
    state.advance(1.5);
    EXPECT_EQ(state.changes().lights_relit, Ids{0});
    EXPECT_TRUE(state.changes().lights_moved.empty() && state.changes().materials_changed.empty());
    EXPECT_EQ(state.changes().touched_nodes, 1u);
    state.advance(2);
    EXPECT_EQ(state.changes().lights_relit, Ids{0});
    EXPECT_EQ(state.changes().materials_changed, Ids{1});
    EXPECT_FALSE(state.advance(3).anything());
    state.advance(0);
    EXPECT_EQ(state.changes().lights_relit, Ids{0});
    EXPECT_EQ(state.changes().materials_changed, Ids{1});
}

TEST(GltfPointers, OverridesWinUntilTheyAreReleased)
{
    PointerDocument d;
    d.animate(k_light + "0/intensity", {0, 2}, {4, 10}, "SCALAR");
    d.animate("/materials/0/pbrMetallicRoughness/roughnessFactor", {0, 2}, {1, 0}, "SCALAR");
    const auto scene = loaded(d);
    SceneState state(scene, 0);
    scene::Light light = scene->lights[0];
    light.color = glm::vec3(7);
    scene::Material material = scene->materials[0];
    material.roughness = 0.125f, material.metallic = 0.5f;
    state.set_light(0, light);
    state.set_material(0, material);
    state.advance(0.5);
    EXPECT_EQ(state.changes().lights_relit, Ids{0});
    EXPECT_EQ(state.changes().materials_changed, Ids{0});
    EXPECT_FALSE(state.advance(1).anything()) << "the track does not count";
    EXPECT_EQ(state.changes().touched_nodes, 0u);
    EXPECT_EQ(state.scene().lights[0].color, light.color);
    EXPECT_EQ(state.scene().materials[0].roughness, 0.125f);

    // Released, both follow their tracks again, from the same time on.
    state.release_light(0, scene->lights[0]);
    state.release_material(0, scene->materials[0]);
    state.advance(1);
    EXPECT_EQ(state.changes().lights_relit, Ids{0});
    EXPECT_EQ(state.changes().materials_changed, Ids{0});
    const SceneState cold(scene, 1);
    EXPECT_EQ(state.scene().lights[0].color, cold.scene().lights[0].color);
    EXPECT_TRUE(same_values(state.scene().materials[0], cold.scene().materials[0]));
    state.advance(1.5);
    EXPECT_EQ(state.changes().lights_relit, Ids{0});

    // An override with the very values of the track holds them.
    const scene::Light now = state.scene().lights[0];
    state.set_light(0, now);
    EXPECT_TRUE(state.advance(2).lights_relit.empty());
    EXPECT_EQ(state.scene().lights[0].color, now.color);
}

// Alpha that changes keeps a blended surface blended, though it is opaque at first; holes stay as they are.
TEST(GltfPointers, AlphaFollowsWhereSurfacesBlend)
{
    PointerDocument d;
    for (const int m : {0, 1, 2})
        d.animate(fmt::format("/materials/{}/pbrMetallicRoughness/baseColorFactor", m), {0, 2},
                  {1, 1, 1, 1, 0, 0, 0, m == 2 ? 1 : 0.25f}, "VEC4");
    const auto scene = std::make_shared<const scene::Scene>(
        d.load(R"({"alphaMode":"BLEND"},{"alphaMode":"MASK"},{"alphaMode":"BLEND"})"));
    ASSERT_EQ(scene->warnings.size(), 1u);
    EXPECT_NE(scene->warnings[0].find("/animations/0/channels/1"), std::string::npos) << scene->warnings[0];
    const auto material_of = [&](std::size_t mesh) { return scene->meshes[mesh].parts.at(0).material; };
    SceneState state(scene, 2);
    const auto now = [&](std::size_t mesh) { return state.scene().materials[material_of(mesh)]; };
    EXPECT_EQ(now(0).alpha_mode, scene::AlphaMode::blend);
    EXPECT_EQ(now(0).alpha, 0.25f);
    EXPECT_EQ(now(1).alpha, 1);
    EXPECT_EQ(now(2).alpha_mode, scene::AlphaMode::opaque) << "its alpha never changes";
    for (std::size_t m = 0; m < 3; ++m) EXPECT_EQ(now(m).base_color, glm::vec3(0));
}

TEST(GltfPointers, WhatIsNotSupportedOrHasNoEffectIsNamedOnce)
{
    const char* const pointers[] = {"/materials/0/normalTexture/offset",
                                    "/materials/0/alphaCutoff",
                                    "/materials/0/emissiveTexture/texCoord",
                                    "/cameras/1/orthographic/xmag",
                                    "/cameras/1/perspective/znear",
                                    "/meshes/7/weights",
                                    "/materials/99/emissiveFactor",
                                    "/extensions/KHR_lights_punctual/lights/3/color",
                                    "/extensions/KHR_lights_punctual/lights/2/range",
                                    "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle",
                                    "/cameras/1/perspective/yfov",
                                    "/cameras/18446744073709551616/perspective/yfov",
                                    "/materials/-1/emissiveFactor",
                                    "/materials//emissiveFactor",
                                    "/materials/0",
                                    "",
                                    "/"};
    for (const char* pointer : pointers) {
        PointerDocument d;
        d.animate(pointer, {0, 1}, {0, 1}, "SCALAR");
        const scene::Scene scene = d.load();
        ASSERT_EQ(scene.warnings.size(), 1u) << pointer;
        EXPECT_NE(scene.warnings[0].find(fmt::format("'{}'", pointer)), std::string::npos) << scene.warnings[0];
        EXPECT_EQ(scene.timeline.frames, 1) << pointer;
        for (const scene::Light& light : scene.lights) EXPECT_EQ(light.track, nullptr);
    }
}

TEST(GltfPointers, WrongKeysAreRejectedWithALine)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    struct Case {
        std::vector<float> times, values;
        const char *type, *interpolation, *expected;
    };
    const Case cases[] = {{{0, 1}, {0, 0, 1, 1}, "VEC2", "LINEAR", "cannot be"},
                          {{0, 1}, {0, 1}, "SCALAR", "LINEAR", "cannot be"},
                          {{0, 1}, {0, 0, 0, 1, 1, 1, 1, 1}, "VEC4", "LINEAR", "cannot be"},
                          {{0, 1}, {0, 0, 0}, "VEC3", "LINEAR", "1 values for 2 keys"},
                          {{0, 1}, {0, 0, 0, 1, 1, 1}, "VEC3", "CUBICSPLINE", "2 values for 2 keys"},
                          {{0, 1}, {0, 0, nan, 1, 1, 1}, "VEC3", "LINEAR", "is not finite"}};
    for (const Case& c : cases) {
        PointerDocument d;
        // Bounds are not declared with a value that is not a number.
        const int input = d.document().times(c.times);
        const int size = std::string(c.type) == "SCALAR" ? 1 : c.type[3] - '0';
        d.animate("/materials/0/emissiveFactor", input, d.document().floats(c.values, c.type, size), c.interpolation);
        try {
            d.load();
            ADD_FAILURE() << c.expected;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(c.expected), std::string::npos) << error.what();
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    }
}

// Fractions of 255 are values as well; of two channels with one target the first counts.
TEST(GltfPointers, NormalizedValuesAndDoubleTargets)
{
    PointerDocument d;
    const int t = d.document().times({0, 1});
    d.animate("/materials/0/emissiveFactor", t,
              d.document().accessor<std::uint8_t>({0, 0, 0, 0, 255, 51, 0, 0}, "VEC4", 5121, 4));
    EXPECT_THROW(d.load(), InputError);

    PointerDocument e;
    const int times = e.document().times({0, 1});
    e.animate(
        "/materials/0/pbrMetallicRoughness/baseColorFactor", times,
        e.document().accessor<std::uint8_t>({0, 0, 0, 255, 255, 51, 0, 255}, "VEC4", 5121, 4, R"(,"normalized":true)"));
    e.animate("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 1}, {1, 1, 1, 1, 1, 1, 1, 1}, "VEC4");
    const auto scene = std::make_shared<const scene::Scene>(e.load());
    expect_near(SceneState(scene, 1).scene().materials[0].base_color, {1, 0.2, 0}, 1);
}

// A file as found on the web that animates nearly everything.
TEST(GltfPointers, AFileOfAnimatedPropertiesFollowsThem)
{
    GNOMON_NEED_SCENE(file, "real/24_animation_pointer/24_animation_pointer.gltf");
    const auto scene = std::make_shared<const scene::Scene>(io::load_gltf(file));
    std::size_t lights = 0, materials = 0, cameras = 0;
    for (const scene::Light& light : scene->lights) lights += light.track != nullptr;
    for (const scene::Material& material : scene->materials) materials += material.track != nullptr;
    for (const scene::Camera& camera : scene->cameras) cameras += camera.track != nullptr;
    EXPECT_GE(lights, 3u);
    EXPECT_GE(materials, 5u);
    EXPECT_GE(cameras, 1u);
    for (const std::string& warning : scene->warnings)
        for (const char* supported :
             {"lights/0/intensity'", "/emissiveFactor'", "/metallicFactor'", "/perspective/yfov'"})
            EXPECT_EQ(warning.find(supported), std::string::npos) << warning;

    // A state that walked has the values of one that was made at the time.
    SceneState walked(scene, scene->timeline.start);
    for (int frame = 1; frame <= scene->timeline.frames; frame += 7) {
        const double time = scene->timeline.time_of(frame);
        walked.advance(time);
        const SceneState cold(scene, time);
        for (std::size_t l = 0; l < scene->lights.size(); ++l) {
            EXPECT_EQ(walked.scene().lights[l].color, cold.scene().lights[l].color);
            EXPECT_TRUE(same_reach(walked.scene().lights[l], cold.scene().lights[l]));
        }
        for (std::size_t m = 0; m < scene->materials.size(); ++m)
            EXPECT_TRUE(same_values(walked.scene().materials[m], cold.scene().materials[m]));
    }
}

}   // namespace
}   // namespace gnomon
