// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/indirect/figures.h"
#include "bench/indirect/images.h"
#include "bench/indirect/printed.h"
#include "bench/indirect/quality.h"
#include "bench/report/image_figures.h"

namespace gnomon::bench {

namespace {

constexpr int k_crop_samples = 64;   // the crop shows where sampling with this many samples has the strongest pattern
constexpr double k_grey = 0.1;       // the caption states this fraction of the mean in grey levels

using Row = IndirectRow;

std::string optional_number(const std::optional<double>& value, const char* form)
{
    return value ? fmt::format(fmt::runtime(form), *value) : "-";
}

std::string rates_text(const PrintedRates& rates)
{
    return fmt::format("{:.2f} / {:.2f}", rates.kept, rates.not_kept);
}

std::string times_text(double kept, double not_kept)
{
    return fmt::format("{:.1f} / {:.1f}", kept, not_kept);
}

// What rows of smooth validity and of shadows add to the paper.
constexpr double k_margin = 0.5;
constexpr int k_margin_level = 6;
constexpr int k_shadowed_levels[] = {6, 5};
constexpr int k_separate_levels[] = {6, 5, 4};

// The section of one study.
class Section {
 public:
    Section(ReportPage& page, const IndirectStudy& study)
        : page_(page), study_(study), result_(study.result), settings_(study.options.methods.front().settings)
    {
    }

    void write()
    {
        const IndirectBenchOptions& o = study_.options;
        if (!study_.description.empty()) page_.text(study_.description);
        page_.text(fmt::format(
            "Frames {} to {}, {} x {} pixels, light maps of 512 x 512 texels; receivers: {}. Times are process CPU "
            "times over all threads, without the primary hits; {} The paper prints frames per second on a Radeon X1900 "
            "GTX of 2006, so only ratios can be compared.",
            o.frames.first, o.frames.last, o.size.width, o.size.height,
            settings_.full ? "every pixel"
                           : "64 along the longer side, interpolated between them where surfaces are similar",
            o.frames.count() > 1
                ? "means from the second frame on. Kept: the same frame lit again without motion, the paper's 'buffers "
                  "kept'. Repaired: the scene moves, and what moved is repaired in map and tree, which the paper does "
                  "not do. Not kept, as the paper means it: primary hits, map, tree, cut and light are made anew."
                : "the scene is static. Kept: the same frame lit again, the paper's 'buffers kept'. Repaired: the "
                  "first "
                  "frame. Not kept: primary hits, map, tree, cut and light are made anew."));
        page_.text(fmt::format(
            "Errors are root mean square errors of irradiance divided by the mean. 'Against all texels' compares with "
            "the sum over all texels of the light map without visibility, which quad-tree and sampling approximate. "
            "'Against the reference' compares with path tracing ({} paths per point, noise {:.4f}), which takes "
            "visibility into account and so shows the error of ignoring it. The paper uses photon mapping ({} s) as "
            "its reference.",
            o.spp, result_.reference_noise, k_printed_photons_seconds));
        light_maps();
        if (study_.printed != PaperScene::buddha) levels();
        if (study_.printed != PaperScene::sponza) thresholds();
        if (study_.printed != PaperScene::buddha) {
            sampling();
            same_quality();
        }
        beyond_the_paper();
        device();
        if (!result_.image.reference.empty() && !study_.direct.layers.empty()) images();
        everything();
    }

 private:
    const Row* find(const std::string& method) const { return find(method, settings_); }
    const Row* find(const std::string& method, const IndirectSettings& settings) const
    {
        return find_row(result_.rows, method, settings);
    }

