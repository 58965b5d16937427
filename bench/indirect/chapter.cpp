// SPDX-License-Identifier: Apache-2.0
// The chapter on Ki and Oh (2007): Tables 1 and 3 and Figures 3, 5 and 7 to 9 in the built-in Cornell box, with sparse
// receivers as in the paper and with receivers at all pixels, on the processor and on the device; Table 2 and Figure 1
// with the Happy Buddha in the box; Figure 10 in Sponza.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "api/scene_access.h"
#include "bench/core/buddha_box.h"
#include "bench/indirect/figures.h"
#include "bench/indirect/printed.h"
#include "bench/indirect/quality.h"
#include "bench/indirect/report.h"
#include "bench/report/chapter.h"
#include "gnomon/error.h"
#include "gnomon/scene.h"
#include "options/option_values.h"

namespace gnomon::bench {

namespace {

constexpr const char* k_cornell = "builtin:cornell";
constexpr int k_headline_level = 6;

// Sponza's light, which the paper does not state: the caption of Figure 10 shows sunlight that falls into the court
// from above, and the rest lit by it indirectly.
constexpr const char* k_sponza_light = "spot -200 1100 -150 0.5 -1 0.2 42 4e6 4e6 4e6";

struct PlannedStudy {
    std::string name;   // of the part
    double weight = 1;
    std::function<Scene()> load_scene;
    bool maps = false;   // show what the light map holds
    std::vector<DeviceFramesOptions> on_device{};
    IndirectStudy study{};
};

class IndirectChapter : public BenchChapter {
 public:
    explicit IndirectChapter(const BenchSettings& settings) : settings_(settings)
    {
        for (const bool full : {false, true})
            if (!full || !settings.quick) plan_cornell(full);
        if (!settings.quick && !settings.scenes.buddha.empty()) plan_buddha();
        if (!settings.quick && !settings.scenes.sponza.empty()) plan_sponza();
    }

    std::vector<BenchPart> parts() override
    {
        std::vector<BenchPart> parts;
        for (PlannedStudy& planned : studies_) {
            parts.push_back({planned.name, planned.weight,
                             [this, &planned](const Progress& progress) { measure(planned, progress); }});
            if (!planned.on_device.empty())
                parts.push_back({planned.name + ", on the device", 0.3 * planned.weight,
                                 [&planned](const Progress& progress) { measure_on_device(planned, progress); }});
        }
        return parts;
    }

    std::vector<std::string> left_out() const override
    {
        std::vector<std::string> list;
        if (settings_.quick)
            list.push_back(
                "Left out with --quick: the light quad-tree at every pixel, Table 2 for the Buddha with Figure 1, and "
                "Figure 10 in Sponza.");
        return list;
    }

    std::vector<ReportTable::Row> lead() const override
    {
        std::vector<ReportTable::Row> rows;
        for (const PlannedStudy& planned : studies_) {
            const IndirectStudy& study = planned.study;
            if (study.printed != PaperScene::cornell) continue;
            const IndirectSettings settings = study.options.methods.front().settings;
            const auto& all = study.result.rows;
            const IndirectRow *tree = find_row(all, quadtree_name(k_headline_level), settings),
                              *visible = find_row(all, "visible", settings);
            const std::vector<Sampled> samples = sampled_rows(all, settings);
            if (!tree || !visible || samples.size() < 2 || !tree->nrmse_brute) continue;
            const SampledAt same = sampled_of_error(samples, *tree->nrmse_brute);
            const std::string of = settings.full ? "every pixel" : "64 receivers per side";
            rows.push_back(
                {{fmt::format("Indirect light, {}: speed-up over sampling of equal quality, buffers kept / repaired",
                              of),
                  fmt::format("{:.1f} / {:.1f}", k_printed_clusters_rates.kept / k_printed_same_quality.rates.kept,
                              k_printed_clusters_rates.not_kept / k_printed_same_quality.rates.not_kept),
                  fmt::format("{}{:.1f} / {:.1f}", same.beyond, same.at.kept / tree->cpu_ms_static,
                              same.at.not_kept / tree->cpu_ms_moving),
                  ""},
                 false});
            const auto error = [](const IndirectRow& r) {
                return fmt::format("{:.3f} in {:.1f} ms of CPU time", r.nrmse.value_or(0), r.cpu_ms_moving);
            };
            rows.push_back({{fmt::format("Indirect light, {}: error against a path-traced reference", of), "not given",
                             error(*tree), error(*visible)},
                            false});
            add_device_lead(rows, study);
        }
        return rows;
    }

