// SPDX-License-Identifier: Apache-2.0
// Indirect light from dynamic objects outside rigid groups: deforming objects, whatever their number, and static
// objects that are promoted by a user override.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "base/bits.h"
#include "irradiance_cache/irradiance_cache.h"
#include "scene_helpers.h"
#include "trace/indirect_lights.h"
#include "trace/traced_frame.h"
#include "world.h"

namespace gnomon {
namespace {

using irradiance_cache::IrradianceCache;
using test::World;

scene::Mesh rectangle(scene::MaterialId material, const glm::vec3 (&corners)[4])
{
    scene::Mesh mesh;
    mesh.positions.assign(corners, corners + 4);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{material, 0, 2}};
    return mesh;
}

// A floor, a grey wall, and a red panel that alone is lit by a spot light.
// @param panel_at  object number of the panel
enum class Panel { bends, still, missing };
scene::Scene room(std::size_t panel_at, Panel panel)
{
    scene::Scene scene;
    scene.materials.resize(2);
    for (scene::Material& material : scene.materials) material.double_sided = true;
    scene.materials[0].base_color = glm::vec3(0.8f);
    scene.materials[1].base_color = glm::vec3(0.9f, 0.1f, 0.1f);
    scene.meshes.push_back(rectangle(0, {{-4, 0, -4}, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}}));
    scene.meshes.push_back(rectangle(0, {{-4, 0, -4}, {-4, 4, -4}, {-4, 4, 4}, {-4, 0, 4}}));
    scene.meshes.push_back(rectangle(1, {{-2, 0.1f, -1}, {2, 0.1f, -1}, {2, 4, -1}, {-2, 4, -1}}));
    scene::VertexKeys keys;
    keys.times = {0, 1};
    keys.positions.assign(2, scene.meshes[2].positions);
    for (std::size_t corner : {2u, 3u}) keys.positions[1][corner].x += 0.2f;
    if (panel == Panel::bends) scene.meshes.edit(2).vertex_keys = keys;
    std::vector<scene::MeshId> order = {0, 1};
    if (panel != Panel::missing) order.insert(order.begin() + static_cast<std::ptrdiff_t>(panel_at), 2);
    for (const scene::MeshId mesh : order) test::add_object(scene, mesh);
    scene::Camera camera;
    camera.node =
        scene.add_node("camera", scene::none, glm::rotate(test::translation(0, 3, 8), -0.35, glm::dvec3(1, 0, 0)));
    scene.cameras.push_back(camera);
    scene::Light light;
    light.type = scene::LightType::spot;
    light.color = glm::vec3(5000);
    light.inner_angle = 0.2f, light.outer_angle = 0.35f;
    light.node = scene.add_node("light", scene::none, test::translation(0, 3.9, 3));
    scene.lights.push_back(light);
    scene.finish();
    return scene;
}

std::vector<float> indirect_of(World& world, IrradianceCache& visible)
{
    trace::CachedIndirect indirect(visible);
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {48, 32}), options, world.tasks,
                       buffers, {nullptr, &indirect});
    return buffers.indirect.data;
}

double mean_of(const std::vector<float>& light)
{
    double sum = 0;
    for (const float value : light) sum += static_cast<double>(value);
    return sum / static_cast<double>(light.size());
}

double difference_of(const std::vector<float>& a, const std::vector<float>& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double by = static_cast<double>(a[i]) - static_cast<double>(b[i]);
        sum += by * by;
    }
    return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(IrradianceCacheDynamic, DeformingObjectBouncesLightWhateverItsNumber)
{
    const auto light_of = [](std::size_t panel_at) {
        World world(room(panel_at, Panel::bends));
        EXPECT_TRUE(world.scene->objects[panel_at].deforming && world.scene->objects[panel_at].dynamic);
        IrradianceCache visible(world.state, world.rays, {}, world.tasks);
        return indirect_of(world, visible);
    };
    const std::vector<float> first = light_of(0);
    const double mean = mean_of(first);
    EXPECT_GT(mean, 0.001);
    for (const std::size_t panel_at : {1u, 2u}) {
        const std::vector<float> other = light_of(panel_at);
        ASSERT_EQ(first.size(), other.size());
        EXPECT_LT(difference_of(first, other), 1e-3 * mean) << "as object " << panel_at;
    }
}

