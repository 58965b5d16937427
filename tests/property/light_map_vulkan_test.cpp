// SPDX-License-Identifier: Apache-2.0
// Light maps on the device: updated ones equal rebuilt ones to the bit while objects move, and images lit by them are
// the same with cold and warm caches.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <cstring>

#include "gnomon/gnomon.h"
#include "light_quadtree/vulkan/gpu_map_light.h"
#include "light_script.h"

namespace gnomon {
namespace {

using light_quadtree::GpuLightMap;

class LightMapVulkanProperty : public test::VulkanTest {};
class LightMapVulkanFull : public test::VulkanTest {};

bool same_bytes(const vk::Buffer& a, const vk::Buffer& b)
{
    return a.bytes() == b.bytes() && std::memcmp(a.mapped(), b.mapped(), a.bytes()) == 0;
}

void follow_script(const std::shared_ptr<vk::Device>& device, std::uint64_t seed, int frames)
{
    const test::LightScript script = test::make_light_script(seed, frames);
    scene::SceneState state(script.scene, 0);
    light_quadtree::LightMapOptions options;
    options.side = 64;
    const light_quadtree::CutLevels levels;
    gpu_scene::GpuScene scene(device, state);
    GpuLightMap kept(device, state, options, levels);
    vk::Commands commands(device);
    kept.record(commands, scene, state);
    commands.submit();
    std::uint64_t updated_texels = 0, rebuilt_texels = 0;
    for (int frame = 1; frame < frames; ++frame) {
        state.advance(script.time(frame));
        scene.update(commands, state);
        kept.record(commands, scene, state);
        GpuLightMap rebuilt(device, state, options, levels);
        rebuilt.record(commands, scene, state);
        const vk::Buffer nodes = commands.read_back(kept.nodes()), valid = commands.read_back(kept.shares()),
                         counts = commands.read_back(kept.counts()), new_nodes = commands.read_back(rebuilt.nodes()),
                         new_valid = commands.read_back(rebuilt.shares()),
                         new_counts = commands.read_back(rebuilt.counts());
        commands.submit();
        ASSERT_TRUE(same_bytes(nodes, new_nodes)) << "frame " << frame;
        ASSERT_TRUE(same_bytes(valid, new_valid)) << "frame " << frame;
        ASSERT_TRUE(same_bytes(counts, new_counts)) << "frame " << frame;
        updated_texels += kept.work().texels, rebuilt_texels += rebuilt.work().texels;
    }
    EXPECT_GT(updated_texels, 0u);
    EXPECT_LT(updated_texels, rebuilt_texels);
}

TEST_F(LightMapVulkanProperty, UpdateEqualsARebuild)
{
    follow_script(device_, 3, 10);
    follow_script(device_, 4, 10);
}

TEST_F(LightMapVulkanFull, UpdateEqualsARebuildOverManyFrames)
{
    follow_script(device_, 5, 300);
}

TEST_F(LightMapVulkanProperty, SameImagesColdAndWarm)
{
    const Scene scene = load("builtin:cornell");
    for (const Indirect how : {Indirect::quadtree, Indirect::rsm, Indirect::visible}) {
        RenderOptions options;
        options.renderer = RenderMethod::raster;
        options.size = {64, 64};
        options.indirect = how;
        Renderer warm(options), cold(options);
        for (const int frame : {1, 5, 5}) warm.render(scene, frame);
        EXPECT_EQ(warm.render(scene, 8).layers[0].copy(), cold.render(scene, 8).layers[0].copy())
            << static_cast<int>(how);
    }
}

}   // namespace
}   // namespace gnomon

#else
TEST(LightMapVulkanProperty, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif
