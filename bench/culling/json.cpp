// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/json.h"

#include <nlohmann/json.hpp>

namespace gnomon::bench {

namespace {

nlohmann::ordered_json to_json(const CullingFrame& f, const CullingBenchOptions& options)
{
    nlohmann::ordered_json json{{"frame", f.frame},
                                {"off", {{"rays", f.off.rays}, {"ms", f.off.ms}, {"wall_ms", f.off.wall_ms}}}};
    if (options.paper)
        json["paper"] = {{"rays", f.paper.rays},
                         {"skipped", f.paper.skipped},
                         {"dynamic_only", f.paper.dynamic_only},
                         {"extra_tests_per_pixel", f.paper.extra_tests_per_pixel},
                         {"wrong", f.paper.wrong},
                         {"ms", f.paper.ms}};
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
        if (options.paper) json["paper"].update({{"nodes", f.paper.nodes}, {"tests", f.paper.tests}});
        if (options.certified) json["certified"].update({{"nodes", f.certified.nodes}, {"tests", f.certified.tests}});
    }
    return json;
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
        const CullingBenchResult::Saved& s = result.paper_saved;
        if (options.counts)
            summary["paper"].update({{"nodes_saved_mean", s.nodes_mean},
                                     {"nodes_saved_best", s.nodes_best},
                                     {"nodes_saved_of_totals", s.nodes_of_totals},
                                     {"tests_saved_mean", s.tests_mean},
                                     {"tests_saved_best", s.tests_best},
                                     {"tests_saved_of_totals", s.tests_of_totals}});
    }
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
        const CullingBenchResult::Saved& s = result.certified_saved;
        if (options.counts)
            summary["certified"].update({{"nodes_saved_mean", s.nodes_mean},
                                         {"nodes_saved_best", s.nodes_best},
                                         {"nodes_saved_of_totals", s.nodes_of_totals},
                                         {"tests_saved_mean", s.tests_mean},
                                         {"tests_saved_best", s.tests_best},
                                         {"tests_saved_of_totals", s.tests_of_totals}});
    }
    return summary;
}

}   // namespace

nlohmann::ordered_json culling_json(const CullingWindow& window)
{
    nlohmann::ordered_json frames = nlohmann::ordered_json::array();
    for (const CullingFrame& frame : window.result.frames) frames.push_back(to_json(frame, window.options));
    return {{"frames", std::move(frames)},
            {"summary", summary_of(window.result, window.options, window.moving_lights)}};
}

}   // namespace gnomon::bench
