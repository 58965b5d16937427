// SPDX-License-Identifier: Apache-2.0
// gnomon render, on the public API alone.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/machine.h"
#include "base/one_line.h"
#include "cli/progress_line.h"
#include "cli/subcommands.h"
#include "gnomon/gnomon.h"
#include "options/render_options.h"

namespace gnomon::cli {

namespace {
nlohmann::ordered_json stages_json(const FrameTimes& times)
{
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
        json[FrameTimes::k_names[stage]] = times.ms[stage];
    return json;
}

using Json = nlohmann::ordered_json;

// Throws at options that only the other renderer has, because ignoring them silently would mislead.
void refuse_options_of_other_renderer(const options::OptionValues& values)
{
    const auto refuse = [&](std::initializer_list<const char*> names, const char* renderer) {
        for (const char* name : names)
            if (values.given(name)) throw UsageError(fmt::format("--{} needs --renderer {}", name, renderer));
    };
    if (values.text("renderer") == "raster") {
        refuse({"shadow-culling", "accelerator", "max-depth", "reference"}, "trace");
    } else {
        refuse({"shadow-textures", "shadow-filter"}, "raster");
    }
}

// Of the output, in lower case.
std::string extension_of(const options::OptionValues& values)
{
    std::string extension = std::filesystem::path(values.text("out")).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

RenderOptions render_options(const options::OptionValues& values)
{
    refuse_options_of_other_renderer(values);
    RenderOptions options = options::read_render_options(values);
    options.as_printed = values.flag("as-printed");
    if (options.as_printed && options.renderer == RenderMethod::trace && options.shadow_culling != ShadowCulling::paper)
        throw UsageError("--as-printed needs --shadow-culling paper or --renderer raster");
    if (values.flag("reference"))
        options.reference = ReferenceLightOptions{values.integer("spp"), values.integer("bounces"),
                                                  static_cast<std::uint64_t>(values.integer("seed"))};
    if (values.given("indirect") && values.flag("reference"))
        throw UsageError("--reference and --indirect exclude each other");
    if (values.given("bounces") && !values.flag("reference") && options.indirect != Indirect::visible &&
        values.integer("bounces") > 0)
        throw UsageError("--bounces needs --indirect visible or --reference");
    for (const char* name : {"spp", "seed"})
        if (values.given(name) && !values.flag("reference"))
            throw UsageError(fmt::format("--{} needs --reference", name));
    const std::string extension = extension_of(values);
    options.layers = extension == ".exr";
    options.ids = values.flag("ids");
    options.motion = values.flag("motion");
    for (const char* name : {"ids", "motion"})
        if (values.flag(name) && !options.layers) throw UsageError(fmt::format("--{} needs .exr output", name));
    for (const char* name : {"exr-type", "exr-compression"})
        if (values.given(name) && !options.layers) throw UsageError(fmt::format("--{} needs .exr output", name));
    const bool jpeg = extension == ".jpg" || extension == ".jpeg";
    const bool image = jpeg || options.layers || extension == ".png";
    for (const char* name : {"codec", "audio", "timecode"})
        if (values.given(name) && image)
            throw UsageError(fmt::format("--{} needs the output of a video: .mp4, .mov, .mkv, .webm or .gif", name));
    if (values.given("quality") && image && !jpeg)
        throw UsageError("--quality needs the output of a video or of a .jpg");
    return options;
}

VideoJob video_job(const options::OptionValues& values, const Scene& scene)
{
    VideoJob job;
    if (!values.given("out"))
        throw UsageError("render needs -o OUT, the output file: .png, .jpg, .exr, .mp4, or name-{frame:04}.png");
    job.out = values.text("out");
    if (values.given("frame") && values.given("frames")) throw UsageError("--frame and --frames exclude each other");
    if (values.given("frame")) job.frames = FrameRange{values.integer("frame"), values.integer("frame")};
    if (values.given("frames")) job.frames = options::parse_range(values.text("frames"));
    job.fps = scene.fps();
    if (values.given("chunk")) {
        const options::Chunk chunk = *options::parse_chunk(values.text("chunk"));
        job.chunk = chunk.number, job.chunks = chunk.of;
        job.part = chunk.frames;
    }
    job.resume = values.flag("resume");
    if (values.given("warm-up")) job.warm_up = values.integer("warm-up");
    job.contact_sheet = values.text("contact-sheet");
    job.exposure_of_each_frame = values.text("exposure") == "auto-frame";
    job.encoding.codec = values.choice<VideoCodec>("codec");
    if (values.given("quality")) job.encoding.quality = job.images.quality = values.integer("quality");
    job.encoding.audio = values.text("audio");
    job.encoding.timecode = values.text("timecode");
    job.images.exr_type = values.choice<ExrType>("exr-type");
    job.images.exr_compression = values.choice<ExrCompression>("exr-compression");
    return job;
}

// Adds where each stage of a rasterised frame's indirect light runs. In a traced frame all of them run on the CPU.
void add_locations(const FrameCounters::Indirect& counters, const RenderOptions& options, Json& json)
{
    if (options.renderer != RenderMethod::raster || options.indirect == Indirect::off) return;
    const char* const gather = counters.gathered_by_vulkan ? "vulkan" : "cpu";
    if (options.indirect == Indirect::visible)
        json.update({{"cut", gather},
                     {"visibility", counters.traced_by_vulkan ? "vulkan" : "cpu"},
                     {"gather", gather},
                     {"shading", "vulkan"}});
    else
        json.update({{"light_map", "vulkan"}, {"tree", "vulkan"}, {"gather", "vulkan"}, {"shading", "vulkan"}});
}

Json indirect_of(const FrameRecord& record, const RenderOptions& options)
{
    const FrameCounters::Indirect& counters = record.counters.indirect;
    Json json = {{"clusters", counters.clusters}, {"rays", counters.rays}};
    if (options.reference) json["noise"] = record.noise;
    add_locations(counters, options, json);
    return json;
}

// A frame that an earlier run wrote has no times or counters.
Json kept_frame_of(const FrameRecord& record)
{
    return {{"frame", record.frame},
            {"time", record.time},
            {"file", record.file.string()},
            {"kept", true},
            {"ms", 0},
            {"shadow", {{"rays", nullptr}, {"rays_skipped", nullptr}, {"rays_dynamic_only", nullptr}}},
            {"indirect", {{"clusters", nullptr}, {"rays", nullptr}}},
            {"draws", nullptr}};
}

Json frame_of(const FrameRecord& record, const RenderOptions& options)
{
    const FrameCounters& counters = record.counters;
    Json shadow{{"rays", counters.shadow.rays},
                {"rays_skipped", counters.shadow.rays_skipped},
                {"rays_dynamic_only", counters.shadow.rays_dynamic_only}};
    if (counters.shadow.rays_wrong) shadow["rays_wrong"] = *counters.shadow.rays_wrong;
    if (options.renderer == RenderMethod::raster) {
        shadow["textures"] = counters.shadow.textures;
        shadow["textures_waiting"] = counters.shadow.textures_waiting;
    }
    if (counters.shadow.looked_up) {
        shadow["looked_up"] = *counters.shadow.looked_up;
        shadow["looked_up_wrong"] = *counters.shadow.looked_up_wrong;
    }
    Json frame{{"frame", record.frame},        {"time", record.time},
               {"file", record.file.string()}, {"ms", record.milliseconds},
               {"exposure", record.exposure},  {"stages", stages_json(record.times)},
               {"shadow", std::move(shadow)},  {"indirect", indirect_of(record, options)},
               {"draws", counters.draws}};
    if (options.samples == k_adaptive_samples)
        frame["samples"] = {{"pixels", counters.samples.pixels},
                            {"taken", counters.samples.taken},
                            {"shaded", counters.samples.shaded}};
    if (counters.kdtree) {
        const auto work = [](const FrameCounters::KdTree::Work& of) {
            return Json{{"nodes", of.nodes}, {"tests", of.tests}};
        };
        frame["kdtree"] = {{"primary", work(counters.kdtree->primary)},
                           {"reflection", work(counters.kdtree->reflection)},
                           {"refraction", work(counters.kdtree->refraction)},
                           {"shadow", work(counters.kdtree->shadow)},
                           {"indirect", work(counters.kdtree->indirect)}};
    }
    return frame;
}

// The Vulkan renderer opens no device if there is no frame to render.
Json device_of(const std::string& device, const RenderOptions& options)
{
    if (options.renderer == RenderMethod::trace) return gnomon::processor_name();
    return device.empty() ? Json(nullptr) : Json(device);
}

Json document_of(const CommandLine& line, const VideoResult& result, const RenderOptions& options,
                 const std::string& device)
{
    const bool reference = line.values.flag("reference");
    Json frames = Json::array();
    for (const FrameRecord& record : result.frames)
        frames.push_back(record.kept ? kept_frame_of(record) : frame_of(record, options));
    Json document = {{"version", std::string(version())},
                     {"scene", line.positionals[0]},
                     {"renderer", line.values.text("renderer")},
                     {"device", device_of(device, options)},
                     {"isa", line.values.text("isa")},
                     {"instruction_set", std::string(instruction_set_name())},
                     {"width", result.size.width},
                     {"height", result.size.height}};
    if (reference) {
        const int bounces = line.values.integer("bounces");
        document["reference"] = {{"spp", line.values.integer("spp")},
                                 {"bounces", bounces == k_all_bounces ? Json("all") : Json(bounces)},
                                 {"seed", line.values.integer("seed")}};
    }
    document["frames"] = std::move(frames);
    document["peak_memory_bytes"] = peak_memory_bytes();
    return document;
}

std::string summary_of(const VideoResult& result, double seconds)
{
    const std::size_t count = result.frames.size();
    std::string frames = fmt::format("{} frame{}, {}x{}, {}", count, count == 1 ? "" : "s", result.size.width,
                                     result.size.height, duration_text(seconds));
    if (result.files.empty()) return fmt::format("nothing to do ({})", frames);
    if (result.complete_before)
        return fmt::format("{} is complete; nothing to do ({})", one_line(result.files.front().string()), frames);
    // State the noise of the noisiest frame.
    double noise = 0;
    for (const FrameRecord& record : result.frames) noise = std::max(noise, record.noise);
    if (noise > 0) frames += fmt::format(", noise {:.2f} %", 100 * noise);
    const std::string first = one_line(result.files.front().string()), last = one_line(result.files.back().string());
    return result.files.size() == 1 ? fmt::format("{} ({})", first, frames)
                                    : fmt::format("{} ... {} ({})", first, last, frames);
}

// Warns that results of the published method are unproven and depend on the first frame rendered.
void warn_about_history(const options::OptionValues& values, Output& output)
{
    const bool parts = values.given("chunk") || values.given("resume");
    if (values.text("shadow-culling") != "paper") {
        const std::string overlay = values.text("overlay");
        if (parts && (overlay == "shadow-states" || overlay == "redrawn"))
            output.warn(
                fmt::format("--overlay {} shows the state left by earlier frames: with --chunk or --resume, images can "
                            "differ from those of one run over all frames",
                            overlay));
        return;
    }
    if (!values.given("overlay"))
        output.warn("--shadow-culling paper is approximate: shadows can be wrong; --overlay shadow-states shows where");
    if (parts)
        output.warn(
            "--shadow-culling paper depends on earlier frames: with --chunk or --resume, images can differ from those "
            "of one run over all frames; --warm-up N first renders the N frames before without writing them");
}

std::string wrong_text(const VideoResult& result)
{
    std::uint64_t wrong = 0, tested = 0;
    for (const FrameRecord& record : result.frames) {
        wrong += record.counters.shadow.rays_wrong.value_or(0);
        if (record.counters.shadow.rays_wrong) tested += record.counters.shadow.rays;
    }
    return fmt::format("{} of {} shadow results differ from tracing every ray", wrong, tested);
}

// States what the colours of shadow textures decide wrongly.
std::string printed_textures_text(const VideoResult& result)
{
    std::uint64_t wrong = 0, all = 0;
    for (const FrameRecord& record : result.frames) {
        wrong += record.counters.shadow.looked_up_wrong.value_or(0);
        all += record.counters.shadow.looked_up.value_or(0);
    }
    return fmt::format("{} of {} shadow results ({:.2f} %) differ from comparing distances", wrong, all,
                       all > 0 ? 100 * static_cast<double>(wrong) / static_cast<double>(all) : 0.0);
}
}   // namespace

int run_render(const CommandLine& line, Output& output)
{
    const auto start = std::chrono::steady_clock::now();
    const options::OptionValues& values = line.values;
    const Progress progress = output.progress();
    Renderer renderer(render_options(values));   // throws on invalid options before the scene is loaded
    Scene scene = load_scene(line, progress);
    if (values.given("turntable")) scene = scene.lasting(values.number("turntable"));

    VideoJob job = video_job(values, scene);
    job.on_notice = [&](const std::string& notice) { output.warn(notice); };
    const VideoResult result = render_video(scene, renderer, job, progress, [&](const FrameRecord& r) {
        if (values.flag("reference") && !r.kept)
            output.detail(fmt::format("frame {}: noise {:.2f} % of the mean", r.frame, 100 * r.noise));
        output.detail(r.kept ? fmt::format("frame {}: kept from an earlier run", r.frame)
                             : fmt::format("frame {}: {:.1f} ms, {} shadow rays, {} reflected, {} refracted", r.frame,
                                           r.milliseconds, r.counters.shadow.rays, r.counters.reflection_rays,
                                           r.counters.refraction_rays));
    });
    output.detail(fmt::format("instruction set: {}; rays are traced by {}", instruction_set_name(),
                              renderer.options().arithmetic == Arithmetic::portable
                                  ? "code with the same results on every processor (--isa auto)"
                                  : "Embree's code for it (--isa native)"));
    for (const std::string& warning : scene.info().warnings) output.warn(warning);
    warn_about_history(values, output);
    const std::chrono::duration<double> span = std::chrono::steady_clock::now() - start;
    if (renderer.options().overlay == Overlay::shadow_states) output.say(wrong_text(result));
    if (renderer.options().as_printed && renderer.options().renderer == RenderMethod::raster)
        output.say(printed_textures_text(result));
    output.say(summary_of(result, span.count()));
    output.finish(document_of(line, result, renderer.options(), renderer.device()));
    return 0;
}

Scene load_scene(const CommandLine& line, const Progress& progress)
{
    const options::OptionValues& values = line.values;
    const auto has = [&](const char* name) {
        return options::find_option(line.subcommand->subcommand, name) && values.given(name);
    };
    Scene scene = load(
        line.positionals.at(0),
        {.progress = progress,
         .threads = values.integer("threads"),
         .strict = has("strict"),
         .animation = has("animation") ? values.text("animation") : "",
         .ground = has("ground") ? options::read_ground(values) : std::nullopt,
         .variant = has("variant") ? values.text("variant") : "",
         .memory = has("memory") && values.integer("memory") > 0 ? values.integer("memory") : LoadOptions{}.memory});
    if (has("fps")) scene = scene.at_rate(values.number("fps"));
    if (has("light")) scene = scene.with_light_specs(values.all("light"));
    if (has("lights")) scene = scene.with_lights(values.integer("lights"));
    if (has("environment")) scene = scene.with_environment(values.text("environment"));
    return scene;
}

}   // namespace gnomon::cli
