// SPDX-License-Identifier: Apache-2.0
// The light quad-tree in the rasterised frame [Ki and Oh 2007]: as printed, one pass a level, it gives the light of the
// compacted cut; and the renderer keeps G-buffer, light map and sparse receivers while nothing changes.
#include "vk_helpers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#ifdef GNOMON_VULKAN
#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

class QuadtreeFrames : public test::VulkanTest {};

RenderOptions options_of(int level, bool full, bool as_printed, double margin = 0)
{
    RenderOptions options;
    options.renderer = RenderMethod::raster;
    options.size = {96, 96};
    options.indirect = Indirect::quadtree;
    options.indirect_level = level;
    options.indirect_at_every_pixel = full;
    options.validity_margin = margin;
    options.as_printed = as_printed;
    options.layers = true;
    options.exposure = 0.0;
    return options;
}

std::size_t values_different(const Frame& a, const Frame& b, const std::string& name)
{
    const auto x = a.layer(name)->values(), y = b.layer(name)->values();
    std::size_t different = x.size() == y.size() ? 0 : x.size();
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) different += x[i] != y[i];
    return different;
}

// The largest difference of two values, over the largest value.
float largest_difference(const Frame& a, const Frame& b, const std::string& name)
{
    const auto x = a.layer(name)->values(), y = b.layer(name)->values();
    if (x.size() != y.size()) return std::numeric_limits<float>::infinity();
    float difference = 0, largest = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        difference = std::max(difference, std::abs(x[i] - y[i]));
        largest = std::max(largest, std::abs(x[i]));
    }
    return difference / largest;
}

TEST_F(QuadtreeFrames, OnePassALevelGivesTheLightOfTheCompactedCut)
{
    const Scene scene = load("builtin:cornell");
    struct Setting {
        int level;
        bool full;
        double margin;
    };
    for (const auto& [level, full, margin] : {Setting{6, false, 0}, {5, true, 0}, {4, false, 0}, {4, false, 0.5}}) {
        SCOPED_TRACE(testing::Message() << "level " << level << ", margin " << margin);
        const Frame compacted = Renderer(options_of(level, full, false, margin)).render(scene, 3),
                    printed = Renderer(options_of(level, full, true, margin)).render(scene, 3);
        // As published, to the bit. Shares are divided, which a device may round in two ways.
        if (margin == 0)
            EXPECT_EQ(values_different(compacted, printed, "indirect"), 0u);
        else
            EXPECT_LT(largest_difference(compacted, printed, "indirect"), 1e-5f);
        EXPECT_EQ(compacted.counters.indirect.clusters, printed.counters.indirect.clusters);
        double sum = 0;
        for (const float value : printed.layer("indirect")->values()) sum += static_cast<double>(value);
        EXPECT_GT(sum, 1);
    }
}

TEST_F(QuadtreeFrames, FinerLevelsHaveMoreClusters)
{
    const Scene scene = load("builtin:cornell");
    std::uint64_t before = 0;
    for (const int level : {7, 6, 4, 2, 1}) {
        RenderOptions options = options_of(level, false, false);
        options.size = {16, 16};
        const std::uint64_t clusters = Renderer(options).render(scene, 1).counters.indirect.clusters;
        EXPECT_GT(clusters, before) << level;
        before = clusters;
    }
    EXPECT_GT(before, 2000u);
}

TEST_F(QuadtreeFrames, TheRendererKeepsItsBuffersWhileNothingChanges)
{
    const Scene scene = load("builtin:cornell");
    for (const bool as_printed : {false, true}) {
        Renderer renderer(options_of(6, false, as_printed));
        const Frame first = renderer.render(scene, 2);
        EXPECT_FALSE(first.counters.kept_surfaces || first.counters.indirect.kept_map ||
                     first.counters.indirect.kept_receivers);
        const Frame again = renderer.render(scene, 2);
        EXPECT_TRUE(again.counters.kept_surfaces && again.counters.indirect.kept_map &&
                    again.counters.indirect.kept_receivers);
        for (const char* name : {"", "direct", "indirect", "shadow", "depth", "normal", "albedo"})
            EXPECT_EQ(values_different(first, again, name), 0u) << name;

        // Another frame moves the ball: nothing can be kept, and the image is that of a new renderer.
        const Frame moved = renderer.render(scene, 3),
                    fresh = Renderer(options_of(6, false, as_printed)).render(scene, 3);
        EXPECT_FALSE(moved.counters.kept_surfaces || moved.counters.indirect.kept_map ||
                     moved.counters.indirect.kept_receivers);
        for (const char* name : {"", "direct", "indirect"}) EXPECT_EQ(values_different(moved, fresh, name), 0u) << name;
    }
}

// The ball rests at its end: only the camera moves.
TEST_F(QuadtreeFrames, OnlyTheLightMapIsKeptWhileTheCameraMoves)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer(options_of(6, false, false));
    FrameInput input;
    input.time = 0;
    renderer.render(scene, input);
    input.camera = Camera{.transform = Transform::translation(0.05, 0, 3.6), .vertical_fov = 0.62};
    const Frame turned = renderer.render(scene, input);
    EXPECT_FALSE(turned.counters.kept_surfaces);
    EXPECT_TRUE(turned.counters.indirect.kept_map);
    EXPECT_FALSE(turned.counters.indirect.kept_receivers);
    const Frame again = renderer.render(scene, input);
    EXPECT_TRUE(again.counters.kept_surfaces && again.counters.indirect.kept_receivers);
    EXPECT_EQ(values_different(turned, again, ""), 0u);
}

// Several samples or layers are made in the same images, so that none is kept.
TEST_F(QuadtreeFrames, SurfacesOfSeveralSamplesAreNotKept)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options = options_of(6, false, false);
    options.samples = 4;
    Renderer renderer(options);
    const Frame first = renderer.render(scene, 1), again = renderer.render(scene, 1);
    EXPECT_FALSE(again.counters.kept_surfaces);
    EXPECT_FALSE(again.counters.indirect.kept_receivers);
    EXPECT_EQ(values_different(first, again, ""), 0u);
}

}   // namespace
}   // namespace gnomon
#endif