constexpr std::size_t k_panel = 1;

// The last of some frames in which a user override puts the panel at these places; nullopt: no override.
std::vector<float> indirect_with_panel_at(const std::vector<std::optional<glm::dvec3>>& places)
{
    World world(room(k_panel, Panel::still), 1, 2);
    EXPECT_FALSE(world.scene->objects[k_panel].dynamic);
    const auto hold = [&](const std::optional<glm::dvec3>& place) {
        const glm::dmat4 local = place ? test::translation(place->x, place->y, place->z) : glm::dmat4(1);
        world.state.override_transform(world.scene->objects[k_panel].node, place ? &local : nullptr);
        world.go(1);
    };
    hold(places.front());
    IrradianceCache visible(world.state, world.rays, {}, world.tasks);
    std::vector<float> light = indirect_of(world, visible);
    for (std::size_t i = 1; i < places.size(); ++i) {
        hold(places[i]);
        light = indirect_of(world, visible);
    }
    return light;
}

TEST(IrradianceCacheDynamic, PromotedObjectsRenderAsIfAlwaysDynamic)
{
    const glm::dvec3 here(0, 0.3, 0), there(1, 0.8, 0.5), away(0, 0, -1000);
    const std::vector<float> before = indirect_with_panel_at({{}}), cold = indirect_with_panel_at({there});
    EXPECT_TRUE(same_bits(cold, indirect_with_panel_at({{}, there})));
    EXPECT_TRUE(same_bits(cold, indirect_with_panel_at({{}, {}, here, away, there})));
    EXPECT_TRUE(same_bits(cold, indirect_with_panel_at({here, there})));
    // No light of it remains at its old place, and it bounces light at its new one.
    const double mean = mean_of(before);
    EXPECT_GT(mean, 0.001);
    EXPECT_GT(difference_of(cold, before), 0.1 * mean);
    const std::vector<float> gone = indirect_with_panel_at({{}, away});
    World world(room(k_panel, Panel::missing), 1, 2);
    IrradianceCache visible(world.state, world.rays, {}, world.tasks);
    EXPECT_LT(difference_of(gone, indirect_of(world, visible)), 0.02 * mean);
    EXPECT_NEAR(mean_of(indirect_with_panel_at({{}, glm::dvec3(0, 0.001, 0)})) / mean, 1, 0.25);
}

// After its promotion, an object costs no more than other dynamic objects.
TEST(IrradianceCacheDynamic, PromotionRebuildsTheTreeOnce)
{
    World world(room(k_panel, Panel::still));
    IrradianceCache visible(world.state, world.rays, {}, world.tasks);
    std::uint64_t fresh[4];
    std::uint32_t made[4];
    for (int i = 0; i < 4; ++i) {
        const glm::dmat4 local = test::translation(0, 0, 0.1 * i);   // within the bounds of the room
        if (i > 0) world.state.override_transform(world.scene->objects[k_panel].node, &local);
        world.go(1);
        indirect_of(world, visible);
        fresh[i] = visible.counters().new_points, made[i] = visible.light_tree().geometry_version();
    }
    EXPECT_GT(made[1], made[0]);
    EXPECT_EQ(made[2], made[1]);
    EXPECT_EQ(made[3], made[1]);
    // Only points on the panel itself and the few that it uncovers: as many as pixels show of it.
    EXPECT_LT(static_cast<double>(fresh[3]), 1.05 * static_cast<double>(fresh[1]));
}

}   // namespace
}   // namespace gnomon
