// SPDX-License-Identifier: Apache-2.0
// The portable ray tracer against Embree, and what both promise.
#include <gtest/gtest.h>

#include "ray_helpers.h"
#include "scene_helpers.h"

namespace gnomon::test {
namespace {

using scene::SceneState;

ray::RayScene native(const SceneState& state)
{
    return ray::RayScene(state, MemoryLimit{}, Arithmetic::native);
}

TEST(PortableRays, AgreeWithEmbreeExceptAtEdges)
{
    std::size_t traced = 0, differ = 0, occluded = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const SceneState state(make_random_scene(seed), 0.4 * static_cast<double>(seed));
        const ray::RayScene embree = native(state), portable(state);
        const ray::RayQueue queue = random_rays(seed, 4000);
        const Answers expected = trace(embree, queue), found = trace(portable, queue);
        EXPECT_GT(count_hits(found), 500u);
        for (std::size_t i = 0; i < queue.size(); ++i) {
            const ray::Hit &a = expected.front[i], &b = found.front[i];
            const bool same = a.object == b.object && (a.object == scene::none || a.triangle == b.triangle);
            differ += !same;
            if (same && a.object != scene::none) {
                // A grazing hit is less exact in Embree, and in object space.
                EXPECT_NEAR(a.t, b.t, 1e-3f * a.t) << "seed " << seed << ", ray " << i;
            }
            occluded += expected.occluded[i] != found.occluded[i];
            ++traced;
        }
    }
    EXPECT_LE(differ, traced / 2000) << "of " << traced;
    EXPECT_LE(occluded, traced / 2000) << "of " << traced;
}

// The last object wins, in any tree.
TEST(PortableRays, EqualDistancesAreThoseOfTheLastObject)
{
    scene::Scene scene = scene_with_balls();
    for (int i = 0; i < 4; ++i) add_object(scene, 0);
    const SceneState state(finished(scene), 0);
    const ray::RayScene rays(state);
    const ray::RayQueue queue = random_rays(3, 2000, 4);
    const Answers answers = trace(rays, queue);
    EXPECT_GT(count_hits(answers), 100u);
    for (const ray::Hit& hit : answers.both) {
        if (hit.object == scene::none) continue;
        EXPECT_EQ(hit.object, 3u);
    }
}

TEST(PortableRays, EmbreesPacketsStillEqualItsSingleRays)
{
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const SceneState state(make_random_scene(seed), 0.3 * static_cast<double>(seed));
        const ray::RayScene rays = native(state);
        const ray::RayQueue queue = random_rays(seed, 4003);
        EXPECT_EQ(differences(trace(rays, queue), trace_singly(rays, queue)), 0u) << "seed " << seed;
    }
}

TEST(PortableRays, EmbreesUpdateStillEqualsAFreshScene)
{
    const auto scene = make_random_scene(2);
    const ray::RayQueue queue = random_rays(2, 3000);
    SceneState state(scene, 0);
    ray::RayScene followed = native(state);
    for (const double time : {0.7, 2.5, 4.9, 0.1}) {
        state.advance(time);
        followed.update(state);
        const SceneState at_once(scene, time);
        EXPECT_EQ(differences(trace(followed, queue), trace(native(at_once), queue)), 0u) << "time " << time;
    }
}

}   // namespace
}   // namespace gnomon::test
