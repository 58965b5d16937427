// SPDX-License-Identifier: Apache-2.0
// Selects the dynamic objects that can shadow a patch of points: the tree of bounding boxes against a linear search,
// while objects move, deform, hide and are moved by user override. No ray that a dynamic object occludes may be left
// out.
#include "visibility/dynamic_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scene_helpers.h"

namespace gnomon::test {
namespace {

using visibility::DynamicBounds;

using Corners = std::array<float, 6>;

std::vector<Corners> sorted(const std::vector<Box3>& boxes)
{
    std::vector<Corners> result;
    for (const Box3& b : boxes) result.push_back({b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z});
    std::sort(result.begin(), result.end());
    return result;
}

struct Query {
    Box3 points;
    glm::vec3 light;
    bool directional;
};

Query random_query(Random& random, float reach)
{
    const auto anywhere = [&](float r) {
        const float x = random.uniform(-r, r), y = random.uniform(-r, r);
        return glm::vec3(x, y, random.uniform(-r, r));
    };
    Query query;
    query.points.add(anywhere(reach));
    query.points.add(query.points.low + anywhere(random.below(2) ? 0.3f : 3.0f));
    query.directional = random.below(3) == 0;
    query.light = query.directional ? glm::normalize(anywhere(1)) : anywhere(1.5f * reach);
    if (random.below(4) == 0) query.light[static_cast<int>(random.below(3))] = 0;   // in the plane of an axis
    return query;
}

TEST(DynamicBounds, EqualsALinearSearchOfAllBoxes)
{
    std::size_t selected_in_all = 0, missed = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        RandomSceneOptions options;
        options.dynamic_objects = 40, options.deforming = 10, options.reach = 12;
        const auto scene = make_random_scene(seed, options);
        scene::SceneState state(scene, 0);
        ray::RayScene rays(state);
        DynamicBounds bounds(state, rays);
        Random random(seed + 70);
        const glm::dmat4 aside = translation(3, 2, 1);
        for (int step = 0; step < 12; ++step) {
            for (int q = 0; q < 60; ++q) {
                const Query query = random_query(random, 14);
                std::vector<Box3> by_tree, of_all;
                bounds.select(query.points, query.light, query.directional, by_tree);
                bounds.select_of_all(query.points, query.light, query.directional, of_all);
                EXPECT_EQ(sorted(by_tree), sorted(of_all));
                selected_in_all += of_all.size();

                // A ray from inside that a dynamic object occludes hits one of the boxes.
                const glm::vec3 from = query.points.centre();
                const glm::vec3 along = query.directional ? query.light : query.light - from;
                const float end = query.directional ? k_infinity : 1;
                if (rays.occluded_single(from, 0, along, end, ray::Against::dynamic_only))
                    missed += std::none_of(by_tree.begin(), by_tree.end(), [&](const Box3& box) {
                        return visibility::segment_meets(box, from, along, end);
                    });
            }
            if (step == 5)   // one object is moved out of its group
                state.override_transform(scene->objects[scene->groups[0].objects.back()].node, &aside);
            state.advance(0.4 * (step + 1));
            rays.update(state);
            bounds.update(state, rays);
        }
    }
    EXPECT_EQ(missed, 0u);
    EXPECT_GT(selected_in_all, 3000u);
}

// Rays from far away are rounded by more than the size of small objects near the origin.
TEST(DynamicBounds, DistantRaysHitTheBoxesOfTheirOccluders)
{
    scene::Scene made = scene_with_balls();
    scene::Mesh cube;
    for (int i = 0; i < 8; ++i)
        cube.positions.emplace_back(i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f);
    cube.triangles = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                      {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    cube.parts = {{two_sided, 0, 12}};
    made.meshes.edit(0) = cube;
    made.nodes[add_object(made, 0)].animated = true;
    scene::SceneState state(finished(made), 0);
    ray::RayScene rays(state);
    const DynamicBounds bounds(state, rays);
    const glm::dvec3 light(0.3, 4, 0.2);
    constexpr double k_far = -2000;
    Random random(3);
    std::size_t occluded = 0, missed = 0, selected = 0;
    for (int i = 0; i < 40'000; ++i) {
        // Beside an edge of the cube.
        const glm::dvec3 edge(random.below(2) ? 0.5 : -0.5, random.below(2) ? 0.5 : -0.5,
                              static_cast<double>(random.uniform(-0.5f, 0.5f)));
        const glm::dvec3 by = edge + glm::dvec3(static_cast<double>(random.uniform(-5e-4f, 5e-4f)), 0, 0);
        const glm::vec3 from(by + (k_far - by.y) / (by.y - light.y) * (by - light));
        const glm::vec3 along = glm::vec3(light) - from;
        if (!rays.occluded_single(from, 0, along, 0.9999f, ray::Against::dynamic_only)) continue;
        ++occluded;
        std::vector<Box3> boxes;
        bounds.select({from, from}, glm::vec3(light), false, boxes);
        selected += !boxes.empty();
        missed += boxes.empty() || !visibility::segment_meets(boxes[0], from, along, 0.9999f);
    }
    EXPECT_GT(occluded, 10'000u);
    EXPECT_EQ(selected, occluded);
    EXPECT_EQ(missed, 0u);
}

TEST(DynamicBounds, CostDependsOnNearbyObjectsOnly)
{
    // Small dynamic objects on a large plain, under a light: a patch of points tests those between it and the light.
    std::vector<std::size_t> looked_at;
    for (const int side : {10, 40}) {
        scene::Scene scene = scene_with_balls();
        std::uint64_t seed = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const scene::NodeId node = add_object(scene, 0);
                scene.nodes[node].transform = std::make_shared<SwayTrack>(glm::dvec3(6 * x, 6 * y, 0), seed++, 1);
            }
        scene::SceneState state(finished(scene), 0);
        ray::RayScene rays(state);
        DynamicBounds bounds(state, rays);
        state.advance(1);
        rays.update(state);
        bounds.update(state, rays);
        const glm::vec3 under(18, 18, -3);
        std::vector<Box3> selected;
        looked_at.push_back(
            bounds.select({under, under + glm::vec3(1, 1, 0)}, under + glm::vec3(2, 2, 12), false, selected));
        EXPECT_GE(selected.size(), 1u);
        EXPECT_LE(selected.size(), 6u);
    }
    EXPECT_LE(looked_at[0], 60u);
    EXPECT_LE(looked_at[1], looked_at[0] + 30) << "sixteen times the dynamic objects";
}

}   // namespace
}   // namespace gnomon::test
