// SPDX-License-Identifier: Apache-2.0
// Bounced light at seams, where meshes of triangles about as wide as pixels intersect: the middle of a pixel's triangle
// may lie inside of other geometry, where it is dark.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

// Pixels whose light is less than a quarter of the median of their object's pixels around them.
int dark_dots(const Frame& frame)
{
    constexpr int k_around = 2, k_fewest = 6;
    const Layer &light = *frame.layer("indirect"), &ids = *frame.layer("id");
    int dots = 0;
    for (int y = k_around; y < frame.size.height - k_around; ++y)
        for (int x = k_around; x < frame.size.width - k_around; ++x) {
            if (ids.id(x, y) == 0) continue;
            std::vector<float> around;
            for (int v = y - k_around; v <= y + k_around; ++v)
                for (int u = x - k_around; u <= x + k_around; ++u)
                    if (ids.id(u, v) == ids.id(x, y)) around.push_back(light.value(u, v, 1));
            if (around.size() < k_fewest) continue;
            const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
            std::ranges::nth_element(around, middle);
            dots += light.value(x, y, 1) < 0.25f * *middle;
        }
    return dots;
}

TEST(Seams, WhereBallsIntersectFewPixelsAreDark)
{
    RenderOptions options;
    options.size = {140, 140};
    options.samples = 1;
    options.bounces = 2;
    options.layers = options.ids = true;
    const Frame frame = Renderer(options).render(load("builtin:spheres?objects=300&dynamic=0"), 1);
    const int dots = dark_dots(frame);
    std::printf("%d dark dots\n", dots);
    EXPECT_LE(dots, 10);   // 21 without parts closer to the pixel
}

}   // namespace
}   // namespace gnomon
