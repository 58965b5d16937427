// SPDX-License-Identifier: Apache-2.0
// The chapter on Nah, Park and Han (2009): their Table 4 and Figures 4 to 8, frames a second apart and the clip's own,
// other readings of the paper and its future work, and certified culling on the same frames.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <tuple>

#include "api/scene_access.h"
#include "bench/culling/figures.h"
#include "bench/culling/json.h"
#include "bench/culling/readings.h"
#include "bench/culling/report.h"
#include "bench/culling/tables.h"
#include "bench/report/chapter.h"
#include "gnomon/scene.h"
#include "options/option_values.h"

namespace gnomon::bench {

namespace {

constexpr int k_paper_depth = 10;            // depth of reflections [3.1]
constexpr int k_paper_frames_kitchen = 22;   // [Table 4]
constexpr int k_paper_frames_robots = 52;
constexpr int k_timed_lights = 4;

constexpr double k_paper_step = 1;   // seconds between the paper's frames, most probably
constexpr double k_early = -1;       // seconds: where the keys of the cameras begin
constexpr double k_steps[] = {2, 1, 0.5, 0.25};
constexpr int k_figure_width = 480, k_figure_height = 360;   // [Figs. 5 and 6]

enum class Show {
    figures,   // all charts of the paper
    brief,     // savings and wrong results
    tree,      // a row of the table of kd-trees
};

struct Wanted {
    std::string scene;
    FrameRange frames;
    bool timed = false;   // time certified culling on primary hits, without counts; else count all, as the paper did
    Show show = Show::figures;
    double weight = 1;
    double step = 0;   // as CullingBenchOptions
    std::optional<double> start{};
    bool readings = false;
    ray::KdLayout layout = ray::KdLayout::separate;
};

// The paper's scenes: its frames, a second apart, from the start of the clip and from a second before it; and the
// clip's own. Later windows are measured, too, because the objects of Kitchen are at rest before frame 121.
void add_paper_windows(std::vector<Wanted>& wanted, const std::string& scene, int frames, double seconds_per_frame,
                       bool quick)
{
    const FrameRange range{1, frames};
    const double weight = frames * seconds_per_frame * (quick ? 0.25 : 1);
    wanted.push_back({scene, range, false, Show::figures, 3 * weight, k_paper_step, {}, !quick});
    if (quick) return;
    wanted.push_back({scene, range, false, Show::brief, weight, k_paper_step, k_early});
    wanted.push_back({scene, range, false, Show::figures, weight});
    wanted.push_back({scene, {121, 120 + frames}, false, Show::brief, weight});
    for (const ray::KdLayout layout : {ray::KdLayout::hierarchy, ray::KdLayout::mixed})
        wanted.push_back({scene, range, false, Show::tree, 2 * weight, k_paper_step, {}, false, layout});
}

std::vector<Wanted> wanted_windows(const BenchSettings& s)
{
    std::vector<Wanted> wanted;
    const BenchScenes& scenes = s.scenes;
    if (!scenes.kitchen.empty()) add_paper_windows(wanted, scenes.kitchen, k_paper_frames_kitchen, 2, s.quick);
    if (!scenes.robots.empty()) add_paper_windows(wanted, scenes.robots, k_paper_frames_robots, 1, s.quick);
    if (wanted.empty())
        wanted.push_back({scenes.stand_in, {1, s.quick ? 8 : 52}, false, Show::figures, s.quick ? 6. : 60.});
    if (!scenes.kitchen.empty()) {
        wanted.push_back({scenes.kitchen, {1, s.quick ? 40 : 100}, true, Show::figures, s.quick ? 9. : 18.});
        if (!s.quick) wanted.push_back({scenes.kitchen, {121, 220}, true, Show::figures, 18});
    }
    if (!scenes.robots.empty() && !s.quick) wanted.push_back({scenes.robots, {1, 100}, true, Show::figures, 12});
    return wanted;
}

class CullingChapter : public BenchChapter {
 public:
    explicit CullingChapter(const BenchSettings& settings) : settings_(settings) {}

    std::vector<BenchPart> parts() override
    {
        std::vector<BenchPart> parts;
        for (const Wanted& wanted : wanted_windows(settings_)) {
            const CullingWindow window = window_of(wanted);
            parts.push_back(
                {fmt::format("{} culling: {}", wanted.timed ? "certified" : "published and certified", name_of(window)),
                 wanted.weight, [this, wanted](const Progress& progress) { measure(wanted, progress); }});
        }
        // The table of steps, at half the paper's width and height, and the figures that are images.
        for (const auto& [scene, seconds] : {std::pair{settings_.scenes.kitchen, 20}, {settings_.scenes.robots, 50}})
            if (!scene.empty() && !settings_.quick)
                parts.push_back({fmt::format("published culling against the step: {}", scene), 1.2 * seconds,
                                 [this, scene = scene, seconds = seconds](const Progress& progress) {
                                     measure_steps(scene, seconds, progress);
                                 }});
        parts.push_back({"figures 5 and 6 of the paper on culling", 3,
                         [this](const Progress& progress) { draw_figures(progress); }});
        return parts;
    }

