// SPDX-License-Identifier: Apache-2.0
// The chapter on the whole frame: measures its time by stage with every shadow ray traced and with certified culling,
// with and without indirect light; how much work caching saves; and how the images differ.
#include <fmt/format.h>
#include <algorithm>

#include <nlohmann/json.hpp>

#include "bench/report/chapter.h"
#include "bench/report/image_figures.h"
#include "bench/report/stage_figures.h"
#include "gnomon/renderer.h"
#include "options/enum_names.h"
#include "options/option_values.h"

namespace gnomon::bench {

namespace {

constexpr FrameRange k_kitchen_frames{121, 140};   // the car moves
constexpr FrameRange k_stand_in_frames{1, 20};
constexpr int k_quick_frames = 6;

// A way to render: the options and what each frame took.
struct Way {
    std::string name;
    ShadowCulling culling;
    Indirect indirect;
    int threads;
    std::string color;
    std::vector<FrameWork> frames{};

    std::string full_name() const { return fmt::format("{}, {} thread{}", name, threads, threads == 1 ? "" : "s"); }
    WayWork work() const { return {full_name(), frames}; }
};

// The median time from the second frame on, when caches are filled.
double steady_ms(const Way& way)
{
    return steady_median(way.work(), [](const FrameWork& frame) { return frame.ms; });
}

class FrameChapter : public BenchChapter {
 public:
    explicit FrameChapter(const BenchSettings& settings) : settings_(settings)
    {
        const bool kitchen = !settings.scenes.kitchen.empty();
        scene_name_ = kitchen ? settings.scenes.kitchen : settings.scenes.stand_in;
        frames_ = kitchen ? k_kitchen_frames : k_stand_in_frames;
        if (settings.quick) frames_.last = frames_.first + k_quick_frames - 1;
        const int all = settings.threads;
        for (const int threads : {1, all}) {
            if (all == 1 && !ways_.empty()) break;
            ways_.push_back({"every shadow ray", ShadowCulling::off, Indirect::off, threads, k_color_off});
            ways_.push_back({"certified shadows", ShadowCulling::certified, Indirect::off, threads, k_color_ours});
        }
        ways_.push_back(
            {"certified shadows, indirect light", ShadowCulling::certified, Indirect::visible, all, k_color_fourth});
    }

    std::vector<BenchPart> parts() override
    {
        const double weight = 0.3 * frames_.count() * static_cast<double>(ways_.size()) / (settings_.quick ? 4 : 1);
        return {{fmt::format("whole frames: {}, frames {} to {}", scene_name_, frames_.first, frames_.last), weight,
                 [this](const Progress& progress) { measure(progress); }}};
    }

    std::vector<ReportTable::Row> lead() const override
    {
        if (!measured_) return {};
        return {{{"Whole frame, one thread: speed-up by certified shadow culling", "not in the paper", "",
                  fmt::format("{:.2f} x", steady_ms(ways_[0]) / steady_ms(ways_[1]))},
                 false}};
    }

    void write(ReportPage& page) const override
    {
        if (!measured_) return;
        // State the conditions and the times of all configurations.
        page.section("Whole frames", command());
        page.text(
            fmt::format("{}, frames {} to {}, {} x {} pixels, reflections to depth 10. The configurations take turns, "
                        "frame by frame. Times are medians from the second frame on, when the caches are filled.",
                        scene_name_, frames_.first, frames_.last, settings_.size().width, settings_.size().height));
        ReportTable table;
        table.caption =
            "Wall-clock time of whole frames, and the work saved: the percentage of shadow rays that were culled, of "
            "those that were traced against dynamic objects only, and of rays for indirect light saved in comparison "
            "with the first frame, which starts with empty caches.";
        table.columns = {"",
                         "threads",
                         "ms per frame",
                         "shadow rays culled, %",
                         "traced against dynamic objects only, %",
                         "indirect rays saved, %"};
        for (const Way& way : ways_) {
            const SavedWork saved = saved_of(way.work());
            table.rows.push_back(
                {{way.name, fmt::format("{}", way.threads), fmt::format("{:.1f}", steady_ms(way)),
                  fmt::format("{:.1f}", saved.shadow_skipped), fmt::format("{:.1f}", saved.shadow_dynamic_only),
                  way.indirect == Indirect::off ? "" : fmt::format("{:.1f}", saved.indirect)},
                 false});
        }
        page.table(table);

        // Chart the times frame by frame, then stages and images.
        Chart chart{"Time of whole frames", "frame", "ms", {}, {}, {}, {}, {}};
        for (const Way& way : ways_) {
            ChartSeries series{way.full_name(),
                               {},
                               way.color,
                               way.threads == 1 ? ChartSeries::Style::line : ChartSeries::Style::dashed};
            for (std::size_t i = 0; i < way.frames.size(); ++i)
                series.points.emplace_back(frames_.first + static_cast<double>(i), way.frames[i].ms);
            chart.series.push_back(std::move(series));
        }
        page.chart(chart, "Time of whole frames, frame by frame.");
        write_stages(page);
        for (const ImageComparison& figure : figures_) page.comparison(figure);
        page.attach("frames.json", json());
    }

