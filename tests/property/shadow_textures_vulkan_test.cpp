// SPDX-License-Identifier: Apache-2.0
// Shadow textures on the device: a coherent update equals a full redraw to the bit, the methods agree, and the item
// buffer equals all textures.
#include "api/scene_access.h"
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <cstring>

#include "gnomon/gnomon.h"
#include "light_script.h"
#include "scene/builtin/builtin.h"
#include "shadow_textures/software_textures.h"
#include "shadow_textures/vulkan/gpu_textures.h"
#include "support.h"

namespace gnomon::shadow_textures {
namespace {

using light_views::LightView;
using light_views::LightViews;
using light_views::LightViewsOptions;
using light_views::Rect;

class ShadowTexturesVulkan : public test::VulkanTest {};
class ShadowTexturesVulkanFull : public test::VulkanTest {};

LightViewsOptions small_views(bool coherence)
{
    LightViewsOptions options;
    options.atlas.view_size = 64;
    options.quiet_frames = 3;
    options.coherence = coherence;
    options.receivers = true;
    return options;
}

// Extracts one receiver's texture from the data that was read back.
ReceiverTexture texture_of(const GpuTextures& textures, const vk::Buffer& words, std::size_t view,
                           scene::ObjectId object, const Rect& rect)
{
    ReceiverTexture texture{rect, {}};
    const shared::TexturePlace& place = textures.place(view, object);
    EXPECT_EQ(place.row_words, ReceiverTexture::row_words(rect));
    const auto all = words.as<std::uint32_t>();
    const std::size_t count = ReceiverTexture::row_words(rect) * static_cast<std::size_t>(rect.height());
    texture.bits.assign(all.begin() + place.first_word,
                        all.begin() + place.first_word + static_cast<std::ptrdiff_t>(count));
    return texture;
}

void follow_script(const std::shared_ptr<vk::Device>& device, std::uint64_t seed, int frames, int casters_every)
{
    const test::LightScript script = test::make_light_script(seed, frames);
    scene::SceneState state(script.scene, 0);
    LightViews coherent(state, small_views(true)), redrawn(state, small_views(false));
    light_views::CasterGeometry casters(device, state);
    light_views::GpuLightViews coherent_buffers(device, coherent), redrawn_buffers(device, redrawn);
    GpuTextures coherent_textures(device, coherent), by_depth(device, redrawn), by_casters(device, redrawn);
    vk::Commands commands(device);
    std::uint64_t updated = 0, made = 0, item_faults = 0, ties = 0;
    for (int frame = 0; frame < frames; ++frame) {
        state.advance(script.time(frame));
        coherent.update(state);
        redrawn.update(state);
        casters.update(commands, state);
        coherent_buffers.record(commands, coherent, casters);
        coherent_textures.record(commands, coherent, coherent_buffers, casters, state);
        redrawn_buffers.record(commands, redrawn, casters);
        by_depth.record(commands, redrawn, redrawn_buffers, casters, state);
        const bool with_casters = casters_every > 0 && frame % casters_every == 0;
        if (with_casters) by_casters.record_per_caster(commands, redrawn, casters, state);
        const vk::Buffer kept = commands.read_back(coherent_textures.textures()),
                         full = commands.read_back(by_depth.textures());
        const vk::Buffer between = with_casters ? commands.read_back(by_casters.textures()) : vk::Buffer();
        std::vector<vk::Buffer> items;
        for (std::uint32_t page = 0; page < coherent_buffers.item().desc().layers; ++page)
            items.push_back(commands.read_back(coherent_buffers.item(), page));
        commands.submit();
        updated += coherent_textures.counts().updated;
        made += by_depth.counts().updated;

        for (std::size_t v = 0; v < coherent.views().size(); ++v) {
            const LightView& view = coherent.views()[v];
            if (!view.shown) continue;
            const auto texels = static_cast<std::size_t>(view.tile.size) * static_cast<unsigned>(view.tile.size);
            std::vector<std::uint32_t> highest(texels, 0), count(texels, 0);
            for (scene::ObjectId o = 0; o < script.scene->objects.size(); ++o) {
                const Rect rect = coherent.casters().footprint(view.projection, state, o);
                if (rect.empty()) continue;
                const ReceiverTexture expected = texture_of(by_depth, full, v, o, rect);
                ASSERT_TRUE(texture_of(coherent_textures, kept, v, o, rect) == expected)
                    << "object " << o << ", view " << v << ", frame " << frame;
                if (with_casters) {
                    ASSERT_TRUE(texture_of(by_casters, between, v, o, rect) == expected)
                        << "object " << o << ", view " << v << ", frame " << frame;
                }
                for (int y = rect.y0; y < rect.y1; ++y)
                    for (int x = rect.x0; x < rect.x1; ++x)
                        if (expected.lit(x, y)) {
                            const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.tile.size) +
                                            static_cast<std::size_t>(x);
                            highest[at] = o + 1;
                            ++count[at];
                        }
            }
            for (int y = 0; y < view.tile.size; ++y)
                for (int x = 0; x < view.tile.size; ++x) {
                    const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.tile.size) +
                                    static_cast<std::size_t>(x);
                    const auto in_page = static_cast<std::size_t>(view.tile.y + y) *
                                             static_cast<std::size_t>(coherent.atlas().page_size) +
                                         static_cast<std::size_t>(view.tile.x + x);
                    item_faults +=
                        items[static_cast<std::size_t>(view.tile.page)].as<std::uint32_t>()[in_page] != highest[at];
                    ties += count[at] > 1;
                }
        }
    }
    EXPECT_EQ(item_faults, 0u);
    EXPECT_GT(ties, 0u);
    EXPECT_LT(updated, made);
}