    std::vector<ReportTable::Row> lead() const override
    {
        std::vector<ReportTable::Row> rows;
        for (const CullingWindow& w : summed()) {
            const PrintedCulling* printed = printed_culling_of(w.scene);
            const auto row = [&](const std::string& what, const std::string& as_printed, double paper, double own,
                                 const char* form) {
                rows.push_back({{fmt::format("{}: {}", name_of(w), what), as_printed,
                                 fmt::format(fmt::runtime(form), paper), fmt::format(fmt::runtime(form), own)},
                                false});
            };
            const auto number = [](double value) { return fmt::format("{:.1f} %", value); };
            const bool same = printed && w.options.step == k_paper_step && !w.options.start;
            if (printed && !same) continue;
            row("traversal steps of shadow rays saved", printed ? number(printed->nodes_mean) : "not in the paper",
                w.result.paper_saved.nodes_mean, w.result.certified_saved.nodes_mean, "{:.1f} %");
            row("triangle tests saved", printed ? number(printed->tests_mean) : "not in the paper",
                w.result.paper_saved.tests_mean, w.result.certified_saved.tests_mean, "{:.1f} %");
            row("wrong results per frame", "not given", w.result.paper_wrong_mean,
                static_cast<double>(w.result.wrong_total) / static_cast<double>(w.result.frames.size()), "{:.1f}");
        }
        for (const CullingWindow& w : timed_)
            rows.push_back({{fmt::format("{}, {} lights: speed-up of the shadow pass", name_of(w), w.lights),
                             "not in the paper", "",
                             fmt::format("{:.2f} x, {:.2f} x over the second half", w.result.speedup_mean,
                                         w.result.speedup_steady)},
                            false});
        return rows;
    }

    void write(ReportPage& page) const override
    {
        const std::vector<CullingWindow>& all = summed();
        if (!all.empty()) {
            page.section("Shadow culling for interactive ray tracing (Nah, Park and Han 2009): Table 4",
                         settings_.command);
            page.text("The sections below give the command that measures each window separately.");
            page.table(table_of_savings(all));
            page.table(table_of_reasons(all));
            if (std::any_of(all.begin(), all.end(), [](const CullingWindow& w) { return !w.options.readings.empty(); }))
                page.table(table_of_readings(all));
            if (!steps_.empty()) add_step_figures(page, steps_);
            if (!trees_.empty()) page.table(table_of_trees(compared_trees()));
            if (!scenes_.empty())
                page.gallery(scenes_,
                             "Figure 6 of the paper: the scenes, in direct light. The paper does not say which "
                             "frames it shows; these are 10 and 25 seconds into the clips.");
            if (zoom_)
                page.gallery(
                    {{"before", zoom_->before},
                     {"the frame of the zoom", zoom_->zoomed},
                     {"the same, every ray traced", zoom_->zoomed_right},
                     {"two frames later", zoom_->after}},
                    fmt::format("Figure 5 of the paper: a floor with posts whose shadows are smaller than a "
                                "pixel, before and after the camera moves in, with the published method. In the "
                                "frame of the zoom {} pixels are wrong, because it still uses the modes of the "
                                "frame before. The zoom resets them [2.6]; after a frame in which everything "
                                "is traced, {} pixels are wrong.",
                                zoom_->wrong_zoomed, zoom_->wrong_after));
            if (!timed_.empty()) page.table(table_of_speed(timed_));
        }
        for (std::size_t i = 0; i < windows_.size(); ++i)
            add_culling_section(page, windows_[i],
                                show_[i] == Show::brief ? CullingCharts::brief : CullingCharts::figures);
        for (const CullingWindow& w : timed_) add_culling_section(page, w);
    }

    std::string name() const override { return "culling"; }
    nlohmann::ordered_json json() const override
    {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const std::vector<CullingWindow>* windows : {&windows_, &trees_, &steps_, &timed_})
            for (const CullingWindow& w : *windows) {
                nlohmann::ordered_json one = culling_json(w);
                one["command"] = w.command;
                list.push_back(std::move(one));
            }
        return list;
    }

