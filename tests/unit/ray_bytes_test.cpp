// SPDX-License-Identifier: Apache-2.0
// The memory that a ray scene reports.
#include <gtest/gtest.h>

#include "ray/ray_scene.h"
#include "scene_helpers.h"

namespace gnomon::test {
namespace {

// Shrinks the whole mesh to a point every other second.
class Shrinking final : public scene::WeightsTrack {
 public:
    void evaluate(double time, std::vector<float>& weights) const override
    {
        weights.assign(1, static_cast<int>(time) % 2 ? 1.0f : 0.0f);
    }
    std::vector<scene::Interval> changing() const override { return {{0, 1e6}}; }
};

// A mesh that shrinks to a point is rebuilt, not refitted: it alternates, and must not use more memory each time.
TEST(RaySceneBytes, StayConstantOverRefits)
{
    auto made = std::make_shared<scene::Scene>();
    made->materials.emplace_back();
    scene::Mesh mesh;
    for (int i = 0; i < 1000; ++i) {
        const float x = static_cast<float>(i);
        mesh.positions.insert(mesh.positions.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0}});
        mesh.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
    }
    mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
    mesh.parts = {{0, 0, 1000}};
    scene::MorphTarget target;
    for (const glm::vec3& p : mesh.positions) target.positions.push_back(-p);
    mesh.morph_targets = {target};
    mesh.morph_weights = {0};
    made->meshes.push_back(mesh);
    const scene::NodeId node = made->add_node("thing", scene::none);
    made->nodes[node].mesh = 0;
    made->nodes[node].weights = std::make_shared<Shrinking>();
    made->timeline.end = 100, made->timeline.frames = 101, made->timeline.fps = 1;
    made->finish();

    scene::SceneState state(made, 0);
    ray::RayScene rays(state);
    const auto after = [&](int second) {
        state.advance(second);
        rays.update(state);
        return rays.statistics().bytes;
    };
    after(1);
    const std::uint64_t once = after(2);
    for (int second = 3; second < 40; ++second) after(second);
    EXPECT_LE(after(40), once + once / 10);
}

}   // namespace
}   // namespace gnomon::test
