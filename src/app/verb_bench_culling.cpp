// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/culling_bench.h"
#include "app/verbs.h"

namespace gnomon::app {

namespace {

nlohmann::json to_json(const CullingFrame& f, const CullingBenchOptions& options)
{
    nlohmann::json json{{"frame", f.frame},
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

std::string line_of(const CullingFrame& f, const CullingBenchOptions& options)
{
    const auto share = [&](std::uint64_t n) {
        return 100.0 * static_cast<double>(n) / std::max<double>(1, static_cast<double>(f.off.rays));
    };
    std::string text = fmt::format("frame {:4}  off {} rays, {:.1f} ms", f.frame, f.off.rays, f.off.ms);
    if (options.paper)
        text += fmt::format("; paper {:.1f} % skipped, {:.1f} % dynamic only, {} wrong, {:.1f} ms",
                            share(f.paper.skipped), share(f.paper.dynamic_only), f.paper.wrong, f.paper.ms);
    if (options.certified)
        text +=
            fmt::format("; certified {:.1f} % skipped, {:.2f} % dynamic only, {} wrong, {:.1f} ms",
                        share(f.certified.skipped), share(f.certified.dynamic_only), f.certified.wrong, f.certified.ms);
    return text;
}

}   // namespace

int run_bench_culling(const CommandLine& line, Output& output)
{
    const OptionValues& values = line.values;
    const Scene scene = load_scene(line, output.progress());
    CullingBenchOptions options;
    options.frames = {1, std::min(100, scene.frame_count())};
    if (values.given("frames")) options.frames = *parse_range(values.text("frames"));
    if (options.frames.last > scene.frame_count() || options.frames.count() < 1)
        throw UsageError(fmt::format("no frames {} to {}: the clip has frames 1 to {}", options.frames.first,
                                     options.frames.last, scene.frame_count()));
    if (values.given("size")) options.size = *parse_size(values.text("size"));
    options.threads = values.given("threads") ? values.integer("threads") : 1;
    options.counts = !values.flag("no-counts");
    if (const std::vector<std::string> methods = values.all("method"); !methods.empty()) {
        options.paper = std::find(methods.begin(), methods.end(), "paper") != methods.end();
        options.certified = std::find(methods.begin(), methods.end(), "certified") != methods.end();
    }

    nlohmann::json frames = nlohmann::json::array();
    const CullingBenchResult result = bench_culling(scene.inside(), options, [&](const CullingFrame& frame) {
        output.say(line_of(frame, options));
        frames.push_back(to_json(frame, options));
    });

    nlohmann::json summary;
    if (options.paper) {
        summary["paper"] = {{"extra_tests_per_pixel", result.paper_extra_tests_per_pixel},
                            {"wrong_mean", result.paper_wrong_mean}};
        if (options.counts) {
            const CullingBenchResult::Saved& s = result.paper_saved;
            summary["paper"].update({{"nodes_saved_mean", s.nodes_mean},
                                     {"nodes_saved_best", s.nodes_best},
                                     {"tests_saved_mean", s.tests_mean},
                                     {"tests_saved_best", s.tests_best}});
            output.say(fmt::format("paper      nodes saved {:.1f} % (best {:.1f}), tests {:.1f} % (best {:.1f})",
                                   s.nodes_mean, s.nodes_best, s.tests_mean, s.tests_best));
        }
        output.say(fmt::format("paper      {:.3f} extra tests a pixel, {:.1f} wrong a frame",
                               result.paper_extra_tests_per_pixel, result.paper_wrong_mean));
    }
    if (options.certified) {
        summary["certified"] = {{"speedup_mean", result.speedup_mean},
                                {"speedup_steady", result.speedup_steady},
                                {"first_frame_ratio", result.first_frame_ratio},
                                {"worst_frame_ratio", result.worst_frame_ratio},
                                {"wrong_total", result.wrong_total},
                                {"bytes", result.bytes},
                                {"visible_triangles", result.visible_triangles}};
        if (options.counts) {
            summary["certified"].update({{"nodes_saved_mean", result.certified_saved.nodes_mean},
                                         {"tests_saved_mean", result.certified_saved.tests_mean}});
            output.say(fmt::format("certified  nodes saved {:.1f} %, tests {:.1f} %", result.certified_saved.nodes_mean,
                                   result.certified_saved.tests_mean));
        }
        output.say(
            fmt::format("certified  {:.2f} x faster, {:.2f} x over the second half; first frame {:.2f} x the time, "
                        "worst later one {:.2f} x; {} wrong; {:.1f} MB",
                        result.speedup_mean, result.speedup_steady, result.first_frame_ratio, result.worst_frame_ratio,
                        result.wrong_total, static_cast<double>(result.bytes) / 1e6));
    }
    output.finish({{"frames", frames}, {"summary", summary}});
    return 0;
}

}   // namespace gnomon::app