    std::string name() const override { return "frames"; }
    nlohmann::ordered_json json() const override
    {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const Way& way : ways_)
            list.push_back({{"scene", scene_name_},
                            {"shadow_culling", options::name_of(way.culling)},
                            {"indirect", options::name_of(way.indirect)},
                            {"threads", way.threads},
                            {"first_frame", frames_.first},
                            {"not_done_percent",
                             {{"shadow_rays_skipped", saved_of(way.work()).shadow_skipped},
                              {"shadow_rays_dynamic_only", saved_of(way.work()).shadow_dynamic_only},
                              {"indirect_rays", saved_of(way.work()).indirect}}},
                            {"frames", work_json(way.frames, frames_.first)}});
        return list;
    }

 private:
    // Writes times by stage, and the work saved in the last configuration, which includes indirect light.
    void write_stages(ReportPage& page) const
    {
        std::vector<WayWork> ways;
        for (const Way& way : ways_) ways.push_back(way.work());
        page.table(stage_table(ways));
        page.chart(stage_chart(ways.back(), frames_.first),
                   "Time by stage from the second frame on. The stages have the names of the JSON of render.");
        page.chart(saved_chart(ways.back(), frames_.first),
                   "Percentage of the work saved by caching, from the second frame on.");
    }

    std::string command() const
    {
        return fmt::format(
            "gnomon render {} -o 'out/{{frame:04}}.png' --frames {}-{} --size {}x{} --shadow-culling "
            "off|certified --indirect off|visible --threads N --json",
            options::shell_word(scene_name_), frames_.first, frames_.last, settings_.size().width,
            settings_.size().height);
    }

    void measure(const Progress& progress)
    {
        // Create one renderer per configuration.
        const Scene scene = load(scene_name_);
        if (scene.frame_count() < frames_.last) frames_ = {1, scene.frame_count()};
        std::vector<Renderer> renderers;
        for (const Way& way : ways_)
            renderers.emplace_back(RenderOptions{.size = settings_.size(),
                                                 .exposure = exposure_,
                                                 .shadow_culling = way.culling,
                                                 .indirect = way.indirect,
                                                 .threads = way.threads});

        // Render every frame with all of them in turn; keep the images of the last frame.
        for (int frame = frames_.first; frame <= frames_.last; ++frame) {
            for (std::size_t i = 0; i < ways_.size(); ++i) {
                const double done =
                    (frame - frames_.first + static_cast<double>(i) / static_cast<double>(ways_.size())) /
                    frames_.count();
                if (progress && !progress({"measuring", done})) throw InterruptedError("interrupted");
                Frame image = renderers[i].render(scene, frame);
                ways_[i].frames.push_back(work_of(image));
                if (frame == frames_.last) last_.push_back(std::move(image));
            }
        }
        make_figures();
        measured_ = true;
    }

    // Compares the images of the last frame, all with the darkest of their exposures: without indirect light, scenes
    // may have ambient light instead.
    void make_figures()
    {
        double exposure = last_.front().exposure;
        for (const Frame& image : last_) exposure = std::min(exposure, image.exposure);
        std::vector<Image8> images;
        for (Frame& image : last_) {
            image.exposure = exposure;
            images.push_back(image_of(image));
        }
        Tasks tasks(settings_.threads);
        const std::string frame = fmt::format("Frame {}", frames_.last);
        figures_.push_back(compare_images(
            frame + " with every shadow ray traced, and with shadows cached since the first of these frames.",
            ways_[0].name, images[0], ways_[1].name, images[1], tasks));
        figures_.push_back(compare_images(frame + " without and with indirect light.", "direct light", images[1],
                                          "direct and indirect light", images.back(), tasks));
        last_.clear();
    }

    BenchSettings settings_;
    std::string scene_name_;
    FrameRange frames_;
    std::optional<double> exposure_;
    std::vector<Way> ways_;
    std::vector<Frame> last_;
    std::vector<ImageComparison> figures_;
    bool measured_ = false;
};

}   // namespace

std::unique_ptr<BenchChapter> frame_chapter(const BenchSettings& settings)
{
    return std::make_unique<FrameChapter>(settings);
}

}   // namespace gnomon::bench
