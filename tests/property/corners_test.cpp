// SPDX-License-Identifier: Apache-2.0
// Where surfaces meet: a pixel whose hit lies on the very edge is lit as those around it.
#include <gtest/gtest.h>

#include "trace/traced_frame.h"
#include "world.h"

namespace gnomon {
namespace {

TEST(Corners, NoPixelOnAnEdgeIsInTheShadowOfTheOtherSurface)
{
    // The box's edges run through the centres of pixels here.
    test::World world("cornell", 1, 2);
    trace::TracedOptions options;
    options.layers = true;
    shading::FrameBuffers buffers;
    constexpr int k_size = 512;
    trace::trace_frame(world.state, world.rays, scene::make_view(world.state, 0, {k_size, k_size}), options,
                       world.tasks, buffers, {});
    const auto lit = [&](int x, int y) {
        const auto at = 3 * (static_cast<std::size_t>(y) * k_size + static_cast<std::size_t>(x));
        return buffers.direct.data[at] + buffers.direct.data[at + 1] + buffers.direct.data[at + 2] > 0;
    };
    int lonely = 0, all = 0;
    for (int y = 1; y + 1 < k_size; ++y)
        for (int x = 1; x + 1 < k_size; ++x) {
            all += lit(x, y);
            int around = 0;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) around += lit(x + dx, y + dy);
            lonely += around == 8 && !lit(x, y);
        }
    EXPECT_GT(all, k_size * k_size / 4);
    EXPECT_EQ(lonely, 0);
}

TEST(Corners, PointsOffAnEdgeStayInTheirTriangle)
{
    for (const float u : {-1e-7f, 0.0f, 1e-6f, 0.3f, 0.5f, 0.999999f, 1.0f, 1.0000001f})
        for (const float v : {-1e-7f, 0.0f, 1e-6f, 0.3f, 0.5f, 0.999999f, 1.0f}) {
            if (u + v > 1.000001f) continue;
            const glm::vec2 off = ray::off_edges(u, v);
            EXPECT_GT(off.x, 0) << u << " " << v;
            EXPECT_GT(off.y, 0) << u << " " << v;
            EXPECT_LT(off.x + off.y, 1) << u << " " << v;
            EXPECT_LT(glm::length(off - glm::vec2(u, v)), 2e-5f) << u << " " << v;
        }
    EXPECT_EQ(ray::off_edges(0.25f, 0.5f), glm::vec2(0.25f, 0.5f));
}

}   // namespace
}   // namespace gnomon
