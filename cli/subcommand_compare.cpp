// SPDX-License-Identifier: Apache-2.0
// gnomon compare, on the public API alone.
#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/program.h"
#include "cli/subcommands.h"
#include "gnomon/compare.h"

namespace gnomon::cli {

namespace {
using Json = nlohmann::ordered_json;

struct Metric {
    const char* name;
    std::optional<double> (*value)(const CompareResult&);
    bool higher_is_better = false;
};

constexpr std::array<Metric, 7> k_metrics{{
    {"rmse", [](const CompareResult& r) { return std::optional(r.rmse); }},
    {"relmse", [](const CompareResult& r) { return std::optional(r.relmse); }},
    {"psnr", [](const CompareResult& r) { return r.psnr; }, true},
    {"ssim", [](const CompareResult& r) { return r.ssim; }, true},
    {"flip", [](const CompareResult& r) { return r.flip; }},
    {"max_abs", [](const CompareResult& r) { return std::optional(r.max_abs); }},
    {"pixels_different", [](const CompareResult& r) { return std::optional(r.pixels_different); }},
}};

struct Threshold {
    const Metric* metric;
    double limit;
};

Threshold threshold_of(const std::string& word)
{
    const std::size_t equals = word.find('=');
    for (const Metric& metric : k_metrics) {
        if (equals == std::string::npos || word.substr(0, equals) != metric.name) continue;
        if (const std::optional<double> limit = options::parse_number(word.substr(equals + 1)))
            return {&metric, *limit};
    }
    throw UsageError(fmt::format("--fail-above {}: expected METRIC=X, such as rmse=0.01 or psnr=40", word));
}

// Equal images have no psnr and pass every threshold of it. Any other metric that cannot be measured fails.
bool fails(const Threshold& threshold, const CompareResult& result)
{
    const std::optional<double> value = threshold.metric->value(result);
    if (!value) return std::string_view(threshold.metric->name) != "psnr";
    return threshold.metric->higher_is_better ? !(*value >= threshold.limit) : !(*value <= threshold.limit);
}
}   // namespace

int run_compare(const CommandLine& line, Output& output)
{
    const options::OptionValues& values = line.values;
    const std::string metric = values.text("metric");
    std::vector<Threshold> thresholds;
    for (const std::string& word : values.all("fail-above")) thresholds.push_back(threshold_of(word));
    const auto wanted = [&](std::string_view name) {
        bool named = metric == "all" || metric == name;
        for (const Threshold& threshold : thresholds) named = named || threshold.metric->name == name;
        return named;
    };

    CompareOptions options;
    options.layer = values.text("layer");
    options.ssim = wanted("ssim");
    options.flip = wanted("flip");
    options.heatmap = values.text("heatmap");
    options.threads = values.integer("threads");
    const CompareResult result = compare(line.positionals.at(0), line.positionals.at(1), options);

    // Print the metrics that --metric and --fail-above name.
    Json document;
    for (const Metric& m : k_metrics) {
        if (!wanted(m.name)) continue;
        const std::optional<double> value = m.value(result);
        document[m.name] = value ? Json(*value) : Json(nullptr);
        const char* none = std::string_view(m.name) == "psnr" ? "equal" : "-";
        output.say(fmt::format("{:<17}{}", m.name, value ? fmt::format("{:.6g}", *value) : none));
    }

    // Check the thresholds.
    std::string failures;
    for (const Threshold& threshold : thresholds) {
        if (!fails(threshold, result)) continue;
        const std::optional<double> value = threshold.metric->value(result);
        const char* side = threshold.metric->higher_is_better ? "below" : "above";
        failures += failures.empty() ? "" : "; ";
        failures += value ? fmt::format("{} is {:.6g}, {} {:g}", threshold.metric->name, *value, side, threshold.limit)
                          : fmt::format("{} cannot be measured for these images", threshold.metric->name);
    }
    output.finish(document);
    if (failures.empty()) return k_exit_done;
    output.error(failures);
    return k_exit_different;
}

}   // namespace gnomon::cli