    void write(ReportPage& page) const override
    {
        for (const PlannedStudy& planned : studies_)
            if (!planned.study.result.rows.empty()) add_indirect_section(page, planned.study);
    }

    std::string name() const override { return "indirect"; }
    nlohmann::ordered_json json() const override
    {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const PlannedStudy& planned : studies_) {
            if (planned.study.result.rows.empty()) continue;
            list.push_back(indirect_json(planned.study));
            list.back()["command"] = planned.study.command;
        }
        return list;
    }

 private:
    void plan_cornell(bool full)
    {
        const bool quick = settings_.quick;
        PlannedStudy planned{fmt::format("indirect light: {}", full ? "receivers at every pixel" : "sparse receivers"),
                             full    ? 80.
                             : quick ? 8.
                                     : 60.,
                             [] { return load(k_cornell); }};
        planned.maps = !full;
        IndirectStudy& study = planned.study;
        study.scene = k_cornell;
        study.printed = PaperScene::cornell;
        IndirectBenchOptions& o = study.options;
        o.frames = {1, quick || full ? 3 : 6};
        o.size = settings_.size();
        o.threads = settings_.threads;
        o.spp = quick ? 256 : 4096;
        o.image_spp = quick ? 64 : 512;
        o.judged = 2;
        o.images = true;
        IndirectSettings methods;
        methods.full = full;
        o.methods = indirect_methods_of_paper(methods);
        study.command = fmt::format(
            "gnomon bench indirect {} --frames {}-{} --size {}x{} --spp {} --judged {} --receivers {} --report out",
            k_cornell, o.frames.first, o.frames.last, o.size.width, o.size.height, o.spp, o.judged,
            full ? "full" : "64");

        DeviceFramesOptions device;
        device.size = o.size;
        device.full = full;
        device.repeats = quick ? 1 : 3;
        device.methods = {"quadtree:6", "quadtree:5", "quadtree:4", "printed:6"};
        if (!quick) {
            for (const char* method : {"printed:5", "rsm:256:1"}) device.methods.emplace_back(method);
            if (!full)
                for (const char* method : {"printed:4", "rsm:2040:1"}) device.methods.emplace_back(method);
            for (const PrintedThresholds& p : k_printed_thresholds)
                if (p.depth != methods.depth_threshold) device.thresholds.emplace_back(p.depth, p.normal);
        }
        planned.on_device = {device};
        studies_.push_back(std::move(planned));
    }

    // The three thresholds of Table 2, and a fine level for Figure 1.
    void plan_buddha()
    {
        const std::string file = settings_.scenes.buddha;
        PlannedStudy planned{"indirect light: Buddha in the box", 40, [file] { return make_buddha_box(file); }};
        IndirectStudy& study = planned.study;
        study.scene = "Buddha in the box";
        study.printed = PaperScene::buddha;
        study.description =
            "The Happy Buddha of 50,000 triangles stands in builtin:cornell in place of the two blocks; light, camera "
            "and the ball that moves are the box's. The paper's Buddha has 24,975 vertices, this one 24,950; how the "
            "paper placed and lit it is not stated.";
        plan_options(study, {1, 3}, 512, 64, false);
        IndirectSettings settings;
        for (const int level : {4, 5})
            study.options.methods.push_back(find_indirect_method(quadtree_name(level), settings));
        for (const PrintedThresholds& p : k_printed_thresholds) {
            IndirectSettings other = settings;
            other.depth_threshold = p.depth, other.normal_threshold = p.normal;
            if (p.depth != settings.depth_threshold)
                study.options.methods.push_back(find_indirect_method(quadtree_name(5), other));
        }
        study.command = settings_.command;
        DeviceFramesOptions device;
        device.size = study.options.size;
        device.methods = {"quadtree:5"};
        for (const PrintedThresholds& p : k_printed_thresholds)
            if (p.depth != settings.depth_threshold) device.thresholds.emplace_back(p.depth, p.normal);
        planned.on_device = {device};
        studies_.push_back(std::move(planned));
    }

