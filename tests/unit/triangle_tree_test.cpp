// SPDX-License-Identifier: Apache-2.0
// Trees of many triangles, which several threads build.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "base/tasks.h"
#include "ray/portable/tree.h"
#include "ray_helpers.h"
#include "scene_helpers.h"

namespace gnomon::test {
namespace {

using ray::TreeNode;

// One mesh of 40,000 triangles, as a ray scene would store it.
struct LargeMesh {
    explicit LargeMesh(int rings) : mesh(ball(two_sided, rings, 2 * rings))
    {
        add_materials(scene);
        vertices.positions = mesh.positions;
        records.emplace_back();
        records[0].scene = &scene, records[0].mesh = &mesh, records[0].vertices = &vertices;
        records[0].triangles = static_cast<std::uint32_t>(mesh.triangles.size()), records[0].mask = 1;
    }
    scene::Scene scene;
    scene::Mesh mesh;
    ray::BakedVertices vertices;
    std::deque<ray::GeometryRecord> records;
};

// What a walk through a tree finds.
struct Walk {
    std::vector<std::uint32_t> triangles;
    std::size_t nodes = 0, blocks = 0, outside = 0;
};

void walk(const ray::TriangleTree& tree, const LargeMesh& of, std::uint32_t at, const Box3& within, Walk& walked)
{
    if (!TreeNode::is_leaf(at)) {
        ++walked.nodes;
        const TreeNode& node = tree.nodes()[at];
        for (unsigned i = 0; i < node.count; ++i)
            walk(
                tree, of, node.child[i],
                {{node.low[0][i], node.low[1][i], node.low[2][i]}, {node.high[0][i], node.high[1][i], node.high[2][i]}},
                walked);
        return;
    }
    for (std::uint32_t b = 0; b < TreeNode::items_of(at); ++b) {
        const ray::TriangleBlock& block = tree.blocks()[TreeNode::first_of(at) + b];
        ++walked.blocks;
        for (unsigned lane = 0; lane < 4 && block.mask[lane] != 0; ++lane) {
            walked.triangles.push_back(block.triangle[lane]);
            for (int c = 0; c < 3; ++c) {
                const glm::vec3& p = of.mesh.positions[of.mesh.triangles[block.triangle[lane]][c]];
                for (int axis = 0; axis < 3; ++axis) {
                    walked.outside += !(p[axis] >= within.low[axis] && p[axis] <= within.high[axis]);
                    walked.outside += block.corner[c][axis][lane] != p[axis];
                }
            }
        }
    }
}

// Small trees are of one part, large ones of many.
TEST(TriangleTree, HoldsEveryTriangleOnceInBoxesAroundIt)
{
    for (const int rings : {6, 100}) {
        const LargeMesh of(rings);
        ray::TriangleTree tree;
        tree.build(of.records);
        Walk walked;
        walk(tree, of, 0, tree.box(), walked);
        EXPECT_EQ(walked.outside, 0u);
        std::sort(walked.triangles.begin(), walked.triangles.end());
        ASSERT_EQ(walked.triangles.size(), of.mesh.triangles.size());
        for (std::uint32_t t = 0; t < walked.triangles.size(); ++t) ASSERT_EQ(walked.triangles[t], t);
        EXPECT_EQ(tree.bytes(), walked.nodes * sizeof(TreeNode) + walked.blocks * sizeof(ray::TriangleBlock));
    }
}

TEST(TriangleTree, IsTheSameForAnyNumberOfThreads)
{
    const LargeMesh of(150);   // more than two chunks of its top are binned
    ASSERT_GT(of.mesh.triangles.size(), 40000u);
    ray::TriangleTree alone;
    alone.build(of.records);
    Walk walked;
    walk(alone, of, 0, alone.box(), walked);
    for (const int threads : {1, 3, 8}) {
        Tasks tasks(threads);
        ray::TriangleTree shared;
        shared.build(of.records, &tasks);
        ASSERT_EQ(shared.bytes(), alone.bytes());
        EXPECT_EQ(std::memcmp(shared.nodes(), alone.nodes(), walked.nodes * sizeof(TreeNode)), 0) << threads;
        EXPECT_EQ(std::memcmp(shared.blocks(), alone.blocks(), walked.blocks * sizeof(ray::TriangleBlock)), 0)
            << threads;
    }
}

TEST(TriangleTree, RaysMeetWhatEmbreeMeetsInALargeOne)
{
    scene::Scene scene;
    add_materials(scene);
    scene.meshes.push_back(ball(two_sided, 60, 90));
    Random random(5);
    for (int i = 0; i < 9; ++i) add_object(scene, 0, scene::none, random_placement(random, 5));
    const scene::SceneState state(finished(scene), 0);
    Tasks tasks(3);
    const ray::RayScene portable(state, MemoryLimit{}, Arithmetic::portable, &tasks);
    const ray::RayScene embree(state, MemoryLimit{}, Arithmetic::native);
    const ray::RayQueue queue = random_rays(5, 4000);
    const Answers expected = trace(embree, queue), found = trace(portable, queue);
    std::size_t differ = 0, hits = 0;
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const ray::Hit &a = expected.both[i], &b = found.both[i];
        hits += a.object != scene::none;
        differ += a.object != b.object || (a.object != scene::none && a.triangle != b.triangle);
        differ += expected.occluded[i] != found.occluded[i];
    }
    EXPECT_GT(hits, 500u);
    EXPECT_LE(differ, 4u);
}

}   // namespace
}   // namespace gnomon::test
