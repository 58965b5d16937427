// SPDX-License-Identifier: Apache-2.0
// The chapter on Nah, Park and Han (2009): their Table 4 and Figures 7 and 8, later frames in which objects move, and
// certified culling on the same frames.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "api/scene_access.h"
#include "bench/culling/json.h"
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

struct Wanted {
    std::string scene;
    FrameRange frames;
    bool timed = false;   // time certified culling on primary hits, without counts; else count all, as the paper did
    bool brief = false;   // show only savings and wrong results
    double weight = 1;
};

// Later windows are measured, too, because the objects of Kitchen are at rest before frame 121.
std::vector<Wanted> wanted_windows(const BenchSettings& s)
{
    std::vector<Wanted> wanted;
    const BenchScenes& scenes = s.scenes;
    if (!scenes.kitchen.empty()) {
        wanted.push_back(
            {scenes.kitchen, {1, s.quick ? k_paper_frames_kitchen : 52}, false, false, s.quick ? 15. : 110.});
        if (!s.quick) {
            wanted.push_back({scenes.kitchen, {121, 142}, false, true, 40});
            wanted.push_back({scenes.kitchen, {200, 221}, false, true, 50});
        }
    }
    if (!scenes.robots.empty()) {
        wanted.push_back({scenes.robots, {1, k_paper_frames_robots}, false, false, s.quick ? 20. : 60.});
        if (!s.quick) {
            wanted.push_back({scenes.robots, {121, 172}, false, true, 60});
            wanted.push_back({scenes.robots, {301, 352}, false, true, 60});
        }
    }
    if (wanted.empty()) wanted.push_back({scenes.stand_in, {1, s.quick ? 8 : 52}, false, false, s.quick ? 6. : 60.});
    if (!scenes.kitchen.empty()) {
        wanted.push_back({scenes.kitchen, {1, s.quick ? 40 : 100}, true, false, s.quick ? 9. : 18.});
        if (!s.quick) wanted.push_back({scenes.kitchen, {121, 220}, true, false, 18});
    }
    if (!scenes.robots.empty() && !s.quick) wanted.push_back({scenes.robots, {1, 100}, true, false, 12});
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
            const bool same = printed && w.options.frames == FrameRange{1, printed->frames};
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
        const std::vector<CullingWindow> all = summed();
        if (!all.empty()) {
            page.section("Shadow culling for interactive ray tracing (Nah, Park and Han 2009): Table 4",
                         settings_.command);
            page.text("The sections below give the command that measures each window separately.");
            page.table(table_of_savings(all));
            if (!timed_.empty()) page.table(table_of_speed(timed_));
        }
        for (std::size_t i = 0; i < windows_.size(); ++i) {
            const bool brief = brief_[i] != 0;
            add_culling_section(page, windows_[i], brief ? CullingCharts::brief : CullingCharts::figures);
        }
        for (const CullingWindow& w : timed_) add_culling_section(page, w);
    }

    std::string name() const override { return "culling"; }
    nlohmann::ordered_json json() const override
    {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const std::vector<CullingWindow>* windows : {&windows_, &timed_})
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
        w.options.size = wanted.timed ? Size{512, 512}
                                      : settings_.size();   // small images would time little but the start of the pass
        w.options.threads = 1;
        w.options.max_depth = wanted.timed ? 0 : k_paper_depth;
        w.options.counts = w.options.paper = w.options.images = !wanted.timed;
        w.command = fmt::format("gnomon bench culling {} --frames {}-{} --size {}x{}", options::shell_word(w.scene),
                                wanted.frames.first, wanted.frames.last, w.options.size.width, w.options.size.height);
        w.command += wanted.timed ? fmt::format(" --lights {} --method certified --no-counts", k_timed_lights)
                                  : fmt::format(" --max-depth {}", k_paper_depth);
        return w;
    }

    void measure(const Wanted& wanted, const Progress& progress)
    {
        if (loaded_name_ != wanted.scene) {
            loaded_ = std::make_unique<Scene>(load(wanted.scene));
            loaded_name_ = wanted.scene;
        }
        const Scene scene = wanted.timed ? loaded_->with_lights(k_timed_lights) : *loaded_;
        CullingWindow window = window_of(wanted);
        window.lights = api::scene_of(scene)->lights.size();
        window.result = bench_culling(api::scene_of(scene), window.options, progress);
        if (wanted.timed) {
            timed_.push_back(std::move(window));
        } else {
            windows_.push_back(std::move(window));
            brief_.push_back(wanted.brief);
        }
    }

    // The windows with counts. A window that begins with the paper's frames and is longer is also shortened to them.
    std::vector<CullingWindow> summed() const
    {
        std::vector<CullingWindow> all;
        for (const CullingWindow& w : windows_) {
            const PrintedCulling* printed = printed_culling_of(w.scene);
            const bool longer = printed && w.options.frames.first == 1 &&
                                w.result.frames.size() > static_cast<std::size_t>(printed->frames);
            if (longer) all.push_back(beginning_of(w, printed->frames));
            all.push_back(beginning_of(w, static_cast<int>(w.result.frames.size())));
        }
        return all;
    }

    BenchSettings settings_;
    std::string loaded_name_;
    std::unique_ptr<Scene> loaded_;
    std::vector<CullingWindow> windows_, timed_;
    std::vector<char> brief_;   // by window
};

}   // namespace

std::unique_ptr<BenchChapter> culling_chapter(const BenchSettings& settings)
{
    return std::make_unique<CullingChapter>(settings);
}

}   // namespace gnomon::bench