    // Adds a line to a table: a title, then a cell for each row of the results.
    template <class Cell>
    static void add_line(ReportTable& table, const std::string& title, const std::vector<const Row*>& rows,
                         const Cell& cell)
    {
        ReportTable::Row line{{title}, false};
        for (const Row* row : rows) line.cells.push_back(row ? cell(*row) : "-");
        table.rows.push_back(std::move(line));
    }
    static void add_printed(ReportTable& table, const std::string& title, std::vector<std::string> cells)
    {
        cells.insert(cells.begin(), title);
        table.rows.push_back({std::move(cells), true});
    }
    static void add_errors(ReportTable& table, const std::vector<const Row*>& rows)
    {
        add_line(table, "error against all texels", rows,
                 [](const Row& r) { return optional_number(r.nrmse_brute, "{:.3f}"); });
        add_line(table, "error against the reference", rows,
                 [](const Row& r) { return optional_number(r.nrmse, "{:.3f}"); });
        add_line(table, "total light, relative to the reference", rows,
                 [](const Row& r) { return optional_number(r.energy_ratio, "{:.3f}"); });
    }
    static std::string kept_times(const Row& r)
    {
        return fmt::format("{:.1f} / {} / {:.1f}", r.cpu_ms_static,
                           r.cpu_ms_not_kept > 0 ? fmt::format("{:.1f}", r.cpu_ms_not_kept) : "-", r.cpu_ms_moving);
    }
    bool is(PaperScene scene) const { return study_.printed == scene; }

    // Shows Figures 3 and 5.
    void light_maps()
    {
        if (study_.map_images.empty()) return;
        page_.gallery(study_.map_images,
                      "As Figure 3: what each texel of the light map holds. Flux is scaled to its brightest texels, "
                      "positions to their bounds, depth to its range.");
        page_.gallery(
            study_.validity_images,
            fmt::format("As Figure 5: the light cluster maps, level by level, with thresholds {} and {}. Valid "
                        "nodes show their flux; invalid ones and the background are black. The paper shows "
                        "its levels 0 to 5; here the finest is 1, as in its text.",
                        settings_.depth_threshold, settings_.normal_threshold));
    }

    // Compares the published method with what we added: shares near the thresholds, separate trees, and shadows of
    // clusters.
    void beyond_the_paper()
    {
        ReportTable table;
        table.caption =
            "Beyond the paper. A margin of validity: near the thresholds, a node and its children share the light, so "
            "that it does not change abruptly. Separate trees: static and dynamic objects have clusters of their own, "
            "so that no cluster is the mean of an object and the wall behind it. Shadows: clusters are occluded by "
            "rays from the receivers; what static "
            "geometry does to the path between a receiver and a cluster that stay is remembered. Printed: the cut as "
            "the paper finds it, one pass a level at every receiver; its light is that of the compacted cut.";
        table.columns = {"",
                         "clusters",
                         "error against all texels",
                         "error against the reference",
                         "total light",
                         "flicker, percent",
                         "kept / not kept / repaired, ms",
                         "rays per frame",
                         "rays left out"};
        for (const IndirectRow& r : result_.rows) {
            const bool printed = r.method.starts_with("printed"), separate = r.method.starts_with("separate"),
                       shadowed = r.method.find("shadowed") != std::string::npos;
            const bool plain = std::any_of(std::begin(k_separate_levels), std::end(k_separate_levels), [&](int level) {
                return r.method == quadtree_name(level) && find(r.method) == &r;
            });
            if (!printed && !separate && !shadowed && !(r.settings.margin > 0) && !plain) continue;
            table.rows.push_back(
                {{name_with_thresholds(r), fmt::format("{}", r.work.clusters), optional_number(r.nrmse_brute, "{:.3f}"),
                  optional_number(r.nrmse, "{:.3f}"), optional_number(r.energy_ratio, "{:.3f}"),
                  r.flicker ? fmt::format("{:.2f}", 100 * *r.flicker) : "-", kept_times(r),
                  shadowed ? fmt::format("{}", r.work.rays) : "-",
                  shadowed ? fmt::format("{}", r.work.rays_left_out) : "-"},
                 false});
        }
        if (table.rows.size() > 1) page_.table(table);
    }

