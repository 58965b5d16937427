// SPDX-License-Identifier: Apache-2.0
// Medians and figures of bench culling, from constructed frames; and complete benches of small scenes.
#include <gtest/gtest.h>

#include "bench/core/moving_lights.h"
#include "bench/culling/summary.h"
#include "bench/culling/window.h"
#include "gnomon/error.h"
#include "scene/builtin/builtin.h"

namespace gnomon::bench {
namespace {

CullingFrame frame_of(int number, double off_ms, double certified_ms, std::uint64_t nodes)
{
    CullingFrame f;
    f.frame = number;
    f.off.rays = f.off.nodes = f.off.tests = 1000;
    f.off.ms = f.off.wall_ms = off_ms;
    f.certified.ms = f.certified.wall_ms = certified_ms;
    f.certified.nodes = f.certified.tests = nodes;
    f.paper.nodes = f.paper.tests = nodes;
    f.paper.wrong = 3;
    return f;
}

TEST(CullingSummary, MediansArePerFrame)
{
    const std::vector<std::vector<CullingFrame>> runs = {{frame_of(1, 10, 30, 500), frame_of(2, 10, 1, 100)},
                                                         {frame_of(1, 90, 20, 500), frame_of(2, 11, 2, 100)},
                                                         {frame_of(1, 20, 10, 500), frame_of(2, 12, 9, 100)}};
    const std::vector<CullingFrame> frames = medians_of(runs);
    ASSERT_EQ(frames.size(), 2u);
    EXPECT_EQ(frames[0].off.ms, 20);
    EXPECT_EQ(frames[0].certified.ms, 20);
    EXPECT_EQ(frames[1].off.wall_ms, 11);
    EXPECT_EQ(frames[1].certified.ms, 2);
    EXPECT_EQ(medians_of(std::span(runs).first(2))[0].off.ms, 50);   // between the two
}

TEST(CullingSummary, CountsThatDifferBetweenRunsAreAnError)
{
    std::vector<std::vector<CullingFrame>> runs = {{frame_of(1, 1, 1, 500)}, {frame_of(1, 1, 1, 500)}};
    EXPECT_NO_THROW(medians_of(runs));
    runs[1][0].certified.partial += 1;
    EXPECT_THROW(medians_of(runs), InternalError);
}

TEST(CullingSummary, DerivesFiguresFromTheFrames)
{
    CullingBenchResult r;
    r.frames = {frame_of(5, 10, 40, 1000), frame_of(6, 10, 5, 500), frame_of(7, 10, 4, 100), frame_of(8, 20, 4, 300)};
    r.frames[3].off.nodes = 2000;
    summarise({}, r);
    EXPECT_DOUBLE_EQ(r.speedup_mean, 50.0 / 53);
    EXPECT_DOUBLE_EQ(r.speedup_steady, 30.0 / 8);
    EXPECT_DOUBLE_EQ(r.later_frames_ratio, 13.0 / 40);
    EXPECT_DOUBLE_EQ(r.first_frame_ratio, 4);
    EXPECT_DOUBLE_EQ(r.worst_frame_ratio, 0.5);
    EXPECT_DOUBLE_EQ(r.certified_saved.nodes_mean, (0 + 50 + 90 + 85) / 4.0);
    EXPECT_DOUBLE_EQ(r.certified_saved.nodes_best, 90);
    EXPECT_EQ(r.certified_saved.nodes_best_frame, 7);
    EXPECT_DOUBLE_EQ(r.certified_saved.nodes_of_totals, 100 - 100.0 * 1900 / 5000);
    EXPECT_DOUBLE_EQ(r.paper_saved.tests_mean, (0 + 50 + 90 + 70) / 4.0);
    EXPECT_DOUBLE_EQ(r.paper_wrong_mean, 3);
}

TEST(CullingSummary, SummarisesTheFirstFramesOfAWindow)
{
    CullingWindow whole;
    whole.scene = "some/kitchen.aff";
    whole.options.frames = {5, 8};
    whole.result.frames = {frame_of(5, 10, 40, 1000), frame_of(6, 10, 5, 500), frame_of(7, 10, 4, 100),
                           frame_of(8, 20, 4, 300)};
    const CullingWindow first = beginning_of(whole, 2);
    EXPECT_EQ(name_of(first), "kitchen.aff, frames 5 to 6");
    EXPECT_EQ(first.result.frames.size(), 2u);
    EXPECT_DOUBLE_EQ(first.result.certified_saved.nodes_mean, 25);
    EXPECT_DOUBLE_EQ(beginning_of(whole, 4).result.certified_saved.nodes_mean, (0 + 50 + 90 + 70) / 4.0);
    EXPECT_THROW(beginning_of(whole, 5), InternalError);
}

TEST(CullingBench, ReflectedHitsAreTestedAndNothingIsWrong)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("kinetic"));
    CullingBenchOptions options;
    options.frames = {20, 23};
    options.size = {160, 90};
    options.counts = false;   // its kd-tree takes seconds to build
    options.repeat = 1;
    const CullingBenchResult primary = bench_culling(scene, options);
    options.max_depth = 6;
    const CullingBenchResult deep = bench_culling(scene, options);
    for (std::size_t f = 0; f < deep.frames.size(); ++f) {
        EXPECT_GT(deep.frames[f].off.rays, primary.frames[f].off.rays);
        EXPECT_EQ(deep.frames[f].paper.rays, deep.frames[f].off.rays);
        EXPECT_EQ(deep.frames[f].certified.wrong, 0u);
    }
    // The occlusion test uses primary hits only.
    EXPECT_EQ(deep.frames[0].paper.extra_tests, primary.frames[0].paper.extra_tests);
    EXPECT_GT(deep.frames.back().certified.skipped, 0u);
    EXPECT_GT(deep.bytes_per_triangle_light, 0);
}

