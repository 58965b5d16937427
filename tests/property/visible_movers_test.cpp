// SPDX-License-Identifier: Apache-2.0
// Bounced light of what moves and is not told apart by the scene: what deforms, wherever it stands among the objects.
#include <gtest/gtest.h>

#include <cmath>

#include "light_quadtree/visible_light.h"
#include "render/traced_frame.h"
#include "scene_helpers.h"
#include "world.h"

namespace gnomon {
namespace {

using light_quadtree::VisibleLight;
using test::World;

scene::Mesh rectangle(scene::MaterialId material, const glm::vec3 (&corners)[4])
{
    scene::Mesh mesh;
    mesh.positions.assign(corners, corners + 4);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{material, 0, 2}};
    return mesh;
}

// A floor, a grey wall and a red panel, before which a spot light stands that lights the panel alone; the panel is the
// object of this number, and bends.
scene::Scene room(std::size_t panel_at)
{
    scene::Scene scene;
    scene.materials.resize(2);
    for (scene::Material& material : scene.materials) material.double_sided = true;
    scene.materials[0].base_color = glm::vec3(0.8f);
    scene.materials[1].base_color = glm::vec3(0.9f, 0.1f, 0.1f);
    scene.meshes = {rectangle(0, {{-4, 0, -4}, {-4, 0, 4}, {4, 0, 4}, {4, 0, -4}}),
                    rectangle(0, {{-4, 0, -4}, {-4, 4, -4}, {-4, 4, 4}, {-4, 0, 4}}),
                    rectangle(1, {{-2, 0.1f, -1}, {2, 0.1f, -1}, {2, 4, -1}, {-2, 4, -1}})};
    scene::VertexKeys keys;
    keys.times = {0, 1};
    keys.positions.assign(2, scene.meshes[2].positions);
    for (std::size_t corner : {2u, 3u}) keys.positions[1][corner].x += 0.2f;
    scene.meshes[2].vertex_keys = keys;
    std::vector<scene::MeshId> order = {0, 1};
    order.insert(order.begin() + static_cast<std::ptrdiff_t>(panel_at), 2);
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

std::vector<float> indirect_of(World& world, VisibleLight& visible)
{
    render::Remembered remembered;
    remembered.visible = &visible;
    render::TracedOptions options;
    options.layers = true;
    render::FrameBuffers buffers;
    render::trace_frame(world.state, world.rays, render::make_view(world.state, 0, {48, 32}), options, world.tasks,
                        buffers, remembered);
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

TEST(VisibleMovers, WhatDeformsBouncesLightWhicheverObjectItIs)
{
    const auto light_of = [](std::size_t panel_at) {
        World world(room(panel_at));
        EXPECT_TRUE(world.scene->objects[panel_at].deforming && world.scene->objects[panel_at].dynamic);
        VisibleLight visible(world.state, world.rays, {}, world.tasks);
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

}   // namespace
}   // namespace gnomon