    // Shows whole frames on the device, beside the paper's rates where it printed them.
    void device()
    {
        if (!study_.no_device.empty())
            page_.text(fmt::format("No frames were measured on a device: {}.", study_.no_device));
        for (const DeviceFramesResult& of : study_.device_frames) {
            ReportTable table;
            table.caption = fmt::format(
                "Tables 1 to 3 on the device: whole rasterised frames on {} ({} time, medians), with {}. G-buffer, "
                "light "
                "map, tree, cut and sparse receivers are kept by the renderer itself, or made anew. 'printed' is the "
                "cut "
                "as published, one pass a level; its image must equal that of the compacted cut.",
                of.device, of.clock, of.full ? "receivers at every pixel" : "64 receivers along the longer side");
            table.columns = {"",
                             "lights",
                             "kept / not kept, ms",
                             "not kept, times kept",
                             "printed: frames per second",
                             "printed: not kept, times kept",
                             "values that differ from the compacted cut"};
            for (const DeviceFramesRow& r : of.rows) {
                const std::optional<PrintedRates> rates = is(PaperScene::cornell) ? rates_of(r) : std::nullopt;
                table.rows.push_back(
                    {{r.depth_threshold == settings_.depth_threshold
                          ? r.method
                          : fmt::format("{} ({}, {})", r.method, r.depth_threshold, r.normal_threshold),
                      fmt::format("{}", r.lights),
                      times_text(r.ms_kept, r.ms_not_kept) + (r.kept && r.made ? "" : " (buffers were not as stated)"),
                      fmt::format("{:.2f}", r.ms_not_kept / r.ms_kept), rates ? rates_text(*rates) : "-",
                      rates ? fmt::format("{:.2f}", rates->kept / rates->not_kept) : "-",
                      r.method.starts_with("printed") ? fmt::format("{:.4f} %", 100 * r.different_from_quadtree) : "-"},
                     false});
            }
            page_.table(table);
        }
    }

    // The rates that the paper prints for a method; none for other methods and thresholds.
    std::optional<PrintedRates> rates_of(const DeviceFramesRow& r) const
    {
        if (r.depth_threshold != settings_.depth_threshold) return {};
        for (const PrintedLevel& p : k_printed_levels)
            if (r.method == quadtree_name(p.level) || r.method == fmt::format("printed:{}", p.level)) return p.rates;
        for (const PrintedSampling& p : k_printed_sampling)
            if (r.method == rsm_name(p.samples, k_wide_radius)) return p.rates;
        return {};
    }

    void levels()
    {
        ReportTable table;
        table.caption =
            "Table 1 of the paper (and Figure 7): limit levels, with thresholds 0.05 and 0.9, on the processor. Rates "
            "are kept / not kept. A finer limit level adds clusters, which takes more time and reduces the error.";
        table.columns = {"", "level 6 (16 x 16)", "level 5 (32 x 32)", "level 4 (64 x 64)"};
        std::vector<const Row*> rows;
        std::vector<std::string> rates, ratios;
        const PrintedRates& first = k_printed_levels[0].rates;
        for (const PrintedLevel& p : k_printed_levels) {
            rows.push_back(find(quadtree_name(p.level)));
            rates.push_back(rates_text(p.rates));
            ratios.push_back(
                fmt::format("{:.2f} / {:.2f}", first.kept / p.rates.kept, first.not_kept / p.rates.not_kept));
        }
        if (is(PaperScene::cornell)) {
            add_printed(table, "printed: frames per second", rates);
            add_printed(table, "printed: time relative to level 6", ratios);
        }
        add_line(table, "measured: time relative to level 6", rows, [&](const Row& r) {
            return rows[0] ? fmt::format("{:.2f} / {:.2f}", r.cpu_ms_static / rows[0]->cpu_ms_static,
                                         r.cpu_ms_not_kept / rows[0]->cpu_ms_not_kept)
                           : "-";
        });
        add_line(table, "measured: kept / not kept / repaired, ms", rows, kept_times);
        add_line(table, "clusters", rows, [](const Row& r) { return fmt::format("{}", r.work.clusters); });
        add_errors(table, rows);
        page_.table(table);
    }