 private:
    // The options of a window, and the command line that measures the same.
    CullingWindow window_of(const Wanted& wanted) const
    {
        CullingWindow w;
        w.scene = wanted.scene;
        w.options.frames = wanted.frames;
        w.options.step = wanted.step;
        w.options.start = wanted.start;
        w.options.layout = wanted.layout;
        if (wanted.readings) w.options.readings = all_readings();
        w.options.size = wanted.timed ? Size{512, 512}
                                      : settings_.size();   // small images would time little but the start of the pass
        w.options.threads = wanted.timed ? 1 : 0;   // what counts and processor time say does not depend on threads
        w.options.max_depth = wanted.timed ? 0 : k_paper_depth;
        w.options.counts = w.options.paper = w.options.images = !wanted.timed;
        if (wanted.show == Show::tree) w.options.certified = w.options.images = false;
        w.command = fmt::format("gnomon bench culling {} --frames {}-{} --size {}x{}", options::shell_word(w.scene),
                                wanted.frames.first, wanted.frames.last, w.options.size.width, w.options.size.height);
        w.command += wanted.timed ? fmt::format(" --lights {} --method certified --no-counts", k_timed_lights)
                                  : fmt::format(" --max-depth {}", k_paper_depth);
        if (wanted.step > 0) w.command += fmt::format(" --step {:g}", wanted.step);
        if (wanted.start) w.command += fmt::format(" --start {:g}", *wanted.start);
        if (wanted.show == Show::tree) w.command += fmt::format(" --method paper --tree {}", name_of(wanted.layout));
        if (wanted.readings) {
            w.command += " --reading";
            for (const PaperReading& reading : w.options.readings) w.command += " " + reading.name;
        }
        return w;
    }

    void measure(const Wanted& wanted, const Progress& progress)
    {
        const Scene& whole = loaded(wanted.scene);
        const Scene scene = wanted.timed ? whole.with_lights(k_timed_lights) : whole;
        CullingWindow window = window_of(wanted);
        window.lights = api::scene_of(scene)->lights.size();
        window.result = bench_culling(api::scene_of(scene), window.options, progress);
        if (wanted.timed) {
            timed_.push_back(std::move(window));
        } else if (wanted.show == Show::tree) {
            trees_.push_back(std::move(window));
        } else {
            windows_.push_back(std::move(window));
            show_.push_back(wanted.show);
        }
    }

    const Scene& loaded(const std::string& name)
    {
        if (loaded_name_ != name) {
            loaded_ = std::make_unique<Scene>(load(name));
            loaded_name_ = name;
        }
        return *loaded_;
    }

    // The frames of the largest step over the whole clip, after a history of frames of each step.
    void measure_steps(const std::string& name, int seconds, const Progress& progress)
    {
        const auto scene = api::scene_of(loaded(name));
        CullingWindow window;
        window.scene = name;
        window.lights = scene->lights.size();
        window.options.step = k_steps[0];
        window.options.frames = {1, 1 + static_cast<int>(seconds / k_steps[0])};
        window.options.size = {256, 256};
        window.options.max_depth = k_paper_depth;
        window.options.certified = false;
        window.command = fmt::format(
            "gnomon bench culling {} --frames 1-{} --size 256x256 --max-depth {} --method paper "
            "--step",
            options::shell_word(name), window.options.frames.last, k_paper_depth);
        for (const double step : k_steps) {
            window.command += fmt::format(" {:g}", step);
            window.steps.push_back(measure_step(scene, window, step, progress));
        }
        window.result = window.steps.front().result;
        steps_.push_back(std::move(window));
    }

    void draw_figures(const Progress& progress)
    {
        for (const auto& [name, scene, time] :
             {std::tuple{"BART Kitchen", settings_.scenes.kitchen, 10.}, {"BART Robots", settings_.scenes.robots, 25.}})
            if (!scene.empty())
                scenes_.push_back({name, scene_figure(loaded(scene), time, {k_figure_width, k_figure_height})});
        if (progress) progress({"rendering", 0.5});
        zoom_ = zoom_figure({k_figure_width, k_figure_height});
    }

    // The table of kd-trees begins with the windows of the same frames that were measured on separate trees.
    std::vector<CullingWindow> compared_trees() const
    {
        std::vector<CullingWindow> all;
        for (const CullingWindow& tree : trees_) {
            for (const CullingWindow& w : windows_)
                if (tree.options.layout == ray::KdLayout::hierarchy && w.scene == tree.scene &&
                    w.options.step == tree.options.step && !w.options.start)
                    all.push_back(beginning_of(w, w.options.frames.count()));
            all.push_back(beginning_of(tree, tree.options.frames.count()));
        }
        return all;
    }

    // The windows with counts.
    const std::vector<CullingWindow>& summed() const { return windows_; }

    BenchSettings settings_;
    std::string loaded_name_;
    std::unique_ptr<Scene> loaded_;
    std::vector<CullingWindow> windows_, timed_, trees_, steps_;
    std::vector<Show> show_;   // by window of windows_
    std::vector<NamedImage> scenes_;
    std::optional<ZoomFigure> zoom_;
};

}   // namespace

std::unique_ptr<BenchChapter> culling_chapter(const BenchSettings& settings)
{
    return std::make_unique<CullingChapter>(settings);
}

}   // namespace gnomon::bench
