// SPDX-License-Identifier: Apache-2.0
#include "options/option_table.h"

#include "options/enum_names.h"

namespace gnomon::options {

namespace {
using enum Subcommand;

constexpr std::uint32_t k_every = ~0u;
constexpr std::uint32_t k_images = bit(render) | bit(view);
constexpr std::uint32_t k_benches =
    bit(bench_trace) | bit(bench_culling) | bit(bench_shadow_textures) | bit(bench_indirect);
constexpr std::uint32_t k_reports = bit(bench_culling) | bit(bench_shadow_textures) | bit(bench_indirect);
constexpr std::uint32_t k_scened =
    k_images | (k_benches & ~bit(bench_shadow_textures));   // that one makes its own scene

constexpr SubcommandInfo k_subcommands[] = {
    {render, "render", "SCENE -o OUT", 1, "render an image, numbered images, or a video", true},
    {view, "view", "SCENE", 1, "look at a scene in a window", true},
    {info, "info", "SCENE", 1, "say what a scene holds", true},
    {compare, "compare", "A B", 2, "compare two images, the second being the reference", true},
    {devices, "devices", "", 0, "list processor and Vulkan devices, and what they can do", true},
    {bench_trace, "bench trace", "SCENE", 1, "measure the traced frame against its bare rays", true},
    {bench_culling, "bench culling", "SCENE", 1, "measure what shadow culling saves", true},
    {bench_shadow_textures, "bench shadow-textures", "", 0, "measure shadow textures on Vulkan", true},
    {bench_indirect, "bench indirect", "SCENE", 1, "measure indirect light against a path-traced reference", true},
    {bench_all, "bench all", "--report DIR", 0, "measure everything the papers print, as one page", true},
};

constexpr std::string_view k_output = "Output";
constexpr std::string_view k_frames = "Frames";
constexpr std::string_view k_scene = "Camera and lights";
constexpr std::string_view k_quality = "Rays";
constexpr std::string_view k_look = "Look";
constexpr std::string_view k_shadows = "Shadows";
constexpr std::string_view k_indirect = "Indirect light";
constexpr std::string_view k_reference = "Reference";
constexpr std::string_view k_comparison = "Comparison";
constexpr std::string_view k_common = "Everywhere";

constexpr double k_many = 1e9;

// clang-format off
constexpr Option k_options[] = {
    {.name = "out", .letter = 'o', .argument = "OUT", .kind = Kind::text, .subcommands = bit(render), .group = k_output,
     .help = "what to write: .png, .exr (linear light, all layers), .mp4, or a numbered set: name-{frame:04}.png"},
    {.name = "size", .argument = "WxH", .kind = Kind::size, .range = ranges::image_side, .subcommands = k_images, .group = k_output,
     .help = "in pixels; keeps the vertical field of view (default: the file's own, else 1280x720)"},
    {.name = "size", .argument = "WxH", .kind = Kind::size, .fallback = "512x512", .range = ranges::image_side,
     .subcommands = k_benches, .group = k_output, .help = "in pixels; keeps the vertical field of view"},
    {.name = "report", .argument = "DIR", .kind = Kind::text, .subcommands = k_reports, .group = k_output,
     .help = "also write DIR/index.html: tables and charts beside the paper's, data attached"},
    {.name = "report", .argument = "DIR", .kind = Kind::text, .subcommands = bit(bench_all), .group = k_output,
     .help = "where to write index.html: tables and charts beside the papers', data attached"},
    {.name = "quick", .subcommands = bit(bench_all), .group = k_output,
     .help = "smaller images and fewer frames: minutes instead of a quarter of an hour"},
    {.name = "contact-sheet", .argument = "FILE.png", .kind = Kind::text, .subcommands = bit(render), .group = k_output,
     .help = "also write a labelled grid of up to 12 frames, evenly spaced over the range"},
    {.name = "renderer", .argument = "NAME", .kind = Kind::choice, .fallback = "trace", .choices = k_choices<RenderMethod>,
     .subcommands = k_images | bit(bench_indirect), .group = k_output,
     .help = "CPU ray tracer; or Vulkan, without mirror images and refraction"},

    {.name = "frame", .argument = "N", .kind = Kind::integer, .range = {1, k_many},
     .subcommands = bit(render) | bit(bench_trace), .group = k_frames, .help = "one frame, from 1"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(render),
     .group = k_frames,
     .help = "a range, both ends included (default: the whole clip for a video or a numbered set, 1 for an image)"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(bench_culling),
     .group = k_frames, .help = "a range, both ends included (default: the first 100)"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(bench_indirect),
     .group = k_frames, .help = "a range, both ends included (default: the first 10)"},
    {.name = "frames", .argument = "F", .kind = Kind::integer, .fallback = "7", .range = {1, 200},
     .subcommands = bit(bench_shadow_textures), .group = k_frames, .help = "to measure after the first two; times are medians"},
    {.name = "fps", .argument = "F", .kind = Kind::number, .range = {0.001, 1000},
     .subcommands = k_images | bit(info), .group = k_frames,
     .help = "frames a second (default: the file's own frames, else 24)"},
    {.name = "chunk", .argument = "I/N", .kind = Kind::chunk, .subcommands = bit(render), .group = k_frames,
     .help = "only the I-th of N contiguous parts of the range; of a video, its frames alone"},
    {.name = "resume", .subcommands = bit(render), .group = k_frames,
     .help = "keep frames that are already complete: of a video those of the same scene and options, of numbered images "
             "whatever is whole and of the size"},
    {.name = "warm-up", .argument = "N", .kind = Kind::integer, .range = {0, k_many}, .subcommands = bit(render),
     .group = k_frames,
     .help = "render the N frames before the first unseen, so that there is something to remember (default: 0; 8 for one "
             "image with --overlay shadow-states)"},
    {.name = "repeat", .argument = "R", .kind = Kind::integer, .fallback = "1", .range = {1, 1000},
     .subcommands = bit(bench_culling), .group = k_frames, .help = "run R times; times are medians, counts must be the same"},
    {.name = "threads", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::threads,
     .subcommands = bit(bench_culling), .group = k_frames, .help = "0: all; counts do not depend on it"},
    {.name = "threads", .argument = "N", .kind = Kind::integer, .fallback = "0", .range = ranges::threads,
     .subcommands = bit(bench_shadow_textures), .group = k_frames,
     .help = "taken as everywhere, and without effect: one thread plans, the device draws"},

    {.name = "objects", .argument = "N...", .kind = Kind::integer, .range = {1, 1e6}, .repeats = true,
     .subcommands = bit(bench_shadow_textures), .group = k_scene, .help = "spheres in the scene (default: 300)"},
    {.name = "dynamic", .argument = "P...", .kind = Kind::number, .range = {0, 100}, .repeats = true,
     .subcommands = bit(bench_shadow_textures), .group = k_scene, .help = "percent of them that move (default: 10)"},
    {.name = "movers", .argument = "M", .kind = Kind::integer, .range = {0, 1e6},
     .subcommands = bit(bench_shadow_textures), .group = k_scene,
     .help = "that many move instead, among small objects that stand still, equally dense around them"},
    {.name = "vertices", .argument = "V", .kind = Kind::integer, .fallback = "2037", .range = {5, 1e6},
     .subcommands = bit(bench_shadow_textures), .group = k_scene, .help = "of a sphere"},
    {.name = "camera", .argument = "NAME|N|auto", .kind = Kind::text, .fallback = "auto", .subcommands = k_scened, .group = k_scene,
     .help = "by name, by number from 0, or the first"},
    {.name = "turntable", .argument = "SECONDS", .kind = Kind::number, .range = ranges::turntable_seconds, .subcommands = k_images,
     .group = k_scene, .help = "the camera circles the scene in that time instead"},
    {.name = "lights", .argument = "N", .kind = Kind::integer, .range = {0, k_many}, .subcommands = k_scened, .group = k_scene,
     .help = "keep the first N lights of the file (default: all)"},
    {.name = "light", .argument = "\"...\"", .kind = Kind::text, .repeats = true, .subcommands = k_scened, .group = k_scene,
     .help = "instead of the file's lights: \"spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B\" or \"point X Y Z R G B\", in "
             "candela; may be given again"},
    {.name = "environment", .argument = "FILE", .kind = Kind::text, .subcommands = k_images, .group = k_scene,
     .help = "light from an image of the surroundings, longitude by latitude: .exr, .hdr, .png, .jpg"},

    {.name = "samples", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::samples,
     .subcommands = k_images, .group = k_quality, .help = "per pixel"},
    {.name = "max-depth", .argument = "N", .kind = Kind::integer, .fallback = "10", .range = ranges::max_depth,
     .subcommands = k_images | bit(bench_trace), .group = k_quality, .help = "reflections and refractions in a row"},
    {.name = "max-depth", .argument = "N", .kind = Kind::integer, .fallback = "0", .range = ranges::max_depth,
     .subcommands = bit(bench_culling), .group = k_quality,
     .help = "reflections and refractions in a row whose hits ask for shadows, too; 0: primary hits alone"},
    {.name = "accelerator", .argument = "NAME", .kind = Kind::choice, .fallback = "embree", .choices = k_choices<Accelerator>,
     .subcommands = k_images, .group = k_quality,
     .help = "what finds a ray's hit; kdtree: counts nodes and triangle tests, slow, the same image up to edges"},

    {.name = "exposure", .argument = "EV|auto", .kind = Kind::number_or_auto, .fallback = "auto", .range = ranges::exposure,
     .subcommands = k_images, .group = k_look, .help = "in stops; auto: from each frame alone"},
    {.name = "tonemap", .argument = "NAME", .kind = Kind::choice, .fallback = "neutral", .choices = k_choices<ToneMap>,
     .subcommands = k_images, .group = k_look, .help = "how light becomes screen colour"},
    {.name = "overlay", .argument = "NAME", .kind = Kind::choice, .choices = k_choices<Overlay>,
     .subcommands = k_images, .group = k_look,
     .help = "colours what was remembered, redrawn, chosen. shadow-states: a panel of --size for each light, with a "
             "legend; what differs from a trace of every ray is counted and glares. redrawn: what the rasteriser's light "
             "views drew in this frame: red moves, green came to rest, yellow was repaired. clusters: a colour for each "
             "one, with --indirect quadtree"},
    {.name = "overlay-light", .argument = "N", .kind = Kind::integer, .range = {0, k_many}, .subcommands = k_images,
     .group = k_look, .help = "show shadow states of this light alone, from 0 (default: of all)"},

    {.name = "method", .argument = "HOW", .kind = Kind::choice, .choices = "paper|certified", .repeats = true,
     .subcommands = bit(bench_culling), .group = k_shadows, .help = "which to measure beside tracing every ray (default: both)"},
    {.name = "as-printed", .subcommands = bit(bench_culling), .group = k_shadows,
     .help = "the published method by the letter of its Tables 1 and 3: neighbours found occluded are tested again, and "
             "shadows of what moves are remembered"},
    {.name = "no-counts", .subcommands = bit(bench_culling), .group = k_shadows,
     .help = "no nodes and triangle tests on the counting kd-tree"},
    {.name = "method", .argument = "HOW", .kind = Kind::choice, .choices = "per-caster|depth|coherent|items", .repeats = true,
     .subcommands = bit(bench_shadow_textures), .group = k_shadows,
     .help = "which to measure: all casters between for every receiver (slow); one depth buffer; that, kept from frame to "
             "frame; the same with one item buffer for all textures (default: depth coherent items)"},
    {.name = "shadow-culling", .argument = "HOW", .kind = Kind::choice, .fallback = "certified", .choices = k_choices<ShadowCulling>,
     .subcommands = k_images, .group = k_shadows,
     .help = "remember traced shadows. certified: proven, the same image as off; paper: guessed as published in 2009, "
             "can be wrong, depends on the frames before"},
    {.name = "shadow-textures", .argument = "HOW", .kind = Kind::choice, .fallback = "coherent",
     .choices = k_choices<ShadowTextures>, .subcommands = k_images, .group = k_shadows,
     .help = "rasterised shadows. coherent: only what changed is drawn again; depth, per-caster: everything is, receiver "
             "by receiver; the same image"},
    {.name = "shadow-filter", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::shadow_filter,
     .subcommands = k_images, .group = k_shadows, .help = "edge of rasterised shadows in texels; 0: hard"},
    {.name = "moving-lights", .subcommands = bit(bench_culling) | bit(bench_indirect), .group = k_shadows,
     .help = "every light runs a small circle, so that nothing can be remembered"},

    {.name = "method", .argument = "HOW...", .kind = Kind::text, .choices = "visible|quadtree|rsm", .repeats = true,
     .subcommands = bit(bench_indirect), .group = k_indirect,
     .help = "what to measure: visible, quadtree:LEVEL, rsm:SAMPLES, rsm:SAMPLES:RADIUS (radius of the disk, in sides of "
             "the map; 0.3); may be given again (default: visible; with --report, every method of the paper)"},
    {.name = "indirect", .argument = "HOW", .kind = Kind::choice, .fallback = "visible", .choices = k_choices<Indirect>,
     .subcommands = k_images, .group = k_indirect,
     .help = "one-bounce light. visible: with shadows, without noise; quadtree: clusters of lit surface parts, as published "
             "in 2007; rsm: samples of them; both without shadows"},
    {.name = "indirect-memory", .argument = "MB", .kind = Kind::integer, .fallback = "16", .range = ranges::indirect_memory,
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect,
     .help = "visible: room for remembered points, never less than twice what a frame shows; the longest unseen are "
             "forgotten first; changes time, not images"},
    {.name = "indirect-on", .argument = "WHERE", .kind = Kind::choice, .fallback = "auto", .choices = k_choices<IndirectOn>,
     .subcommands = k_images, .group = k_indirect,
     .help = "visible with --renderer raster: who cuts the light's tree, traces and sums. vulkan: the device; its rays, if it "
             "has ray-tracing pipelines; auto: the device, unless it is software; the same image up to rounding"},
    {.name = "rsm-samples", .argument = "N", .kind = Kind::integer, .fallback = "256", .range = ranges::rsm_samples,
     .subcommands = k_images, .group = k_indirect, .help = "rsm: of the reflective shadow map"},
    {.name = "indirect-level", .argument = "N", .kind = Kind::integer, .fallback = "5", .range = ranges::indirect_level,
     .subcommands = k_images, .group = k_indirect,
     .help = "quadtree: where the light's tree is cut at the latest. 6: 16 nodes a side; 5: 32; 4: 64"},
    {.name = "depth-threshold", .argument = "X", .kind = Kind::number, .fallback = "0.05", .range = ranges::depth_threshold,
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect,
     .help = "quadtree: how far depths in a cluster differ, as a fraction of the light view's depth range"},
    {.name = "normal-threshold", .argument = "X", .kind = Kind::number, .fallback = "0.9", .range = ranges::normal_threshold,
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect, .help = "quadtree: least cosine between normals in a cluster"},
    {.name = "receivers", .argument = "HOW", .kind = Kind::choice, .fallback = "64", .choices = "64|full",
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect,
     .help = "rsm, quadtree: points that gather, along the longer side; full: every pixel"},

    {.name = "reference", .subcommands = bit(render), .group = k_reference,
     .help = "indirect light by path tracing: slow, true on average, with an estimate of its noise"},
    {.name = "spp", .argument = "N", .kind = Kind::integer, .fallback = "1024", .range = ranges::spp,
     .subcommands = bit(render), .group = k_reference, .help = "its paths per pixel"},
    {.name = "spp", .argument = "N", .kind = Kind::integer, .fallback = "4096", .range = {2, ranges::spp.high},
     .subcommands = bit(bench_indirect), .group = k_reference, .help = "its paths per point"},
    {.name = "judged", .argument = "N", .kind = Kind::integer, .fallback = "4", .range = {1, 1000},
     .subcommands = bit(bench_indirect), .group = k_reference, .help = "frames of the range that have a reference"},
    {.name = "keep-references", .argument = "DIR", .kind = Kind::text, .subcommands = bit(bench_indirect),
     .group = k_reference, .help = "keep references there, and use those that are there"},
    {.name = "bounces", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::bounces,
     .subcommands = bit(render), .group = k_reference, .help = "its diffuse bounces; 0: direct light alone"},
    {.name = "seed", .argument = "S", .kind = Kind::integer, .fallback = "0", .range = {0, k_many},
     .subcommands = bit(render), .group = k_reference, .help = "of its random numbers"},

    {.name = "layer", .argument = "NAME", .kind = Kind::text, .subcommands = bit(compare), .group = k_comparison,
     .help = "of OpenEXR files, such as depth, or one channel, such as shadow.L0 (default: the image itself)"},
    {.name = "metric", .argument = "NAME", .kind = Kind::choice, .fallback = "all",
     .choices = "all|rmse|relmse|psnr|ssim|flip", .subcommands = bit(compare), .group = k_comparison, .help = "what to measure"},
    {.name = "fail-above", .argument = "METRIC=X", .kind = Kind::text, .repeats = true, .subcommands = bit(compare),
     .group = k_comparison, .help = "exit with 1 if a metric is above X (psnr, ssim: below X); may be given again"},
    {.name = "heatmap", .argument = "OUT.png", .kind = Kind::text, .subcommands = bit(compare), .group = k_comparison,
     .help = "write FLIP's error map: black where images look alike, pale yellow where they do not"},

    {.name = "json", .argument = "FILE", .kind = Kind::optional_file, .subcommands = k_every, .group = k_common,
     .help = "one JSON document on standard output, all else to standard error; or, as --json=FILE, to a file"},
    {.name = "config", .argument = "FILE", .kind = Kind::text, .subcommands = k_every, .group = k_common,
     .help = "options as a JSON object, such as {\"size\": \"640x360\"}; the command line wins"},
    {.name = "threads", .argument = "N", .kind = Kind::integer, .fallback = "0", .range = ranges::threads,
     .subcommands = k_every & ~(bit(bench_culling) | bit(bench_shadow_textures)), .group = k_common, .help = "0: all; images do not depend on it"},
    {.name = "quiet", .subcommands = k_every, .group = k_common, .help = "say nothing but errors"},
    {.name = "verbose", .letter = 'v', .subcommands = k_every, .group = k_common, .help = "say more"},
    {.name = "help", .letter = 'h', .subcommands = k_every, .group = k_common, .help = "show this"},
    {.name = "version", .subcommands = k_every, .group = k_common, .help = "show the version"},
};
// clang-format on
}   // namespace

std::span<const SubcommandInfo> subcommands()
{
    return k_subcommands;
}

std::span<const Option> options()
{
    return k_options;
}

const SubcommandInfo* find_subcommand(std::string_view name)
{
    for (const SubcommandInfo& subcommand : k_subcommands)
        if (subcommand.name == name) return &subcommand;
    return nullptr;
}

const Option* find_option(Subcommand subcommand, std::string_view name)
{
    for (const Option& option : k_options)
        if (option.name == name && (option.subcommands & bit(subcommand))) return &option;
    return nullptr;
}

}   // namespace gnomon::options
