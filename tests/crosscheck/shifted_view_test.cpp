// SPDX-License-Identifier: Apache-2.0
// The rasterised frame of a view with a lens shift against rays: the same surfaces at the same pixels.
#include <gtest/gtest.h>

#include "frame/frame_engine.h"
#include "scene/builtin/builtin.h"
#include "vk_helpers.h"

namespace gnomon::frame {
namespace {

#ifdef GNOMON_VULKAN
class ShiftedViewCrosscheck : public test::VulkanTest {};

constexpr Size k_size{96, 72};
constexpr float k_depth_tolerance = 1e-3f;   // relative: the same surface
constexpr double k_most_different = 0.01;    // of the pixels: at edges

// Depth of a frame by one of the renderers.
ImageF depth_of(const std::shared_ptr<const scene::Scene>& scene, RenderMethod method, bool orthographic,
                const glm::vec2& shift)
{
    RenderOptions options;
    options.renderer = method;
    options.indirect = Indirect::off;
    options.max_depth = 0;
    options.layers = true;
    FrameEngine engine;
    engine.advance(scene, 0.3, options);
    scene::View view = engine.make_view(0, k_size);
    if (orthographic) {
        view.orthographic = true;
        view.right *= 3, view.up *= 3;
        view.pixel_spread = 0, view.pixel_width = 2 * glm::length(view.up) / static_cast<float>(k_size.height);
    }
    view.shift = shift;
    engine.render(view);
    return engine.buffers().depth;
}

TEST_F(ShiftedViewCrosscheck, RasterisedFramesShowWhatRaysSee)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    for (const bool orthographic : {false, true}) {
        const ImageF plain = depth_of(scene, RenderMethod::trace, orthographic, {0, 0});
        for (const glm::vec2 shift : {glm::vec2(0.4f, -0.3f), glm::vec2(-1.2f, 0.1f), glm::vec2(0, 0.9f)}) {
            const ImageF traced = depth_of(scene, RenderMethod::trace, orthographic, shift);
            const ImageF drawn = depth_of(scene, RenderMethod::raster, orthographic, shift);
            std::size_t seen = 0, different = 0, moved = 0;
            for (std::size_t i = 0; i < traced.data.size(); ++i) {
                const float a = traced.data[i], b = drawn.data[i];
                seen += a > 0;
                different += std::abs(a - b) > k_depth_tolerance * std::max(a, b);
                moved += std::abs(a - plain.data[i]) > k_depth_tolerance * a;
            }
            const auto all = static_cast<double>(traced.data.size());
            EXPECT_GT(static_cast<double>(seen), 0.2 * all);
            EXPECT_GT(static_cast<double>(moved), 0.1 * all) << "the shift has an effect";
            EXPECT_LT(static_cast<double>(different), k_most_different * all) << shift.x << " " << shift.y;
        }
    }
}
#else
TEST(ShiftedViewCrosscheck, SkippedWithoutVulkan)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif

}   // namespace
}   // namespace gnomon::frame
