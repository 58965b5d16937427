// SPDX-License-Identifier: Apache-2.0
#include "bench/lights/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "api/scene_access.h"
#include "bench/lights/soft.h"
#include "bench/lights/squares.h"
#include "bench/report/image_figures.h"
#include "gnomon/renderer.h"

namespace gnomon::bench {

namespace {

constexpr int k_warm_up = 2;   // frames before the overlay, so that it shows what is remembered

std::string percent(double share)
{
    return fmt::format("{:.1f}\u00a0%", 100 * share);   // without a line break
}

std::string frames_of(const FrameRange& frames)
{
    return frames.count() == 1 ? fmt::format("frame {}", frames.first)
                               : fmt::format("frames {} to {}", frames.first, frames.last);
}

ReportTable proofs_table(const LightsBenchResult& result)
{
    ReportTable table;
    table.caption =
        "What is known of each light at the points that it could reach: parts of surfaces that see all of it, none of "
        "it, or some of it past remembered triangles; unproven ones are decided by rays. Wrong: segments that "
        "contradict a proven answer. The error is of the visible share of the irradiance; beside it, that of soft "
        "shadow "
        "textures, with a distance for each receiver and for each occluder on it.";
    table.columns = {"light", "points",    "lit",      "dark", "penumbra", "unproven",
                     "wrong", "first, ms", "then, ms", "RMSE", "at most",  "RMSE of soft textures"};
    for (const LightsBenchResult::Row& r : result.rows)
        table.rows.push_back(
            {{r.light, fmt::format("{}", r.points), percent(r.lit), percent(r.dark), percent(r.penumbra),
              percent(r.unproven), fmt::format("{} of {}", r.wrong, r.segments), fmt::format("{:.0f}", r.ms_cold),
              fmt::format("{:.0f}", r.ms_steady), fmt::format("{:.5f}", r.error.rmse),
              fmt::format("{:.4f}", r.error.max_abs), fmt::format("{:.3f}", fmt::join(r.soft_rmse, ", "))},
             false});
    return table;
}

ReportTable rays_table(const LightsBenchResult& result)
{
    double cold = 0, steady = 0, squares = 0, most = 0;
    for (const LightsBenchResult::Row& r : result.rows) {
        cold += r.ms_cold, steady += r.ms_steady;
        squares += r.error.rmse * r.error.rmse, most = std::max(most, r.error.max_abs);
    }
    const auto lights = static_cast<double>(std::max<std::size_t>(result.rows.size(), 1));
    ReportTable table;
    table.caption = fmt::format(
        "Time for one light and all points of a frame, mean over lights and frames, beside shadow rays in Embree's "
        "widest native packets. One thread, process CPU time. The truth's own error is {:.5f}.",
        result.truth_rmse);
    table.columns = {"method", "ms", "times the proven answers", "RMSE", "largest error"};
    const auto row = [&](const std::string& name, double ms, double rmse, double largest) {
        table.rows.push_back({{name, fmt::format("{:.1f}", ms), fmt::format("{:.2f}", ms / (steady / lights)),
                               fmt::format("{:.5f}", rmse), fmt::format("{:.4f}", largest)},
                              false});
    };
    row("proven, first frame", cold / lights, std::sqrt(squares / lights), most);
    row("proven, then", steady / lights, std::sqrt(squares / lights), most);
    for (const LightsBenchResult::Opponent& o : result.opponents)
        row(fmt::format("{} rays a point", o.samples), o.ms, o.error.rmse, o.error.max_abs);
    return table;
}

ReportTable soft_table(const LightsBenchResult& result)
{
    ReportTable table;
    table.caption = fmt::format(
        "Soft shadow textures, kept over time: each receiver's shadow, seen from the light's middle in five views of "
        "{0} x {0} texels, convolved with the light's image [Soler and Sillion 1998]. The image is scaled by mean "
        "distances: of all occluders of a receiver, or of each. Leaks: points that see nothing of the light, and more "
        "than a tenth of it here. Textures of all lights; times are of the reference on the CPU, views included.",
        SoftTextures::k_view_size);
    table.columns = {"scale",    "RMSE",       "largest error", "dark points", "leaks among them",
                     "textures", "made again", "first, ms",     "then, ms"};
    for (const LightsBenchResult::Soft& s : result.soft)
        table.rows.push_back(
            {{s.name, fmt::format("{:.4f}", s.error.rmse), fmt::format("{:.3f}", s.error.max_abs),
              fmt::format("{}", s.darkest), fmt::format("{}", s.leaks), fmt::format("{}", s.textures),
              fmt::format("{:.1f}", s.updated), fmt::format("{:.0f}", s.ms_first), fmt::format("{:.0f}", s.ms_then)},
             false});
    return table;
}

Chart times_chart(const LightsBenchResult& result)
{
    Chart chart{"Error against time", "ms for a light", "RMSE of the visible share", {}, {}, {}, {}, {}};
    chart.logarithmic = true;
    ChartSeries rays{"rays to places of the light", {}, k_color_off, ChartSeries::Style::line},
        proven{"proven, a light each", {}, k_color_ours, ChartSeries::Style::points};
    for (const LightsBenchResult::Opponent& o : result.opponents) rays.points.emplace_back(o.ms, o.error.rmse);
    for (const LightsBenchResult::Row& r : result.rows) proven.points.emplace_back(r.ms_steady, r.error.rmse);
    std::sort(rays.points.begin(), rays.points.end());
    std::sort(proven.points.begin(), proven.points.end());
    chart.series = {rays, proven};
    return chart;
}

ReportTable raster_table(const RasterLightsResult& raster)
{
    ReportTable table;
    table.caption = fmt::format(
        "The visible fraction of all lights in the rasterised frame against the traced one, {:.0f} pixels. Leaks: "
        "pixels that are dark in the traced frame and see more than a tenth of the light. Times are {} of whole frames "
        "with all layers on {}.",
        raster.pixels, raster.clock, raster.device);
    table.columns = {"method",           "RMSE",
                     "largest error",    "dark pixels",
                     "leaks among them", "first frame, ms",
                     "another view, ms", "nothing changed, ms"};
    for (const RasterLightsRow& r : raster.rows)
        table.rows.push_back(
            {{r.method, fmt::format("{:.4f}", r.rmse), fmt::format("{:.3f}", r.max_abs),
              fmt::format("{:.0f}", r.darkest), fmt::format("{:.0f}", r.leaks), fmt::format("{:.0f}", r.ms_first),
              fmt::format("{:.0f}", r.ms_view), fmt::format("{:.0f}", r.ms_still)},
             false});
    return table;
}

// Linear pixels as an image, exposed alike.
Image8 shown(const ImageF& color, double exposure)
{
    Frame frame;
    frame.size = {color.width, color.height};
    frame.exposure = exposure;
    Layer layer;
    layer.channels = {"R", "G", "B"};
    layer.size = frame.size;
    layer.data = color.data.data();
    layer.pixel_stride = 3 * sizeof(float);
    layer.row_stride = layer.pixel_stride * color.width;
    frame.layers.push_back(layer);
    return image_of(frame);
}

}   // namespace

LightsImages lights_images(const std::shared_ptr<const scene::Scene>& scene, const LightsBenchOptions& options,
                           const Progress& progress)
{
    const int frame = options.frames.first;
    const scene::SceneState state(scene, scene->timeline.time_of(frame));
    const std::shared_ptr<const scene::Scene> squares = with_squares(state, options.side);
    const Scene shown = api::public_scene(squares);
    LightsImages images;
    RenderOptions render;
    render.size = options.size;
    render.camera = fmt::format("{}", options.camera);
    render.max_depth = 0;
    render.indirect = Indirect::off;
    images.traced = image_of(Renderer(render).render(shown, frame, progress));
    render.overlay = Overlay::shadow_states;
    Renderer overlay(render);
    for (int i = 0; i < k_warm_up; ++i) overlay.render(shown, frame, progress);
    images.states = image_of(overlay.render(shown, frame, progress));
    if (progress) progress({"drawing", 0.5});
    images.raster = compare_raster_lights(squares, frame, options.size, options.camera);
    return images;
}

void add_lights_section(ReportPage& page, const std::string& command, const LightsBenchOptions& options,
                        const LightsBenchResult& result, const LightsImages& images,
                        const nlohmann::ordered_json& document)
{
    page.section("Lights with size", command);
    page.text(fmt::format(
        "Point and spot lights are squares with sides of {} m; emissive polygons are what they are. The points are the "
        "primary hits of {}, {} x {} pixels. {:.1f} MB are remembered.",
        options.side, frames_of(options.frames), options.size.width, options.size.height,
        static_cast<double>(result.bytes) / 1e6));
    page.table(proofs_table(result));
    page.table(rays_table(result));
    page.table(soft_table(result));
    page.chart(times_chart(result), "Time of a steady frame against the error, for one light.");
    page.gallery({{"the traced frame", images.traced}}, "Direct light of all lights together.");
    page.gallery({{"states of the shadows", images.states}},
                 "What is remembered of each light, at the first hits: --overlay shadow-states.");
    if (images.raster.device.empty()) {
        page.text("The rasterised frame was not measured: there is no Vulkan device.");
    } else {
        page.table(raster_table(images.raster));
        Tasks tasks(1);
        double mean = 0;
        for (const float v : images.raster.traced.data)
            mean += static_cast<double>(v) / static_cast<double>(images.raster.traced.data.size());
        constexpr double k_grey = 0.2;   // of the mean, as shown
        const double exposure = mean > 0 ? std::log2(k_grey / mean) : 0;
        const Image8 traced = shown(images.raster.traced, exposure);
        for (const RasterLightsRow& r : images.raster.rows)
            page.comparison(compare_images(fmt::format("Direct light of the lights with size: {}.", r.method), "traced",
                                           traced, "rasterised", shown(r.direct, exposure), tasks));
    }
    page.attach("lights.json", document);
}

nlohmann::ordered_json lights_json(const LightsBenchResult& result, const LightsImages* images)
{
    nlohmann::ordered_json rows = nlohmann::ordered_json::array(), opponents = rows;
    for (const LightsBenchResult::Row& r : result.rows)
        rows.push_back({{"light", r.light},
                        {"points", r.points},
                        {"lit", r.lit},
                        {"dark", r.dark},
                        {"penumbra", r.penumbra},
                        {"unproven", r.unproven},
                        {"segments", r.segments},
                        {"wrong", r.wrong},
                        {"ms_cold", r.ms_cold},
                        {"ms_steady", r.ms_steady},
                        {"rmse", r.error.rmse},
                        {"max_abs", r.error.max_abs},
                        {"soft_rmse", r.soft_rmse},
                        {"listed_triangles", r.triangles}});
    for (const LightsBenchResult::Opponent& o : result.opponents)
        opponents.push_back(
            {{"samples", o.samples}, {"ms", o.ms}, {"rmse", o.error.rmse}, {"max_abs", o.error.max_abs}});
    nlohmann::ordered_json soft = nlohmann::ordered_json::array();
    for (const LightsBenchResult::Soft& s : result.soft)
        soft.push_back({{"scale", s.name},
                        {"rmse", s.error.rmse},
                        {"max_abs", s.error.max_abs},
                        {"dark", s.darkest},
                        {"leaks", s.leaks},
                        {"textures", s.textures},
                        {"updated", s.updated},
                        {"ms_first", s.ms_first},
                        {"ms_then", s.ms_then}});
    nlohmann::ordered_json document{{"rows", rows},
                                    {"opponents", opponents},
                                    {"soft_textures", soft},
                                    {"truth_rmse", result.truth_rmse},
                                    {"bytes", result.bytes}};
    if (!images || images->raster.device.empty()) return document;
    nlohmann::ordered_json raster = nlohmann::ordered_json::array();
    for (const RasterLightsRow& r : images->raster.rows)
        raster.push_back({{"method", r.method},
                          {"rmse", r.rmse},
                          {"max_abs", r.max_abs},
                          {"dark", r.darkest},
                          {"leaks", r.leaks},
                          {"ms_first", r.ms_first},
                          {"ms_view", r.ms_view},
                          {"ms_still", r.ms_still}});
    document["raster"] = {{"device", images->raster.device}, {"pixels", images->raster.pixels}, {"rows", raster}};
    return document;
}

}   // namespace gnomon::bench
