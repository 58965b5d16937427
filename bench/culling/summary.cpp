// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/summary.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "gnomon/error.h"

namespace gnomon::bench {

namespace {

void add_counts(const CullingFrame::Paper& p, std::vector<std::uint64_t>& counts)
{
    for (const std::uint64_t n :
         {p.rays, p.skipped, p.dynamic_only, p.nodes, p.tests, p.extra_tests, p.wrong, p.cache_tests, p.cache_hits})
        counts.push_back(n);
    counts.insert(counts.end(), p.full.begin(), p.full.end());
}

std::vector<std::uint64_t> counts_of(const CullingFrame& f)
{
    std::vector<std::uint64_t> counts = {f.off.rays,
                                         f.off.nodes,
                                         f.off.tests,
                                         f.certified.rays,
                                         f.certified.skipped,
                                         f.certified.dynamic_only,
                                         f.certified.partial,
                                         f.certified.certificates,
                                         f.certified.certified,
                                         f.certified.nodes,
                                         f.certified.tests,
                                         f.certified.wrong};
    add_counts(f.paper, counts);
    for (const CullingFrame::Paper& reading : f.readings) add_counts(reading, counts);
    return counts;
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
CullingBenchResult::Saved saved(const std::vector<CullingFrame>& frames, Method&& method)
{
    CullingBenchResult::Saved result;
    std::uint64_t nodes_with = 0, nodes_without = 0, tests_with = 0, tests_without = 0;
    for (const CullingFrame& frame : frames) {
        const auto& m = method(frame);
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
        if (options.counts)
            result.paper_saved = saved(
                frames, [](auto& f) -> auto& { return f.paper; });
    }
    result.readings.resize(options.readings.size());
    for (std::size_t r = 0; r < options.readings.size(); ++r) {
        CullingBenchResult::Reading& reading = result.readings[r];
        reading.extra_tests_per_pixel = reading.wrong_mean = 0;
        for (const CullingFrame& frame : frames) {
            reading.extra_tests_per_pixel += frame.readings[r].extra_tests_per_pixel / count;
            reading.wrong_mean += static_cast<double>(frame.readings[r].wrong) / count;
        }
        if (options.counts)
            reading.saved = saved(
                frames, [r](auto& f) -> auto& { return f.readings[r]; });
    }
    if (!options.certified) return;
    if (options.counts)
        result.certified_saved = saved(
            frames, [](auto& f) -> auto& { return f.certified; });
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
