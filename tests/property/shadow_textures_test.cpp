// SPDX-License-Identifier: Apache-2.0
// Shadow textures: the three methods agree, a coherent update equals a full redraw, and the item buffer equals all
// textures.
#include "shadow_textures/software_textures.h"

#include <gtest/gtest.h>

#include "light_script.h"

namespace gnomon::shadow_textures {
namespace {

using light_views::LightView;
using light_views::LightViews;
using light_views::LightViewsOptions;
using light_views::Rect;
using light_views::SoftwareBuffer;
using light_views::SoftwareView;

LightViewsOptions small_views(int quiet_frames)
{
    LightViewsOptions options;
    options.atlas.view_size = 64;
    options.quiet_frames = quiet_frames;
    options.receivers = true;
    return options;
}

// Calls body(view, rendering buffer, v) for every visible view of every frame.
template <class Body>
void follow(std::uint64_t seed, int frames, int step, const Body& body)
{
    const test::LightScript script = test::make_light_script(seed, frames);
    scene::SceneState state(script.scene, 0);
    LightViews views(state, small_views(seed % 2 ? 1 : 5));
    std::vector<SoftwareView> buffers;
    for (const LightView& view : views.views()) buffers.emplace_back(view.tile.size);
    for (int frame = 0; frame < frames; frame += step) {
        state.advance(script.time(frame));
        views.update(state);
        for (std::size_t v = 0; v < buffers.size(); ++v) {
            const LightView& view = views.views()[v];
            if (!view.shown) continue;
            buffers[v].execute(view.plan, view.projection, state);
            body(views, state, view, buffers[v].rendering(), v);
            if (testing::Test::HasFatalFailure()) return;
        }
    }
}

void follow_coherently(std::uint64_t seed, int frames, std::uint64_t& updated, std::uint64_t& made)
{
    std::map<std::size_t, CoherentTextures> kept;
    follow(seed, frames, 1,
           [&](const LightViews& views, const scene::SceneState& state, const LightView& view,
               const SoftwareBuffer& everything, std::size_t v) {
               kept[v].update(view, everything, views.casters(), state);
               updated += kept[v].updated();
               std::size_t present = 0;
               for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
                   const Rect rect = views.casters().footprint(view.projection, state, o);
                   if (rect.empty()) continue;
                   ++present;
                   const auto found = kept[v].textures().find(o);
                   ASSERT_NE(found, kept[v].textures().end());
                   ASSERT_TRUE(found->second == texture_by_depth(view.projection, everything, state, o, rect))
                       << "object " << o << ", view " << v;
               }
               ASSERT_EQ(kept[v].textures().size(), present);
               made += present;
           });
}

TEST(ShadowTextures, CoherentUpdateEqualsAFullRedraw)
{
    std::uint64_t updated = 0, made = 0;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) follow_coherently(seed, 40, updated, made);
    EXPECT_LT(updated, made * 3 / 4);   // the scripts move many objects
}

TEST(ShadowTexturesFull, CoherentUpdateEqualsAFullRedrawOverAThousandFrames)
{
    std::uint64_t updated = 0, made = 0;
    follow_coherently(21, 1000, updated, made);
}

TEST(ShadowTextures, MethodsAgree)
{
    std::uint64_t lit = 0;
    follow(3, 40, 19,
           [&](const LightViews& views, const scene::SceneState& state, const LightView& view,
               const SoftwareBuffer& everything, std::size_t v) {
               for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
                   const Rect rect = views.casters().footprint(view.projection, state, o);
                   if (rect.empty()) continue;
                   const ReceiverTexture texture = texture_by_depth(view.projection, everything, state, o, rect);
                   ASSERT_TRUE(texture == texture_by_casters(view.projection, views.casters(), state, o, rect))
                       << "object " << o << ", view " << v;
                   for (const std::uint32_t word : texture.bits) lit += word != 0;
               }
           });
    EXPECT_GT(lit, 1000u);
}

// One item buffer holds all textures of a view: a set bit and the receiver's own number are equivalent, except where
// several objects have the same depth; there the item is the highest of those whose bit is set.
TEST(ShadowTextures, ItemBufferEqualsAllTexturesOfAView)
{
    std::uint64_t texels = 0, ties = 0;
    follow(2, 60, 7,
           [&](const LightViews& views, const scene::SceneState& state, const LightView& view,
               const SoftwareBuffer& everything, std::size_t) {
               const auto n = everything.item.size();
               std::vector<std::uint32_t> highest(n, 0), count(n, 0);
               for (scene::ObjectId o = 0; o < state.scene().objects.size(); ++o) {
                   const Rect rect = views.casters().footprint(view.projection, state, o);
                   if (rect.empty()) continue;
                   const ReceiverTexture texture = texture_by_depth(view.projection, everything, state, o, rect);
                   const ReceiverTexture items = texture_by_items(everything, o, rect);
                   for (int y = rect.y0; y < rect.y1; ++y)
                       for (int x = rect.x0; x < rect.x1; ++x) {
                           if (items.lit(x, y)) {
                               ASSERT_TRUE(texture.lit(x, y));
                           }
                           if (!texture.lit(x, y)) continue;
                           highest[everything.at(x, y)] = o + 1;
                           ++count[everything.at(x, y)];
                       }
               }
               for (std::size_t i = 0; i < n; ++i) {
                   ASSERT_EQ(highest[i], everything.item[i]);
                   texels += count[i] > 0;
                   ties += count[i] > 1;
               }
           });
    EXPECT_GT(texels, 10000u);
    EXPECT_GT(ties, 100u);   // the scripts contain exact duplicates
    EXPECT_LT(ties, texels / 4);
}

}   // namespace
}   // namespace gnomon::shadow_textures