    void thresholds()
    {
        if (!find(quadtree_name(5))) return;
        ReportTable table;
        table.caption =
            "Table 2 of the paper (and Figure 8): thresholds of depth and normal, with limit level 5; times are kept. "
            "Looser thresholds give fewer and less uniform clusters.";
        table.columns = {"", "0.45, 0.3", "0.25, 0.6", "0.05, 0.9"};
        std::vector<const Row*> rows;
        std::vector<std::string> cornell, buddha, ratios, buddha_ratios;
        for (const PrintedThresholds& p : k_printed_thresholds) {
            IndirectSettings settings = settings_;
            settings.depth_threshold = p.depth, settings.normal_threshold = p.normal;
            rows.push_back(find(quadtree_name(5), settings));
            cornell.push_back(fmt::format("{:.2f}", p.cornell)), buddha.push_back(fmt::format("{:.2f}", p.buddha));
            ratios.push_back(fmt::format("{:.2f}", k_printed_thresholds.back().cornell / p.cornell));
            buddha_ratios.push_back(fmt::format("{:.2f}", k_printed_thresholds.back().buddha / p.buddha));
        }
        const Row* const last = rows.back();
        if (is(PaperScene::cornell)) {
            add_printed(table, "printed: frames per second, Cornell box", cornell);
            add_printed(table, "printed: time relative to 0.05, 0.9, Cornell box", ratios);
        }
        if (is(PaperScene::buddha)) {
            add_printed(table, "printed: frames per second, Happy Buddha", buddha);
            add_printed(table, "printed: time relative to 0.05, 0.9, Happy Buddha", buddha_ratios);
        }
        add_line(table, "measured: time relative to 0.05, 0.9", rows, [&](const Row& r) {
            return last ? fmt::format("{:.2f}", r.cpu_ms_static / last->cpu_ms_static) : "-";
        });
        add_line(table, "measured: ms", rows, [](const Row& r) { return fmt::format("{:.1f}", r.cpu_ms_static); });
        add_line(table, "clusters", rows, [](const Row& r) { return fmt::format("{}", r.work.clusters); });
        add_errors(table, rows);
        page_.table(table);
    }

    void sampling()
    {
        if (!find(rsm_name(k_printed_sampling[0].samples, k_wide_radius))) return;
        ReportTable table;
        table.caption = fmt::format(
            "Table 3 of the paper (and Figure 9): the quad-tree compared with sampling the light map, on the "
            "processor. "
            "Rates are kept / not kept. The paper does not state the radius of its samples. Within {} of the map's "
            "side, the radius "
            "published with sampling in 2005, samples miss most of a room's light; within {} they cover it.",
            k_published_radius, k_wide_radius);
        table.columns = {"", "quad-tree, level 6", "level 5"};
        std::vector<const Row*> rows{find(quadtree_name(6)), find(quadtree_name(5))};
        std::vector<std::string> rates{rates_text(k_printed_levels[0].rates), rates_text(k_printed_levels[1].rates)};
        for (const double radius : {k_wide_radius, k_published_radius})
            for (const PrintedSampling& p : k_printed_sampling) {
                table.columns.push_back(fmt::format("{} samples within {}", p.samples, radius));
                rows.push_back(find(rsm_name(p.samples, radius)));
                rates.push_back(rates_text(p.rates));
            }
        if (is(PaperScene::cornell)) add_printed(table, "printed: frames per second", rates);
        add_line(table, "measured: kept / not kept / repaired, ms", rows, kept_times);
        add_errors(table, rows);
        add_line(table, "flicker, percent", rows,
                 [](const Row& r) { return r.flicker ? fmt::format("{:.2f}", 100 * *r.flicker) : "-"; });
        page_.table(table);
    }

