// SPDX-License-Identifier: Apache-2.0
// The bounced light of a scene of small shapes (tiles with joints, capitals, foliage), whose cache points stand for
// less than lies between them, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

double sum_of_indirect(const Frame& frame)
{
    double sum = 0;
    for (const Layer& layer : frame.layers)
        if (layer.name == "indirect")
            for (const float value : layer.copy()) sum += static_cast<double>(value);
    return sum;
}

// Without near light of parts, points that geometry covers, and finer parts where one is hidden: .88.
TEST(SmallShapes, KeepTheirBouncedLight)
{
    const Scene scene = load("builtin:kinetic");
    RenderOptions options;
    options.size = {160, 128};
    options.layers = true;
    options.bounces = 1;
    const double got = sum_of_indirect(Renderer(options).render(scene, 30));
    options.reference = ReferenceLightOptions{24, 1, 0};
    const double truth = sum_of_indirect(Renderer(options).render(scene, 30));
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.91 * truth);
    EXPECT_LT(got, 1.03 * truth);
}

}   // namespace
}   // namespace gnomon
