// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/json.h"

#include <nlohmann/json.hpp>

namespace gnomon::bench {

namespace {

// The counts of the published method, or of another reading of it.
nlohmann::ordered_json paper_json(const CullingFrame::Paper& p, bool counts)
{
    using shadow_culling::FullReason;
    const auto full = [&](FullReason reason) { return p.full[static_cast<std::size_t>(reason)]; };
    nlohmann::ordered_json json{{"rays", p.rays},
                                {"skipped", p.skipped},
                                {"dynamic_only", p.dynamic_only},
                                {"traced",
                                 {{"dynamic", full(FullReason::dynamic)},
                                  {"partially_occluded", full(FullReason::partially_occluded)},
                                  {"not_seen", full(FullReason::not_seen)},
                                  {"partly_shadowed", full(FullReason::partly_shadowed)},
                                  {"not_shadowed", full(FullReason::not_shadowed)}}},
                                {"extra_tests_per_pixel", p.extra_tests_per_pixel},
                                {"wrong", p.wrong},
                                {"ms", p.ms}};
    if (counts) json.update({{"nodes", p.nodes}, {"tests", p.tests}});
    if (p.cache_tests > 0) json.update({{"cache_tests", p.cache_tests}, {"cache_hits", p.cache_hits}});
    return json;
}

nlohmann::ordered_json to_json(const CullingFrame& f, const CullingBenchOptions& options)
{
    nlohmann::ordered_json json{{"frame", f.frame},
                                {"off", {{"rays", f.off.rays}, {"ms", f.off.ms}, {"wall_ms", f.off.wall_ms}}}};
    if (options.step > 0) json["time"] = f.time;
    if (options.paper) json["paper"] = paper_json(f.paper, options.counts);
    for (std::size_t r = 0; r < f.readings.size(); ++r)
        json["readings"][options.readings[r].name] = paper_json(f.readings[r], options.counts);
    if (options.certified)
        json["certified"] = {{"rays", f.certified.rays},
                             {"skipped", f.certified.skipped},
                             {"dynamic_only", f.certified.dynamic_only},
                             {"partial", f.certified.partial},
                             {"certificates", f.certified.certificates},
                             {"wrong", f.certified.wrong},
                             {"ms", f.certified.ms},
                             {"wall_ms", f.certified.wall_ms}};
    if (options.counts) {
        json["off"].update({{"nodes", f.off.nodes}, {"tests", f.off.tests}});
        if (options.certified) json["certified"].update({{"nodes", f.certified.nodes}, {"tests", f.certified.tests}});
    }
    return json;
}

nlohmann::ordered_json saved_json(const CullingBenchResult::Saved& s)
{
    return {{"nodes_saved_mean", s.nodes_mean},
            {"nodes_saved_best", s.nodes_best},
            {"nodes_saved_of_totals", s.nodes_of_totals},
            {"tests_saved_mean", s.tests_mean},
            {"tests_saved_best", s.tests_best},
            {"tests_saved_of_totals", s.tests_of_totals},
            {"nodes_saved_best_frame", s.nodes_best_frame},
            {"tests_saved_best_frame", s.tests_best_frame}};
}

nlohmann::ordered_json summary_of(const CullingBenchResult& result, const CullingBenchOptions& options,
                                  bool moving_lights)
{
    nlohmann::ordered_json summary;
    if (options.paper) {
        summary["paper"] = {{"extra_tests_per_pixel", result.paper_extra_tests_per_pixel},
                            {"wrong_mean", result.paper_wrong_mean},
                            {"bytes", result.paper_bytes}};
        if (options.paper_options.set_modes.remember_dynamic_blockers) summary["paper"]["as_printed"] = true;
        if (options.counts) summary["paper"].update(saved_json(result.paper_saved));
    }
    for (std::size_t r = 0; r < result.readings.size(); ++r) {
        const CullingBenchResult::Reading& reading = result.readings[r];
        nlohmann::ordered_json& json = summary["readings"][options.readings[r].name];
        json = {{"extra_tests_per_pixel", reading.extra_tests_per_pixel},
                {"wrong_mean", reading.wrong_mean},
                {"bytes", reading.bytes}};
        if (options.counts) json.update(saved_json(reading.saved));
    }
    if (options.counts) summary["tree"] = {{"nodes", result.tree_nodes}, {"group_splits", result.tree_group_splits}};
    if (options.certified) {
        summary["certified"] = {{"speedup_mean", result.speedup_mean},
                                {"speedup_steady", result.speedup_steady},
                                {"first_frame_ratio", result.first_frame_ratio},
                                {"worst_frame_ratio", nullptr},
                                {"wrong_total", result.wrong_total},
                                {"bytes", result.bytes},
                                {"mask_bytes", result.mask_bytes},
                                {"most_evidence_bytes", result.most_evidence_bytes},
                                {"visible_triangles", result.visible_triangles},
                                {"bytes_per_triangle_light", result.bytes_per_triangle_light}};
        // The ratio is over the frames after the first, so a single frame has none.
        if (result.frames.size() > 1) summary["certified"]["worst_frame_ratio"] = result.worst_frame_ratio;
        if (moving_lights) summary["certified"]["moving_lights_ratio"] = result.later_frames_ratio;
        if (options.counts) summary["certified"].update(saved_json(result.certified_saved));
    }
    return summary;
}

}   // namespace

nlohmann::ordered_json culling_json(const CullingWindow& window)
{
    nlohmann::ordered_json frames = nlohmann::ordered_json::array();
    for (const CullingFrame& frame : window.result.frames) frames.push_back(to_json(frame, window.options));
    nlohmann::ordered_json json{{"frames", std::move(frames)},
                                {"summary", summary_of(window.result, window.options, window.moving_lights)}};
    for (const CullingStep& step : window.steps) {
        nlohmann::ordered_json one{{"step", step.seconds}};
        one.update(summary_of(step.result, step.options, false));
        json["steps"].push_back(std::move(one));
    }
    return json;
}

}   // namespace gnomon::bench
