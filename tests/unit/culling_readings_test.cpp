// SPDX-License-Identifier: Apache-2.0
// bench culling at other times than the clip's frames, and other readings of the published method.
#include "bench/culling/readings.h"

#include <gtest/gtest.h>

#include "bench/culling/figures.h"
#include "bench/culling/window.h"
#include "gnomon/gnomon.h"
#include "scene/builtin/builtin.h"

namespace gnomon::bench {
namespace {

CullingBenchOptions small_options()
{
    CullingBenchOptions options;
    options.frames = {1, 4};
    options.size = {96, 96};
    options.certified = false;
    return options;
}

std::shared_ptr<const scene::Scene> builtin(const char* name)
{
    return std::make_shared<const scene::Scene>(scene::make_builtin(name));
}

TEST(CullingSteps, FramesAreStepsFromTheStart)
{
    scene::Timeline clip;
    clip.start = 2, clip.end = 12, clip.frames = 241, clip.fps = 24;
    CullingBenchOptions options;
    EXPECT_DOUBLE_EQ(time_of(options, clip, 25), 3);
    options.step = 0.5;
    EXPECT_DOUBLE_EQ(time_of(options, clip, 1), 2);
    EXPECT_DOUBLE_EQ(time_of(options, clip, 3.5), 3.25);
    EXPECT_EQ(steps_in(clip, options), 21);
    options.start = -1;
    EXPECT_DOUBLE_EQ(time_of(options, clip, 1), -1);
    EXPECT_DOUBLE_EQ(time_of(options, clip, 41), 19) << "beyond the end";
    EXPECT_EQ(steps_in(clip, options), 27);
    options.start = 100;
    EXPECT_EQ(steps_in(clip, options), 1);
}

TEST(CullingSteps, OneStepOfTheClipIsItsOwnFrames)
{
    const auto scene = builtin("cornell");
    CullingBenchOptions options = small_options();
    options.counts = false;
    const CullingBenchResult own = bench_culling(scene, options);
    options.step = scene->timeline.time_of(2) - scene->timeline.time_of(1);
    const CullingBenchResult stepped = bench_culling(scene, options);
    options.step *= 3;
    const CullingBenchResult wide = bench_culling(scene, options);
    for (std::size_t f = 0; f < own.frames.size(); ++f) {
        EXPECT_EQ(own.frames[f].off.rays, stepped.frames[f].off.rays);
        EXPECT_EQ(own.frames[f].paper.skipped, stepped.frames[f].paper.skipped);
        EXPECT_EQ(own.frames[f].paper.extra_tests, stepped.frames[f].paper.extra_tests);
    }
    EXPECT_NE(own.frames[3].off.rays, wide.frames[3].off.rays);
    EXPECT_DOUBLE_EQ(wide.frames[3].time, scene->timeline.time_of(10));
}

TEST(CullingSteps, HistoryBetweenTheFramesEqualsThatOfAllFrames)
{
    // The methods see frames 1 to 7 either way, and the last of them is measured.
    const auto scene = builtin("cornell");
    CullingBenchOptions all = small_options();
    all.frames = {1, 7};
    const CullingBenchResult every = bench_culling(scene, all);
    CullingWindow window;
    window.options = small_options();
    window.options.frames = {1, 3};
    const double frame = scene->timeline.time_of(2) - scene->timeline.time_of(1);
    window.options.step = 3 * frame;
    const CullingStep step = measure_step(scene, window, frame, {});
    for (std::size_t f = 0; f < 3; ++f) {
        const CullingFrame::Paper &a = step.result.frames[f].paper, &b = every.frames[3 * f].paper;
        EXPECT_EQ(a.rays, b.rays);
        EXPECT_EQ(a.skipped, b.skipped);
        EXPECT_EQ(a.dynamic_only, b.dynamic_only);
        EXPECT_EQ(a.full, b.full);
        EXPECT_EQ(a.nodes, b.nodes);
    }
    EXPECT_GT(step.result.frames[2].paper.dynamic_only, 0u);
    EXPECT_THROW(measure_step(scene, window, 2 * frame, {}), UsageError);
}

TEST(CullingReadings, EveryTracedRayHasAReason)
{
    CullingBenchOptions options = small_options();
    options.readings = all_readings();
    options.max_depth = 3;
    options.counts = false;
    const CullingBenchResult result = bench_culling(builtin("cornell"), options);
    for (const CullingFrame& frame : result.frames) {
        std::vector<CullingFrame::Paper> all = frame.readings;
        all.push_back(frame.paper);
        for (const CullingFrame::Paper& p : all) {
            std::uint64_t full = 0;
            for (const std::uint64_t n : p.full) full += n;
            EXPECT_EQ(p.rays, frame.off.rays);
            EXPECT_EQ(full + p.skipped + p.dynamic_only, p.rays);
        }
    }
}

TEST(CullingReadings, CachedOccludersSaveWorkAndChangeNoResult)
{
    CullingBenchOptions options = small_options();
    options.readings = {reading_named("cached")};
    const CullingBenchResult result = bench_culling(builtin("cornell"), options);
    for (const CullingFrame& frame : result.frames) {
        const CullingFrame::Paper &plain = frame.paper, &cached = frame.readings[0];
        EXPECT_EQ(cached.wrong, plain.wrong);
        EXPECT_EQ(cached.skipped, plain.skipped);
        EXPECT_GT(cached.cache_hits, 0u);
        EXPECT_GE(cached.cache_tests, cached.cache_hits);
        EXPECT_LT(cached.nodes, plain.nodes);
        // What a miss costs is one test; what a hit saves are at least its ray's root and one test.
        EXPECT_LE(cached.nodes + cached.cache_hits, plain.nodes);
        EXPECT_LE(cached.tests, plain.tests + cached.cache_tests - cached.cache_hits);
    }
    options.threads = 3;
    const CullingBenchResult many = bench_culling(builtin("cornell"), options);
    for (std::size_t f = 0; f < result.frames.size(); ++f) {
        EXPECT_EQ(many.frames[f].readings[0].cache_hits, result.frames[f].readings[0].cache_hits);
        EXPECT_EQ(many.frames[f].readings[0].tests, result.frames[f].readings[0].tests);
    }
}

TEST(CullingReadings, PartsOfTrianglesSaveMore)
{
    CullingBenchOptions options = small_options();
    options.counts = false;
    options.readings = {reading_named("parts")};
    const CullingBenchResult result = bench_culling(builtin("cornell"), options);
    const CullingFrame& last = result.frames.back();
    EXPECT_GT(last.readings[0].skipped + last.readings[0].dynamic_only, last.paper.skipped + last.paper.dynamic_only);
    EXPECT_GT(result.readings[0].bytes, result.paper_bytes);
}

TEST(CullingReadings, AsPrintedIsTheSameForAnyThreadCount)
{
    CullingBenchOptions options = small_options();
    options.counts = false;
    options.max_depth = 4;
    options.paper_options = shadow_culling::PaperOptions::as_printed();
    const CullingBenchResult one = bench_culling(builtin("cornell"), options);
    options.threads = 3;
    const CullingBenchResult three = bench_culling(builtin("cornell"), options);
    std::uint64_t culled = 0;
    for (std::size_t f = 0; f < one.frames.size(); ++f) {
        const CullingFrame::Paper &a = one.frames[f].paper, &b = three.frames[f].paper;
        EXPECT_EQ(a.skipped, b.skipped);
        EXPECT_EQ(a.dynamic_only, b.dynamic_only);
        EXPECT_EQ(a.full, b.full);
        EXPECT_EQ(a.extra_tests, b.extra_tests);
        EXPECT_EQ(a.wrong, b.wrong);
        culled += a.skipped + a.dynamic_only;
    }
    EXPECT_GT(culled, 0u);
}

TEST(CullingReadings, AsPrintedTracesTheRaysOfTheRenderedFrame)
{
    // The renderer traces pixel by pixel; the bench traces all rays in packets and then decides pixel by pixel.
    const Scene scene = load("builtin:cornell");
    RenderOptions render;
    render.size = {96, 96};
    render.shadow_culling = ShadowCulling::paper;
    render.as_printed = true;
    render.indirect = Indirect::off;
    render.max_depth = 0;
    Renderer renderer(render);
    CullingBenchOptions options = small_options();
    options.counts = false;
    options.paper_options = shadow_culling::PaperOptions::as_printed();
    const CullingBenchResult bench = bench_culling(builtin("cornell"), options);
    for (const CullingFrame& frame : bench.frames) {
        const FrameCounters::Shadow shadow = renderer.render(scene, frame.frame).counters.shadow;
        // Rays that meet the edge of two surfaces may take either.
        const auto near = [](std::uint64_t a, std::uint64_t b) {
            EXPECT_NEAR(static_cast<double>(a), static_cast<double>(b), 30) << a << " " << b;
        };
        near(shadow.rays, frame.paper.rays);
        near(shadow.rays_skipped, frame.paper.skipped);
        near(shadow.rays_dynamic_only, frame.paper.dynamic_only);
    }
}

TEST(CullingFigures, ZoomMissesShadowsForOneFrame)
{
    const ZoomFigure figure = zoom_figure({240, 180});
    EXPECT_GT(figure.wrong_zoomed, 50u);
    EXPECT_EQ(figure.wrong_after, 0u);
    EXPECT_EQ(figure.after.data, figure.zoomed_right.data);
    EXPECT_NE(figure.before.data, figure.zoomed.data);
}

TEST(CullingReadings, EveryTreeFindsTheSameAndCountsItsOwn)
{
    CullingBenchOptions options = small_options();
    std::vector<CullingBenchResult> results;
    for (const char* name : {"separate", "hierarchy", "mixed"}) {
        options.layout = layout_named(name);
        results.push_back(bench_culling(builtin("cornell"), options));
    }
    EXPECT_GT(results[1].tree_group_splits, 0u);
    EXPECT_EQ(results[2].tree_group_splits, 0u);
    for (const CullingBenchResult& result : results) {
        EXPECT_GT(result.paper_saved.nodes_mean, 0);
        EXPECT_EQ(result.frames[3].paper.skipped, results[0].frames[3].paper.skipped);
    }
    EXPECT_NE(results[0].frames[0].off.nodes, results[2].frames[0].off.nodes);
    EXPECT_THROW(layout_named("oak"), UsageError);
    EXPECT_THROW(reading_named("loud"), UsageError);
}

}   // namespace
}   // namespace gnomon::bench