    // Figure 10: level 6, textured, without sub-sampling.
    void plan_sponza()
    {
        const std::string file = settings_.scenes.sponza;
        PlannedStudy planned{"indirect light: Sponza", 60,
                             [file] { return load(file).with_light_specs({k_sponza_light}); }};
        planned.maps = true;
        IndirectStudy& study = planned.study;
        study.scene = "Sponza";
        study.printed = PaperScene::sponza;
        study.description =
            "The atrium with its textures, lit by one spot light from above, without sub-sampling, as Figure 10. The "
            "paper states neither the light nor the camera.";
        plan_options(study, {1, 1}, 1024, 32, true);
        IndirectSettings settings;
        settings.full = true;
        study.options.methods.push_back(find_indirect_method(quadtree_name(k_headline_level), settings));
        study.command = fmt::format(
            "gnomon bench indirect {} --light \"{}\" --frames 1-1 --size {}x{} --spp {} --judged 1 --receivers full "
            "--report out",
            options::shell_word(file), k_sponza_light, study.options.size.width, study.options.size.height,
            study.options.spp);
        DeviceFramesOptions device;
        device.size = study.options.size;
        device.full = true;
        device.repeats = 1;
        device.methods = {"quadtree:6"};
        planned.on_device = {device};
        studies_.push_back(std::move(planned));
    }

    void plan_options(IndirectStudy& study, FrameRange frames, int spp, int image_spp, bool full) const
    {
        IndirectBenchOptions& o = study.options;
        o.frames = frames;
        o.size = settings_.size();
        o.threads = settings_.threads;
        o.spp = spp;
        o.image_spp = image_spp;
        o.judged = 1;
        o.view_steps = full ? 0 : 4;
        o.images = true;
    }

    void measure(PlannedStudy& planned, const Progress& progress) const
    {
        IndirectStudy& study = planned.study;
        const Scene scene = planned.load_scene();
        study.result = bench_indirect(api::scene_of(scene), study.options, progress);
        study.direct = direct_light(scene, study);
        if (!planned.maps) return;
        Tasks tasks(settings_.threads);
        LightMapFigures figures = light_map_figures(api::scene_of(scene), study.result.image.frame, {}, tasks);
        study.map_images = std::move(figures.map), study.validity_images = std::move(figures.validity);
    }

    static void measure_on_device(PlannedStudy& planned, const Progress& progress)
    {
        const Scene scene = planned.load_scene();
        try {
            for (DeviceFramesOptions& options : planned.on_device) {
                options.camera = planned.study.options.camera;
                planned.study.device_frames.push_back(measure_device_frames(api::scene_of(scene), options, progress));
            }
        } catch (const MissingError& error) {
            planned.study.no_device = error.what();
            throw;
        }
    }

    // The ratio of not kept to kept, on the device.
    static void add_device_lead(std::vector<ReportTable::Row>& rows, const IndirectStudy& study)
    {
        for (const DeviceFramesResult& of : study.device_frames)
            for (const DeviceFramesRow& r : of.rows)
                if (r.method == quadtree_name(k_headline_level))
                    rows.push_back(
                        {{fmt::format("Indirect light on the device, {}: time of a frame with buffers not kept, times "
                                      "kept",
                                      of.full ? "every pixel" : "64 receivers per side"),
                          fmt::format("{:.2f}", k_printed_levels[0].rates.kept / k_printed_levels[0].rates.not_kept),
                          fmt::format("{:.2f}", r.ms_not_kept / r.ms_kept), ""},
                         false});
    }

    BenchSettings settings_;
    std::vector<PlannedStudy> studies_;
};

}   // namespace

std::unique_ptr<BenchChapter> indirect_chapter(const BenchSettings& settings)
{
    return std::make_unique<IndirectChapter>(settings);
}

}   // namespace gnomon::bench