// Compares one tile of the atlas in both images.
bool same_square(const vk::Buffer& a, const vk::Buffer& b, const light_views::Tile& tile, int page_size)
{
    const auto mine = a.as<std::uint32_t>(), other = b.as<std::uint32_t>();
    for (int y = tile.y; y < tile.y + tile.size; ++y) {
        const auto row = static_cast<std::size_t>(y) * static_cast<unsigned>(page_size) + static_cast<unsigned>(tile.x);
        const auto size = static_cast<std::size_t>(tile.size);
        if (std::memcmp(&mine[row], &other[row], size * sizeof(std::uint32_t)) != 0) return false;
    }
    return true;
}

// Renders the frames of a clip in sequence and compares the rendering buffers of all views.
void follow_video(const std::shared_ptr<vk::Device>& device, const std::shared_ptr<const scene::Scene>& scene,
                  int first, int last)
{
    scene::SceneState state(scene, scene->timeline.time_of(first));
    LightViewsOptions kept_options, redrawn_options;
    kept_options.atlas.view_size = redrawn_options.atlas.view_size = 128;
    redrawn_options.coherence = false;
    LightViews coherent(state, kept_options), redrawn(state, redrawn_options);
    light_views::CasterGeometry casters(device, state);
    light_views::GpuLightViews coherent_buffers(device, coherent), redrawn_buffers(device, redrawn);
    vk::Commands commands(device);
    std::uint64_t draws = 0, all_draws = 0;
    for (int frame = first; frame <= last; ++frame) {
        state.advance(scene->timeline.time_of(frame));
        coherent.update(state);
        redrawn.update(state);
        casters.update(commands, state);
        coherent_buffers.record(commands, coherent, casters);
        redrawn_buffers.record(commands, redrawn, casters);
        std::vector<vk::Buffer> mine, others;
        for (std::uint32_t page = 0; page < redrawn_buffers.depth().desc().layers; ++page) {
            mine.push_back(commands.read_back(coherent_buffers.depth(), page));
            mine.push_back(commands.read_back(coherent_buffers.item(), page));
            others.push_back(commands.read_back(redrawn_buffers.depth(), page));
            others.push_back(commands.read_back(redrawn_buffers.item(), page));
        }
        commands.submit();
        if (frame > first) draws += coherent.counts().draws, all_draws += redrawn.counts().draws;
        for (std::size_t v = 0; v < coherent.views().size(); ++v) {
            const LightView& view = coherent.views()[v];
            if (!view.shown) continue;
            for (const std::size_t layer : {0u, 1u}) {
                const std::size_t at = 2 * static_cast<std::size_t>(view.tile.page) + layer;
                ASSERT_TRUE(same_square(mine[at], others[at], view.tile, coherent.atlas().page_size))
                    << "view " << v << ", frame " << frame << (layer ? ", items" : ", depths");
            }
        }
    }
    EXPECT_LT(2 * draws, all_draws);   // it did skip draws
}

TEST_F(ShadowTexturesVulkan, VideoOfKineticEqualsAFullRedraw)
{
    follow_video(device_, std::make_shared<const scene::Scene>(scene::make_kinetic()), 38, 41);
}

TEST_F(ShadowTexturesVulkanFull, VideoOfKineticEqualsAFullRedraw)
{
    follow_video(device_, std::make_shared<const scene::Scene>(scene::make_kinetic()), 1, 120);
}

TEST_F(ShadowTexturesVulkanFull, VideoOfKitchenEqualsAFullRedraw)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    follow_video(device_, api::scene_of(load(file.string())), 1, 800);
}

TEST_F(ShadowTexturesVulkan, CoherentUpdateEqualsAFullRedrawAndMethodsAgree)
{
    follow_script(device_, 1, 15, 7);
}

TEST_F(ShadowTexturesVulkanFull, CoherentUpdateEqualsAFullRedrawOverAThousandFrames)
{
    follow_script(device_, 5, 1000, 100);
}

}   // namespace
}   // namespace gnomon::shadow_textures
#endif
