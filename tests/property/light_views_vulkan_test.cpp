// SPDX-License-Identifier: Apache-2.0
// Light views on the device: updated ones equal redrawn ones to the bit, and agree with the CPU reference
// implementation.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include "light_script.h"
#include "light_views/software.h"
#include "light_views/vulkan/gpu_light_views.h"

namespace gnomon::light_views {
namespace {

class LightViewsVulkan : public test::VulkanTest {};
class LightViewsVulkanFull : public test::VulkanTest {};

LightViewsOptions small_views(int quiet_frames)
{
    LightViewsOptions options;
    options.atlas.view_size = 64;
    options.quiet_frames = quiet_frames;
    return options;
}

struct Pages {
    std::vector<vk::Buffer> depth, item;

    Pages(vk::Commands& commands, const vk::Image& depths, const vk::Image& items)
    {
        for (std::uint32_t layer = 0; layer < depths.desc().layers; ++layer) {
            depth.push_back(commands.read_back(depths, layer));
            item.push_back(commands.read_back(items, layer));
        }
    }
    // The tile of one view.
    SoftwareBuffer view(const Tile& tile, int page_size) const
    {
        SoftwareBuffer buffer(tile.size);
        const auto page = static_cast<std::size_t>(tile.page);
        for (int y = 0; y < tile.size; ++y)
            for (int x = 0; x < tile.size; ++x) {
                const auto from = static_cast<std::size_t>(tile.y + y) * static_cast<unsigned>(page_size) +
                                  static_cast<unsigned>(tile.x + x);
                buffer.depth[buffer.at(x, y)] = depth[page].as<float>()[from];
                buffer.item[buffer.at(x, y)] = item[page].as<std::uint32_t>()[from];
            }
        return buffer;
    }
};

// Three sets of the same views: updated, updated with another rest time, and replanned from nothing in every frame.
void follow_script(const std::shared_ptr<vk::Device>& device, std::uint64_t seed, int frames, bool with_reference)
{
    const test::LightScript script = test::make_light_script(seed, frames);
    scene::SceneState state(script.scene, 0);
    const int patience = seed % 2 ? 1 : 5;
    LightViews kept(state, small_views(patience)), patient(state, small_views(9)),
        redrawn(state, small_views(patience));
    CasterGeometry casters(device, state);
    GpuLightViews kept_gpu(device, kept), patient_gpu(device, patient), redrawn_gpu(device, redrawn);
    vk::Commands commands(device);
    const int page_size = kept.atlas().page_size;
    std::uint64_t different_from_reference = 0, texels = 0;
    for (int frame = 0; frame < frames; ++frame) {
        state.advance(script.time(frame));
        kept.update(state);
        patient.update(state);
        redrawn.forget();
        redrawn.update(state);
        casters.update(commands, state);
        kept_gpu.record(commands, kept, casters);
        patient_gpu.record(commands, patient, casters);
        redrawn_gpu.record(commands, redrawn, casters);
        const Pages rendering(commands, kept_gpu.depth(), kept_gpu.item()),
            expected(commands, redrawn_gpu.depth(), redrawn_gpu.item()),
            patient_rendering(commands, patient_gpu.depth(), patient_gpu.item()),
            statics(commands, kept_gpu.static_depth(), kept_gpu.static_item()),
            expected_statics(commands, redrawn_gpu.static_depth(), redrawn_gpu.static_item());
        commands.submit();
        for (std::size_t v = 0; v < kept.views().size(); ++v) {
            const LightView& view = kept.views()[v];
            if (!view.shown) continue;
            const SoftwareBuffer mine = rendering.view(view.tile, page_size),
                                 other = expected.view(view.tile, page_size);
            ASSERT_EQ(mine.depth, other.depth) << "view " << v << ", frame " << frame;
            ASSERT_EQ(mine.item, other.item) << "view " << v << ", frame " << frame;
            ASSERT_TRUE(patient_rendering.view(view.tile, page_size) == other) << "view " << v << ", frame " << frame;
            if (kept.tracker(v).statics_known()) {
                ASSERT_TRUE(statics.view(view.tile, page_size) == expected_statics.view(view.tile, page_size))
                    << "view " << v << ", frame " << frame;
            }
            if (!with_reference || frame % 10) continue;
            SoftwareBuffer reference(view.tile.size);
            for (scene::ObjectId o = 0; o < script.scene->objects.size(); ++o)
                if (kept.casters().casts(o) && state.object_visible(o))
                    draw_object(reference, view.projection, state, o, view.projection.whole());
            for (std::size_t i = 0; i < reference.depth.size(); ++i) {
                ++texels;
                const bool same = reference.item[i] == mine.item[i] &&
                                  std::abs(reference.depth[i] - mine.depth[i]) <= 1e-3f * reference.depth[i];
                different_from_reference += !same;
            }
        }
    }
    // The outlines of triangles may differ by a sub-texel.
    if (with_reference) {
        EXPECT_LT(different_from_reference, texels / 100) << texels;
    }
}

TEST_F(LightViewsVulkan, BuffersEqualAFullRedraw)
{
    follow_script(device_, 1, 15, true);
    follow_script(device_, 2, 30, false);
}

TEST_F(LightViewsVulkanFull, BuffersEqualAFullRedrawOverAThousandFrames)
{
    follow_script(device_, 31, 1000, false);
}

TEST_F(LightViewsVulkan, RecordsNothingWhileNothingMoves)
{
    scene::Scene scene = test::scene_with_balls();
    test::add_object(scene, 0);
    scene::Light light;
    light.node = scene.add_node("", scene::none, test::translation(0, 5, 0));
    scene.lights.push_back(light);
    scene::SceneState state(test::finished(scene), 0);
    LightViews views(state, small_views(1));
    CasterGeometry casters(device_, state);
    GpuLightViews gpu(device_, views);
    vk::Commands commands(device_);
    for (int frame = 0; frame < 3; ++frame) {
        state.advance(frame);
        views.update(state);
        casters.update(commands, state);
        gpu.record(commands, views, casters);
        commands.submit();
        EXPECT_EQ(commands.timings().empty(), frame > 0);
        EXPECT_EQ(commands.draw_calls() == 0, frame > 0);
    }
}

}   // namespace
}   // namespace gnomon::light_views
#endif