    void same_quality()
    {
        const std::vector<Sampled> samples = sampled_rows(result_.rows, settings_);
        if (samples.size() < 2) return;
        // Chart time against error.
        Chart chart{"Time against error", "error against all texels", "ms, not kept", {}, {}, {}, {}, {}};
        chart.logarithmic = true;
        ChartSeries tree{"quad-tree, levels 4 to 6", {}, k_color_paper}, sampled{"sampling", {}, k_color_off};
        for (const int level : k_indirect_levels)
            if (const Row* r = find(quadtree_name(level)); r && r->nrmse_brute)
                tree.points.emplace_back(*r->nrmse_brute, r->cpu_ms_moving);
        for (const Sampled& s : samples) sampled.points.emplace_back(s.error, s.not_kept);
        for (ChartSeries* series : {&tree, &sampled}) {
            std::sort(series->points.begin(), series->points.end());
            chart.series.push_back(*series);
        }
        page_.chart(chart,
                    fmt::format("Time against error. Sampling uses {} to {} samples within {} of the map's side.",
                                k_indirect_samples[0], samples.back().samples, k_wide_radius));

        // Compare at equal quality and at equal time.
        ReportTable table;
        table.caption =
            "The main result of the paper (Figure 9): sampling at the quad-tree's quality, and at its speed. The "
            "number of samples with the quad-tree's error against all texels is interpolated between two measured "
            "numbers; < and > mark values beyond the measured range. The paper compared quality visually.";
        table.columns = {"",
                         "clusters",
                         "samples at equal quality",
                         "speed-up, kept / not kept",
                         "samples at equal time",
                         "error of these samples, of the quad-tree"};
        if (is(PaperScene::cornell))
            table.rows.push_back(
                {{"printed", fmt::format("{}", k_printed_clusters), fmt::format("{}", k_printed_same_quality.samples),
                  times_text(k_printed_clusters_rates.kept / k_printed_same_quality.rates.kept,
                             k_printed_clusters_rates.not_kept / k_printed_same_quality.rates.not_kept),
                  fmt::format("{}", k_printed_same_speed.samples), "not given"},
                 true});
        for (const int level : k_indirect_levels) {
            const Row* const r = find(quadtree_name(level));
            if (!r || !r->nrmse_brute) continue;
            const SampledAt good = sampled_of_error(samples, *r->nrmse_brute);
            const SampledAt fast = sampled_of_time(samples, r->cpu_ms_moving);
            table.rows.push_back(
                {{fmt::format("measured, limit level {}", level), fmt::format("{}", r->work.clusters),
                  fmt::format("{}{:.0f}", good.beyond, good.at.samples),
                  good.beyond + times_text(good.at.kept / r->cpu_ms_static, good.at.not_kept / r->cpu_ms_moving),
                  fmt::format("{}{:.0f}", fast.beyond, fast.at.samples),
                  fmt::format("{}{:.3f}, {:.3f}", *fast.beyond == '<' ? "> " : "", fast.at.error, *r->nrmse_brute)},
                 false});
        }
        page_.table(table);
    }

