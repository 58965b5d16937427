// SPDX-License-Identifier: Apache-2.0
// Lights as bright as floats allow, and surfaces that touch a light: all layers of all images are finite.
#include <gtest/gtest.h>

#include <cmath>

#include "bright_lights.h"

namespace gnomon {
namespace {

void expect_finite(const RenderOptions& options, const char* what)
{
    for (const test::BrightScene& bright : test::bright_scenes({"1", "1e20", "1e30", "3.4e38"})) {
        const Frame image = Renderer(options).render(bright.scene, 1);
        EXPECT_EQ(test::count_of_no_numbers(image), 0u) << what << ", " << bright.name;
        EXPECT_GT(test::brightest_of(image), bright.at_least) << what << ", " << bright.name;
    }
}

TEST(BrightLights, AllLayersAreFinite)
{
    RenderOptions options;
    options.threads = 2;
    options.size = {32, 24};
    options.layers = true;
    for (const Indirect indirect : {Indirect::off, Indirect::visible, Indirect::quadtree, Indirect::rsm}) {
        options.indirect = indirect;
        expect_finite(options, ("indirect " + std::to_string(static_cast<int>(indirect))).c_str());
    }
    options.reference = ReferenceLightOptions{.spp = 4, .bounces = 2};
    expect_finite(options, "reference");
}

}   // namespace
}   // namespace gnomon
