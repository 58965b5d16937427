// SPDX-License-Identifier: Apache-2.0
// The bounced light of a scene of small shapes (tiles with joints, capitals, foliage), whose cache points stand for
// less than lies between them, against the path-traced reference in absolute units.
#include <gtest/gtest.h>

#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

struct Part {
    int x0 = 0, y0 = 0, x1 = 160, y1 = 128;
};

RenderOptions options_of(int bounces)
{
    RenderOptions options;
    options.size = {160, 128};
    options.layers = true;
    options.bounces = bounces;
    return options;
}

// Frame 30 of the courtyard.
// @param lights  0: its sky alone
double sum_of_indirect(const RenderOptions& options, int lights, const Part& part = {})
{
    const Frame frame = Renderer(options).render(load("builtin:kinetic").with_lights(lights), 30);
    double sum = 0;
    for (const Layer& layer : frame.layers) {
        if (layer.name != "indirect") continue;
        const std::vector<float> values = layer.copy();
        for (int y = part.y0; y < part.y1; ++y)
            for (int c = 3 * part.x0; c < 3 * part.x1; ++c)
                sum += static_cast<double>(values[static_cast<std::size_t>(480 * y + c)]);
    }
    return sum;
}

RenderOptions reference_of(RenderOptions options, int samples)
{
    options.reference = ReferenceLightOptions{samples, 1, 0};
    return options;
}

// Without near light of parts, points that geometry covers, and finer parts where one is hidden: .88. Without finer
// parts where one is lit unlike its surroundings: .965.
TEST(SmallShapes, KeepTheirBouncedLight)
{
    const RenderOptions options = options_of(1);
    const double got = sum_of_indirect(options, 1);
    const double truth = sum_of_indirect(reference_of(options, 24), 1);
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.98 * truth);
    EXPECT_LT(got, 1.03 * truth);
}

// Most of that light is the sky's. Of the sun's own, .86 without near light of lattice points far apart, and with wide
// patches that get no light from themselves.
TEST(SmallShapes, KeepTheSunsLight)
{
    const RenderOptions options = options_of(1), reference = reference_of(options, 24);
    const double got = sum_of_indirect(options, 1) - sum_of_indirect(options, 0);
    const double truth = sum_of_indirect(reference, 1) - sum_of_indirect(reference, 0);
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.873 * truth);
    EXPECT_LT(got, 1.03 * truth);
}

// The red plate of the mobile: .90 with cuts for moving objects as coarse as they were before light bounced twice.
TEST(SmallShapes, MovingObjectsReceiveWhatBouncesTwice)
{
    const Part plate{33, 24, 42, 40};
    const RenderOptions options = options_of(2);
    const double got = sum_of_indirect(options, 1, plate);
    const double truth = sum_of_indirect(reference_of(options, 96), 1, plate);
    RecordProperty("energy", std::to_string(got / truth));
    EXPECT_GT(got, 0.92 * truth);
    EXPECT_LT(got, 1.05 * truth);
}

}   // namespace
}   // namespace gnomon
