// SPDX-License-Identifier: Apache-2.0
// Lights that move in every frame, in an otherwise unchanged scene.
#include <gtest/gtest.h>

#include "bench/core/moving_lights.h"
#include "scene/builtin/builtin.h"
#include "scene/state.h"

namespace gnomon::bench {
namespace {

TEST(MovingLights, MovesEveryLightInEveryFrameAndNothingElse)
{
    for (const char* name : {"kinetic", "cornell"}) {
        SCOPED_TRACE(name);
        const auto still = std::make_shared<const scene::Scene>(scene::make_builtin(name));
        const auto moving = with_moving_lights(still);
        ASSERT_GT(still->lights.size(), 0u);
        const Box3 box = still->bounds(0);
        const float far = 0.01f * glm::length(box.high - box.low);
        scene::SceneState a(still, still->timeline.time_of(1)), b(moving, moving->timeline.time_of(1));
        for (int frame = 2; frame <= 12; ++frame) {
            const scene::FrameChanges& before = a.advance(still->timeline.time_of(frame));
            const scene::FrameChanges& now = b.advance(moving->timeline.time_of(frame));
            EXPECT_EQ(now.lights_moved.size(), moving->lights.size());
            EXPECT_EQ(now.moved, before.moved);
            EXPECT_EQ(now.deformed, before.deformed);
            EXPECT_EQ(now.camera_moved, before.camera_moved);
            for (scene::LightId l = 0; l < still->lights.size(); ++l) {
                EXPECT_LT(glm::length(a.light(l).position - b.light(l).position), far);
                EXPECT_GT(glm::dot(a.light(l).direction, b.light(l).direction), 0.99f);
                EXPECT_EQ(a.light(l).visible, b.light(l).visible);
            }
        }
    }
}

TEST(MovingLights, KeepsTheIndexOfChildrenValid)
{
    const auto moving = with_moving_lights(std::make_shared<const scene::Scene>(scene::make_builtin("kinetic")));
    ASSERT_EQ(moving->child_begin.size(), moving->nodes.size() + 1);
    std::size_t seen = 0;
    for (scene::NodeId n = 0; n < moving->nodes.size(); ++n)
        for (std::uint32_t c = moving->child_begin[n]; c < moving->child_begin[n + 1]; ++c, ++seen)
            EXPECT_EQ(moving->nodes[moving->child_list[c]].parent, n);
    EXPECT_EQ(seen, moving->child_list.size());
}

}   // namespace
}   // namespace gnomon::bench