    // Compares images with the reference, and the quad-tree with sampling.
    void images()
    {
        Tasks tasks(study_.options.threads);
        if (const Row* tree = find(quadtree_name(is(PaperScene::sponza) ? 6 : 4)); tree && !tree->image.empty()) {
            std::string caption = fmt::format("Frame {}, {}: ", result_.image.frame, tree->title);
            if (is(PaperScene::sponza))
                caption +=
                    "as Figure 10. The paper prints 30 to 50 frames per second without sub-sampling, on its graphics "
                    "card.";
            else
                caption +=
                    "as Figure 1: direct light, indirect light, and both. The paper shows a dragon in a box; surfaces "
                    "take on the colours of the walls.";
            page_.gallery(light_figures(study_, tree->image), caption);
        }
        const Image8 reference = lit_image(study_, result_.image.reference);
        const auto show = [&](const Row* row, const std::string& caption, const Row* against = nullptr) {
            if (!row || (against && against->image.empty())) return;
            page_.comparison(compare_images(caption, name_with_thresholds(*row), lit_image(study_, row->image),
                                            against ? name_with_thresholds(*against) : "reference",
                                            against ? lit_image(study_, against->image) : reference, tasks));
        };
        const std::string at =
            fmt::format("Frame {}: direct light and one bounce, no reflections.", result_.image.frame);
        show(find("visible"), at + " Gnomon's default method.");
        for (const int level : k_indirect_levels)
            show(find(quadtree_name(level)), fmt::format("{} As in Figure 7: limit level {}.", at, level));
        IndirectSettings loose = settings_;
        loose.depth_threshold = k_printed_thresholds[0].depth, loose.normal_threshold = k_printed_thresholds[0].normal;
        if (const Row* tight = find(quadtree_name(5)))
            show(find(quadtree_name(5), loose), at + " As in Figure 8: loose thresholds (0.45, 0.3) and tight ones.",
                 tight);
        if (const Row* tree = find(quadtree_name(6)); tree && tree->nrmse_brute) {
            const auto speed = [&](const Row& r) { return r.cpu_ms_moving / tree->cpu_ms_moving; };
            const auto error = [&](const Row& r) { return *r.nrmse_brute / *tree->nrmse_brute; };
            show(nearest_sampling(speed), at + " As in Figure 9: sampling at about the same speed.", tree);
            show(nearest_sampling(error), at + " As in Figure 9: sampling with about the same error.", tree);
        }
        crops();
    }

    // The row of sampling whose ratio is nearest to 1; null if there is none.
    template <class Ratio>
    const Row* nearest_sampling(const Ratio& ratio) const
    {
        const Row* nearest = nullptr;
        const auto distance = [&](const Row& row) { return std::abs(std::log(ratio(row))); };
        for (const int samples : k_indirect_samples)
            if (const Row* row = find(rsm_name(samples, k_wide_radius)); row && row->nrmse_brute)
                if (!nearest || distance(*row) < distance(*nearest)) nearest = row;
        return nearest;
    }

    // Shows crops with enhanced contrast.
    void crops()
    {
        const Row *smooth = find(quadtree_name(4)), *few = find(rsm_name(k_crop_samples, k_wide_radius));
        if (!smooth || !few) return;
        const Size size = study_.options.size;
        const IndirectCrop crop = most_patterned(size, smooth->image, few->image);
        std::vector<NamedImage> list;
        const auto add = [&](const std::string& name, const std::vector<glm::vec3>& light) {
            list.push_back({name, contrast_crop(crop, size, light)});
        };
        add("reference", result_.image.reference);
        for (const Row& row : result_.rows)
            if (!row.image.empty()) add(name_with_thresholds(row), row.image);
        page_.gallery(list,
                      fmt::format("Irradiance of {} x {} pixels from ({}, {}) in frame {}, where sampling with few "
                                  "samples shows the strongest pattern. Contrast is enhanced around the mean of each "
                                  "crop: a tenth of the mean is {:.0f} of 256 grey levels.",
                                  crop.side, crop.side, crop.x, crop.y, result_.image.frame, 255 * k_grey * crop.gain));
    }

    std::string name_with_thresholds(const Row& row) const
    {
        if (row.settings.depth_threshold == settings_.depth_threshold &&
            row.settings.normal_threshold == settings_.normal_threshold)
            return row.method;
        return fmt::format("{} ({}, {})", row.method, row.settings.depth_threshold, row.settings.normal_threshold);
    }

