// SPDX-License-Identifier: Apache-2.0
// Updated light views equal redrawn ones to the bit, whatever moves and whichever objects count as dynamic.
#include "light_views/light_views.h"

#include <gtest/gtest.h>

#include "light_script.h"
#include "light_views/software.h"

namespace gnomon::light_views {
namespace {

LightViewsOptions small_views(int quiet_frames = 4)
{
    LightViewsOptions options;
    options.atlas.view_size = 64;
    options.quiet_frames = quiet_frames;
    return options;
}

// Draws all visible casters, or the static ones only, from scratch.
SoftwareBuffer redraw(const LightView& view, const LightViews& views, const scene::SceneState& state, bool all)
{
    SoftwareBuffer buffer(view.tile.size);
    for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
        if (!views.casters().casts(o) || !state.object_visible(o) || (!all && views.is_dynamic(o))) continue;
        draw_object(buffer, view.projection, state, o, view.projection.whole());
    }
    return buffer;
}

std::vector<SoftwareView> buffers_for(const LightViews& views)
{
    std::vector<SoftwareView> buffers;
    for (const LightView& view : views.views()) buffers.emplace_back(view.tile.size);
    return buffers;
}

struct Seen {
    std::uint64_t kinds[4] = {}, settles = 0, rebuilds = 0, ties = 0;
};

void follow_script(std::uint64_t seed, int frames, Seen& seen)
{
    const test::LightScript script = test::make_light_script(seed, frames);
    scene::SceneState state(script.scene, 0);
    LightViews views(state, small_views(seed % 2 ? 1 : 5));
    std::vector<SoftwareView> buffers = buffers_for(views);
    Random random(seed);
    for (int frame = 0; frame < frames; ++frame) {
        // Advance; sometimes pause, or jump back a little.
        const int at = random.below(20) == 0 ? std::max(0, frame - 3) : frame;
        state.advance(script.time(at));
        if (random.below(10) == 0)
            views.set_override(random.below(static_cast<std::uint32_t>(script.scene->objects.size())),
                               static_cast<scene::MobilityOverride>(random.below(3)));
        views.update(state);
        for (std::size_t v = 0; v < buffers.size(); ++v) {
            const LightView& view = views.views()[v];
            seen.kinds[static_cast<int>(view.plan.kind)]++;
            seen.settles += view.plan.settle.size();
            seen.rebuilds += view.plan.rebuild.size();
            if (!view.shown) continue;
            buffers[v].execute(view.plan, view.projection, state);
            const SoftwareBuffer everything = redraw(view, views, state, true);
            ASSERT_EQ(buffers[v].rendering().depth, everything.depth) << "view " << v << ", frame " << frame;
            ASSERT_EQ(buffers[v].rendering().item, everything.item) << "view " << v << ", frame " << frame;
            if (!views.tracker(v).statics_known()) continue;
            const SoftwareBuffer statics = redraw(view, views, state, false);
            ASSERT_TRUE(buffers[v].statics() == statics) << "view " << v << ", frame " << frame;
        }
    }
}

TEST(LightViews, BuffersEqualAFullRedraw)
{
    Seen seen;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) follow_script(seed, 60, seen);
    // The scripts were varied enough.
    for (const std::uint64_t count : seen.kinds) EXPECT_GT(count, 10u);
    EXPECT_GT(seen.settles, 50u);
    EXPECT_GT(seen.rebuilds, 50u);
}

TEST(LightViewsFull, BuffersEqualAFullRedrawOverAThousandFrames)
{
    Seen seen;
    for (std::uint64_t seed = 11; seed <= 12; ++seed) follow_script(seed, 1000, seen);
}

}   // namespace
}   // namespace gnomon::light_views