// If the certified method skips a check, the bench counts the wrong results.
TEST(CullingBench, CountsWrongResultsIfAProofLacksACheck)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("kinetic"));
    CullingBenchOptions options;
    options.frames = {20, 22};
    options.size = {96, 54};
    options.counts = options.paper = false;
    const CullingBenchResult complete = bench_culling(scene, options);
    EXPECT_EQ(complete.wrong_total, 0u);
    options.left_out = visibility::LeftOut(visibility::Check::nothing_in_shaft);
    const CullingBenchResult lacking = bench_culling(scene, options);
    EXPECT_EQ(lacking.frames[0].certified.wrong, 0u) << "nothing is remembered in the first frame";
    EXPECT_GT(lacking.frames[1].certified.wrong, 10u);
    EXPECT_GT(lacking.frames[2].certified.wrong, 10u);
    EXPECT_EQ(lacking.wrong_total, lacking.frames[1].certified.wrong + lacking.frames[2].certified.wrong);
}

TEST(CullingBench, EveryRayIsLeftOutOrTraced)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("kinetic"));
    CullingBenchOptions options;
    options.frames = {60, 62};
    options.size = {96, 54};
    options.counts = options.paper = false;
    const CullingBenchResult result = bench_culling(scene, options);
    EXPECT_EQ(result.frames[0].certified.skipped, 0u) << "nothing is remembered in the first frame";
    for (std::size_t f = 0; f < result.frames.size(); ++f) {
        const auto& counted = result.frames[f].certified;
        EXPECT_EQ(counted.skipped + counted.dynamic_only + counted.traced, counted.rays) << f;
        EXPECT_EQ(counted.dynamic_only > 0, f > 0) << f;
        EXPECT_GE(counted.traced, counted.partial) << f;
    }
}

TEST(CullingBench, EveryMethodCastsNoRaysOutsideASpotsCone)
{
    // The box of builtin:cornell is lit by a spot light that reaches half of what the camera sees.
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    CullingBenchOptions options;
    options.frames = {1, 3};
    options.size = {96, 96};
    options.counts = false;
    const CullingBenchResult result = bench_culling(scene, options);
    for (const CullingFrame& frame : result.frames) {
        EXPECT_EQ(frame.paper.rays, frame.off.rays);
        EXPECT_GT(frame.off.rays, 1000u);
        EXPECT_LT(frame.off.rays, 96u * 96 * 3 / 4);
    }
}

TEST(CullingBench, TracesAllRaysIfEveryLightMoves)
{
    const auto scene = with_moving_lights(std::make_shared<const scene::Scene>(scene::make_builtin("kinetic")));
    CullingBenchOptions options;
    options.frames = {1, 4};
    options.size = {96, 64};
    options.counts = false;
    const CullingBenchResult result = bench_culling(scene, options);
    for (std::size_t f = 1; f < result.frames.size(); ++f) {
        EXPECT_EQ(result.frames[f].certified.partial, 0u);
        EXPECT_EQ(result.frames[f].certified.certificates, 0u);
        EXPECT_EQ(result.frames[f].certified.wrong, 0u);
        EXPECT_EQ(result.frames[f].certified.dynamic_only, 0u);
        EXPECT_EQ(result.frames[f].certified.skipped, 0u);
    }
}

TEST(CullingBench, StopsWhenInterrupted)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    CullingBenchOptions options;
    options.frames = {1, 40};
    options.size = {16, 16};
    int calls = 0;
    EXPECT_THROW(bench_culling(scene, options, [&](const ProgressStep&) { return ++calls < 3; }), InterruptedError);
    EXPECT_EQ(calls, 3);
}

}   // namespace
}   // namespace gnomon::bench