    void everything()
    {
        ReportTable table;
        table.caption =
            "All methods. Repair updates the light map and its tree after motion; rebuild computes them from scratch. "
            "Dirty counts texels and nodes that changed in a frame. Flicker is the difference between a point's change "
            "of irradiance from frame to frame and the reference's, in percent of the mean; in parentheses the same "
            "value between two references, the noise floor.";
        table.columns = {"method",
                         "lights",
                         "error against the reference",
                         "error against all texels",
                         "total light",
                         "flicker, %",
                         "repaired, ms",
                         "kept, ms",
                         "not kept, ms",
                         "first frame, ms",
                         "repair, ms",
                         "rebuild, ms",
                         "dirty texels + nodes",
                         "MB"};
        for (const Row& r : result_.rows)
            table.rows.push_back(
                {{name_with_thresholds(r), fmt::format("{}", r.work.clusters), optional_number(r.nrmse, "{:.3f}"),
                  optional_number(r.nrmse_brute, "{:.3f}"), optional_number(r.energy_ratio, "{:.3f}"),
                  r.flicker ? fmt::format("{:.2f} ({:.2f})", 100 * *r.flicker, 100 * r.flicker_floor.value_or(0)) : "-",
                  fmt::format("{:.1f}", r.cpu_ms_moving), fmt::format("{:.1f}", r.cpu_ms_static),
                  r.cpu_ms_not_kept > 0 ? fmt::format("{:.1f}", r.cpu_ms_not_kept) : "-",
                  fmt::format("{:.1f}", r.cpu_ms_cold), fmt::format("{:.2f}", r.cpu_ms_repair),
                  fmt::format("{:.1f}", r.cpu_ms_rebuild),
                  fmt::format("{} + {}", r.work.dirty_pixels, r.work.dirty_nodes),
                  fmt::format("{:.1f}", static_cast<double>(r.work.bytes) / 1e6)},
                 false});
        page_.table(table);
    }

    ReportPage& page_;
    const IndirectStudy& study_;
    const IndirectBenchResult& result_;
    IndirectSettings settings_;
};

}   // namespace

std::vector<IndirectMethodInfo> indirect_methods_of_paper(const IndirectSettings& settings)
{
    std::vector<IndirectMethodInfo> methods{find_indirect_method("visible", settings)};
    for (const int level : k_indirect_levels) methods.push_back(find_indirect_method(quadtree_name(level), settings));
    for (const PrintedThresholds& p : k_printed_thresholds) {
        IndirectSettings other = settings;
        other.depth_threshold = p.depth, other.normal_threshold = p.normal;
        if (p.depth != settings.depth_threshold || p.normal != settings.normal_threshold)
            methods.push_back(find_indirect_method(quadtree_name(5), other));
    }
    if (!settings.vulkan) {
        methods.push_back(find_indirect_method(fmt::format("quadtree:{}:{}", k_margin_level, k_margin), settings));
        for (const int level : k_separate_levels)
            methods.push_back(find_indirect_method(fmt::format("separate:{}", level), settings));
        // At every pixel, rays to all clusters would take most of the report's time.
        if (!settings.full) {
            for (const int level : k_shadowed_levels)
                for (const char* name : {"shadowed", "separate-shadowed"})
                    methods.push_back(find_indirect_method(fmt::format("{}:{}", name, level), settings));
        }
    }
    methods.push_back(find_indirect_method(fmt::format("printed:{}", k_margin_level), settings));
    for (const int samples : k_indirect_samples)
        methods.push_back(find_indirect_method(rsm_name(samples, k_wide_radius), settings));
    for (const PrintedSampling& p : k_printed_sampling)
        methods.push_back(find_indirect_method(rsm_name(p.samples, k_published_radius), settings));
    return methods;
}

PaperScene paper_scene_of(const std::string& scene)
{
    return scene == "builtin:cornell" ? PaperScene::cornell : PaperScene::none;
}

void add_indirect_section(ReportPage& page, const IndirectStudy& study)
{
    page.section("Indirect light by a light quad-tree (Ki and Oh 2007): " + study.scene +
                     (study.options.methods.front().settings.full ? ", every pixel" : ""),
                 study.command);
    Section(page, study).write();
    page.attach("indirect.json", indirect_json(study));
}

}   // namespace gnomon::bench
