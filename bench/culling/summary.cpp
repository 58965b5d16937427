// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::bench {

namespace {

auto counts_of(const CullingFrame& f)
{
    return std::array{f.off.rays,
                      f.off.nodes,
                      f.off.tests,
                      f.paper.rays,
                      f.paper.skipped,
                      f.paper.dynamic_only,
                      f.paper.nodes,
                      f.paper.tests,
                      f.paper.extra_tests,
                      f.paper.wrong,
                      f.certified.rays,
                      f.certified.skipped,
                      f.certified.dynamic_only,
                      f.certified.partial,
                      f.certified.certificates,
                      f.certified.certified,
                      f.certified.nodes,
                      f.certified.tests,
                      f.certified.wrong};
}

// The middle value, or the mean of the two middle values.
double median(std::vector<double> values)
{
    const std::size_t middle = values.size() / 2;
    std::sort(values.begin(), values.end());
    return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

double percent_saved(std::uint64_t with, std::uint64_t without)
{
    return without > 0 ? 100.0 - 100.0 * static_cast<double>(with) / static_cast<double>(without) : 0.0;
}

// The counts that a method saves, in percent of those of tracing every ray.
template <class Method>
CullingBenchResult::Saved saved(const std::vector<CullingFrame>& frames, Method CullingFrame::*method)
{
    CullingBenchResult::Saved result;
    std::uint64_t nodes_with = 0, nodes_without = 0, tests_with = 0, tests_without = 0;
    for (const CullingFrame& frame : frames) {
        const Method& m = frame.*method;
        const double nodes = percent_saved(m.nodes, frame.off.nodes);
        const double tests = percent_saved(m.tests, frame.off.tests);
        result.nodes_mean += nodes / static_cast<double>(frames.size());
        result.tests_mean += tests / static_cast<double>(frames.size());
        if (result.nodes_best_frame == 0 || nodes > result.nodes_best)
            result.nodes_best = nodes, result.nodes_best_frame = frame.frame;
        if (result.tests_best_frame == 0 || tests > result.tests_best)
            result.tests_best = tests, result.tests_best_frame = frame.frame;
        nodes_with += m.nodes, nodes_without += frame.off.nodes;
        tests_with += m.tests, tests_without += frame.off.tests;
    }
    result.nodes_of_totals = percent_saved(nodes_with, nodes_without);
    result.tests_of_totals = percent_saved(tests_with, tests_without);
    return result;
}

// The ratio off / certified of the times summed over frames [first, end).
double speedup(const std::vector<CullingFrame>& frames, std::size_t first)
{
    double off = 0, certified = 0;
    for (std::size_t f = first; f < frames.size(); ++f) {
        off += frames[f].off.ms;
        certified += frames[f].certified.ms;
    }
    return certified > 0 ? off / certified : 0;
}

}   // namespace

std::vector<CullingFrame> medians_of(std::span<const std::vector<CullingFrame>> runs)
{
    GNOMON_CHECK(!runs.empty());
    std::vector<CullingFrame> frames = runs.front();
    for (std::size_t f = 0; f < frames.size(); ++f) {
        for (const std::vector<CullingFrame>& run : runs) {
            GNOMON_CHECK_EQ(run.size(), frames.size());
            if (counts_of(run[f]) != counts_of(frames[f]))
                throw InternalError(fmt::format("the counts of frame {} differ between two runs", frames[f].frame));
        }
        const auto take = [&](auto member) {
            std::vector<double> values;
            for (const std::vector<CullingFrame>& run : runs) values.push_back(member(run[f]));
            member(frames[f]) = median(std::move(values));
        };
        take([](auto& frame) -> auto& { return frame.off.ms; });
        take([](auto& frame) -> auto& { return frame.off.wall_ms; });
        take([](auto& frame) -> auto& { return frame.paper.ms; });
        take([](auto& frame) -> auto& { return frame.paper.wall_ms; });
        take([](auto& frame) -> auto& { return frame.certified.ms; });
        take([](auto& frame) -> auto& { return frame.certified.wall_ms; });
        take([](auto& frame) -> auto& { return frame.certified.judge_ms; });
    }
    return frames;
}

void summarise(const CullingBenchOptions& options, CullingBenchResult& result)
{
    const std::vector<CullingFrame>& frames = result.frames;
    if (frames.empty()) return;
    const auto count = static_cast<double>(frames.size());
    if (options.paper) {
        for (const CullingFrame& frame : frames) {
            result.paper_extra_tests_per_pixel += frame.paper.extra_tests_per_pixel / count;
            result.paper_wrong_mean += static_cast<double>(frame.paper.wrong) / count;
        }
        if (options.counts) result.paper_saved = saved(frames, &CullingFrame::paper);
    }
    if (!options.certified) return;
    if (options.counts) result.certified_saved = saved(frames, &CullingFrame::certified);
    for (const CullingFrame& frame : frames) result.wrong_total += frame.certified.wrong;
    result.speedup_mean = speedup(frames, 0);
    result.speedup_steady = speedup(frames, frames.size() / 2);
    const auto ratio = [](const CullingFrame& f) {
        return f.off.wall_ms > 0 ? f.certified.wall_ms / f.off.wall_ms : 0;
    };
    result.first_frame_ratio = ratio(frames.front());
    for (std::size_t f = 1; f < frames.size(); ++f)
        result.worst_frame_ratio = std::max(result.worst_frame_ratio, ratio(frames[f]));
    if (const double later = speedup(frames, 1); later > 0) result.later_frames_ratio = 1 / later;
}

}   // namespace gnomon::bench
