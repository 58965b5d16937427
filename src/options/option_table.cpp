// SPDX-License-Identifier: Apache-2.0
#include "options/option_table.h"

#include "options/enum_names.h"

namespace gnomon::options {

namespace {
using enum Subcommand;

constexpr std::uint32_t k_every = ~0u;
constexpr std::uint32_t k_images = bit(render) | bit(view);
constexpr std::uint32_t k_benches =
    bit(bench_trace) | bit(bench_culling) | bit(bench_shadow_textures) | bit(bench_indirect) | bit(bench_lights);
constexpr std::uint32_t k_reports = bit(bench_culling) | bit(bench_shadow_textures) | bit(bench_indirect);
constexpr std::uint32_t k_scened =
    k_images | (k_benches & ~bit(bench_shadow_textures));   // which generates its own scene

constexpr SubcommandInfo k_subcommands[] = {
    {render, "render", "SCENE -o OUT", 1, "render an image, numbered images, or a video", true},
    {join, "join", "OUT", 1, "end a video whose chunks are all rendered", true},
    {view, "view", "SCENE", 1, "show a scene in a window", true},
    {info, "info", "SCENE", 1, "print the contents of a scene", true},
    {compare, "compare", "A B", 2, "compare two images, of which the second is the reference", true},
    {devices, "devices", "", 0, "list the processor and the Vulkan devices with their features", true},
    {serve, "serve", "", 0, "answer rendering requests of simulators by HTTP", true},
    {bench_trace, "bench trace", "SCENE", 1, "measure the overhead of a traced frame beyond its rays", true},
    {bench_culling, "bench culling", "SCENE", 1, "measure shadow culling", true},
    {bench_shadow_textures, "bench shadow-textures", "", 0, "measure shadow textures on Vulkan", true},
    {bench_indirect, "bench indirect", "SCENE", 1, "compare methods for indirect light with a path-traced reference",
     true},
    {bench_lights, "bench lights", "SCENE", 1, "measure proven visibility of lights with size beside shadow rays",
     true},
    {bench_all, "bench all", "--report DIR", 0, "write one page with measurements for all papers", true},
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
constexpr std::string_view k_server = "Server";
constexpr std::string_view k_common = "Everywhere";

constexpr double k_many = 1e9;

// clang-format off
constexpr Option k_options[] = {
    {.name = "out", .letter = 'o', .argument = "OUT", .kind = Kind::text, .subcommands = bit(render), .group = k_output,
     .help = "output file: .png, .jpg, .exr (linear light, all layers), a numbered set such as name-{frame:04}.png, or a "
             "video: .mp4, .mov, .mkv, .webm, .gif"},
    {.name = "codec", .argument = "NAME", .kind = Kind::choice, .fallback = "auto", .choices = k_choices<VideoCodec>,
     .subcommands = bit(render), .group = k_output,
     .help = "codec of a video. auto: h264; vp9 in a .webm; with --background transparent, prores in a .mov and ffv1 in a "
             ".mkv. h264 has 8 bits; h265, prores, vp9 and ffv1 have 10 (vp9 with alpha: 8)"},
    {.name = "quality", .argument = "Q", .kind = Kind::integer, .range = {0, 100}, .subcommands = bit(render),
     .group = k_output,
     .help = "quality of a video or a .jpg, up to 100 (default: 75 of a video, 90 of a .jpg); ffv1 and .gif have none"},
    {.name = "audio", .argument = "FILE", .kind = Kind::text, .subcommands = bit(render), .group = k_output,
     .help = "sound of a video: begins with its first frame, and is cut where the video ends"},
    {.name = "timecode", .argument = "HH:MM:SS:FF", .kind = Kind::text, .subcommands = bit(render), .group = k_output,
     .help = "timecode of the clip's frame 1 in a .mov, .mp4 or .mkv; HH:MM:SS;FF drops numbers (default: 00:00:00:00 in a "
             ".mov and a .mkv, none in a .mp4)"},
    {.name = "exr-type", .argument = "NAME", .kind = Kind::choice, .fallback = "float", .choices = k_choices<ExrType>,
     .subcommands = bit(render), .group = k_output,
     .help = "values of an .exr. half: 16 bits, but depth and motion 32; float: 32 bits"},
    {.name = "exr-compression", .argument = "NAME", .kind = Kind::choice, .fallback = "zip",
     .choices = k_choices<ExrCompression>, .subcommands = bit(render), .group = k_output,
     .help = "compression of an .exr; pxr24 rounds values of 32 bits to 24, the others lose nothing"},
    {.name = "ids", .subcommands = bit(render), .group = k_output,
     .help = "also write ids of objects and materials to the .exr, from 1; 0: nothing"},
    {.name = "motion", .subcommands = bit(render), .group = k_output,
     .help = "also write motion since the frame before to the .exr, in pixels to the right and down"},
    {.name = "size", .argument = "WxH", .kind = Kind::size, .range = ranges::image_side, .subcommands = k_images, .group = k_output,
     .help = "size of the image in pixels; keeps the vertical field of view (default: that of the file, else 1280x720)"},
    {.name = "size", .argument = "WxH", .kind = Kind::size, .fallback = "512x512", .range = ranges::image_side,
     .subcommands = k_benches, .group = k_output, .help = "size of the image in pixels; keeps the vertical field of view"},
    {.name = "report", .argument = "DIR", .kind = Kind::text, .subcommands = k_reports, .group = k_output,
     .help = "also write DIR/index.html: tables and charts with the paper's values, and the data"},
    {.name = "report", .argument = "DIR", .kind = Kind::text, .subcommands = bit(bench_lights), .group = k_output,
     .help = "also write DIR/index.html: tables, images, shadow states, the rasterised frame beside the traced one, and "
             "the data"},
    {.name = "report", .argument = "DIR", .kind = Kind::text, .subcommands = bit(bench_all), .group = k_output,
     .help = "folder for index.html: tables and charts with the papers' values, and the data"},
    {.name = "scenes", .argument = "DIR", .kind = Kind::text, .subcommands = bit(bench_all), .group = k_output,
     .help = "folder with the papers' scenes, as docs/guide/scenes.md describes it (default: GNOMON_SCENES, else "
             "../shared/scenes)"},
    {.name = "quick", .subcommands = bit(bench_all), .group = k_output,
     .help = "use smaller images and fewer frames: takes minutes instead of a quarter of an hour"},
    {.name = "contact-sheet", .argument = "FILE.png", .kind = Kind::text, .subcommands = bit(render), .group = k_output,
     .help = "also write a labelled grid of up to 12 frames, evenly spaced over the range"},
    {.name = "renderer", .argument = "NAME", .kind = Kind::choice, .fallback = "trace", .choices = k_choices<RenderMethod>,
     .subcommands = k_images | bit(bench_indirect), .group = k_output,
     .help = "trace: ray tracing on the CPU; raster: rasterisation with Vulkan, without reflections and refraction"},

    {.name = "frame", .argument = "N", .kind = Kind::integer, .range = {1, k_many},
     .subcommands = bit(render) | bit(bench_trace), .group = k_frames, .help = "a single frame, counted from 1"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(render),
     .group = k_frames,
     .help = "first and last frame (default: the whole clip for a video or a numbered set, frame 1 for an image)"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(bench_culling),
     .group = k_frames, .help = "first and last frame (default: the first 100 frames)"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(bench_lights),
     .group = k_frames, .help = "first and last frame (default: the first frame)"},
    {.name = "step", .argument = "SECONDS...", .kind = Kind::number, .range = {0.001, 3600}, .repeats = true,
     .subcommands = bit(bench_culling), .group = k_frames,
     .help = "time between frames, which may lie beyond the clip's ends, instead of the clip's own frames. Several: the "
             "frames of the largest step, each after a history of frames of every step"},
    {.name = "start", .argument = "SECONDS", .kind = Kind::number, .range = {-1e6, 1e6}, .subcommands = bit(bench_culling),
     .group = k_frames, .help = "with --step: the time of frame 1 (default: the start of the clip)"},
    {.name = "frames", .argument = "A-B", .kind = Kind::range, .range = {1, k_many}, .subcommands = bit(bench_indirect),
     .group = k_frames, .help = "first and last frame (default: the first 10 frames)"},
    {.name = "frames", .argument = "F", .kind = Kind::integer, .fallback = "7", .range = {1, 200},
     .subcommands = bit(bench_shadow_textures), .group = k_frames, .help = "number of frames to measure, after two warm-up frames; times are medians"},
    {.name = "fps", .argument = "F", .kind = Kind::rate, .range = {0.001, 1000},
     .subcommands = k_images | bit(info), .group = k_frames,
     .help = "frames per second, a number or a fraction such as 24000/1001 (default: that of the file, else 24)"},
    {.name = "animation", .argument = "NAME|N|all", .kind = Kind::text, .subcommands = k_scened | bit(info), .group = k_frames,
     .help = "animation of a glTF file that plays, by name or by number from 0; all: all of them (default: the first, and "
             "each further one that animates nothing that one before it animates)"},
    {.name = "chunk", .argument = "I/N|A-B", .kind = Kind::chunk, .subcommands = bit(render), .group = k_frames,
     .help = "render only the I-th of N contiguous parts of the range, or its frames A to B; for a video, only write its "
             "frames, of which gnomon join makes the video"},
    {.name = "resume", .subcommands = bit(render), .group = k_frames,
     .help = "keep frames that are already complete: for a video, those that this version renders of the same scene with "
             "the same options and instruction set; for numbered images, all complete files of the right size. A video "
             "that is complete is left as it is"},
    {.name = "warm-up", .argument = "N", .kind = Kind::integer, .range = {0, k_many}, .subcommands = bit(render),
     .group = k_frames,
     .help = "first render the N frames before the range without writing them, to fill the caches (default: 0; 8 for a "
             "single image with --overlay shadow-states)"},
    {.name = "repeat", .argument = "R", .kind = Kind::integer, .fallback = "1", .range = {1, 1000},
     .subcommands = bit(bench_culling), .group = k_frames, .help = "number of runs; times are medians over the runs, and counts must be equal in all runs"},
    {.name = "threads", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::threads,
     .subcommands = bit(bench_culling), .group = k_frames, .help = "number of threads, 0: all; does not change counts"},
    {.name = "threads", .argument = "N", .kind = Kind::integer, .fallback = "0", .range = ranges::threads,
     .subcommands = bit(bench_shadow_textures), .group = k_frames,
     .help = "accepted for consistency; has no effect here, because one thread plans and the device draws"},

    {.name = "objects", .argument = "N...", .kind = Kind::integer, .range = {1, 1e6}, .repeats = true,
     .subcommands = bit(bench_shadow_textures), .group = k_scene, .help = "numbers of spheres in the scene (default: 300)"},
    {.name = "dynamic", .argument = "P...", .kind = Kind::number, .range = {0, 100}, .repeats = true,
     .subcommands = bit(bench_shadow_textures), .group = k_scene, .help = "percentages of dynamic spheres (default: 10)"},
    {.name = "movers", .argument = "M", .kind = Kind::integer, .range = {0, 1e6},
     .subcommands = bit(bench_shadow_textures), .group = k_scene,
     .help = "number of dynamic objects, instead of a percentage, in a crowd of small static objects of constant density"},
    {.name = "vertices", .argument = "V", .kind = Kind::integer, .fallback = "2037", .range = {5, 1e6},
     .subcommands = bit(bench_shadow_textures), .group = k_scene, .help = "number of vertices per sphere"},
    {.name = "camera", .argument = "NAME|N|auto", .kind = Kind::text, .fallback = "auto", .subcommands = k_scened, .group = k_scene,
     .help = "camera by name or by number from 0; auto: the first"},
    {.name = "turntable", .argument = "SECONDS", .kind = Kind::number, .range = ranges::turntable_seconds, .subcommands = k_images,
     .group = k_scene, .help = "let the camera circle the scene once in this time"},
    {.name = "lights", .argument = "N", .kind = Kind::integer, .range = {0, k_many}, .subcommands = k_scened, .group = k_scene,
     .help = "keep the first N lights of the file (default: all)"},
    {.name = "light", .argument = "\"...\"", .kind = Kind::text, .repeats = true, .subcommands = k_scened, .group = k_scene,
     .help = "replace the file's lights by \"spot X Y Z DX DY DZ HALF_ANGLE_DEG R G B\" or \"point X Y Z R G B\", in "
             "candela; may be repeated"},
    {.name = "side", .argument = "METRES", .kind = Kind::number, .fallback = "0.3", .range = {1e-4, 1e4},
     .subcommands = bit(bench_lights), .group = k_scene,
     .help = "make point and spot lights squares with sides of this length"},
    {.name = "environment", .argument = "FILE", .kind = Kind::text, .subcommands = k_images, .group = k_scene,
     .help = "light the scene by an environment map, longitude by latitude: .exr, .hdr, .png, .jpg, or builtin:studio"},
    {.name = "ground", .argument = "on|off", .kind = Kind::text, .subcommands = k_images, .group = k_scene,
     .help = "a ground under the scene that shows shadows and nothing else (default: under objects in the built-in studio, "
             "which a file without light gets)"},
    {.name = "variant", .argument = "NAME", .kind = Kind::text, .subcommands = k_scened | bit(info), .group = k_scene,
     .help = "variant of a glTF file's materials (default: the materials without a variant)"},

    {.name = "samples", .argument = "N...", .kind = Kind::integer, .range = {4, 65536}, .repeats = true,
     .subcommands = bit(bench_lights), .group = k_quality,
     .help = "numbers of shadow rays a point to compare with (default: 16, 64 and 256)"},
    {.name = "check", .argument = "N", .kind = Kind::integer, .fallback = "64", .range = {0, 65536},
     .subcommands = bit(bench_lights), .group = k_quality,
     .help = "trace so many segments for every proven answer, and count those that contradict it"},
    {.name = "truth", .argument = "N", .kind = Kind::integer, .fallback = "16384", .range = {64, 1048576},
     .subcommands = bit(bench_lights), .group = k_quality,
     .help = "shadow rays a point for the truth that errors are measured against"},
    {.name = "preset", .argument = "NAME", .kind = Kind::choice, .choices = "draft|good|best", .subcommands = bit(render),
     .group = k_quality,
     .help = "set several options at once, unless they are given: draft, for a quick look, and best take less or more time "
             "than good, which is what is set without it; docs/guide/videos.md has time and error of each"},
    {.name = "samples", .argument = "N|auto", .kind = Kind::integer_or_auto, .fallback = "auto", .range = ranges::samples,
     .subcommands = bit(render), .group = k_quality,
     .help = "samples per pixel. auto: one, and up to 16 more where something ends within the pixel: edges of objects and "
             "of shadows, highlights, what mirrors show; with --renderer raster, edges of opaque objects and textures; one "
             "with --reference, --overlay and --as-printed"},
    {.name = "samples", .argument = "N|auto", .kind = Kind::integer_or_auto, .fallback = "1", .range = ranges::samples,
     .subcommands = bit(view), .group = k_quality,
     .help = "samples per pixel; auto: as of render, and the default of images with blur"},
    {.name = "filter", .argument = "NAME", .kind = Kind::choice, .fallback = "auto", .choices = k_choices<PixelFilter>,
     .subcommands = k_images, .group = k_quality,
     .help = "how samples make a pixel. box: their mean; gaussian, blackman-harris: smooth, with those of the pixels "
             "around it; auto: blackman-harris with --samples auto, else box"},
    {.name = "shutter", .argument = "DEGREES", .kind = Kind::number, .fallback = "0", .range = ranges::shutter,
     .subcommands = k_images, .group = k_quality,
     .help = "motion blur: the shutter is open for this part of 360 of a frame's duration, around the frame's time; cinema "
             "has 180; 0: none"},
    {.name = "aperture", .argument = "F|LENGTHmm", .kind = Kind::text, .subcommands = k_images, .group = k_quality,
     .help = "depth of field: the lens by its f-number on a sensor 24 mm high, such as 2.8, or by its diameter, such as "
             "12mm; a scene's unit is the metre, and the focal length of an orthographic camera is one (default: none, "
             "everything is sharp)"},
    {.name = "focus", .argument = "METRES|auto", .kind = Kind::number_or_auto, .fallback = "auto", .range = ranges::focus,
     .subcommands = k_images, .group = k_quality,
     .help = "with --aperture: distance of what is sharp; auto: of what the middle of the image shows, frame by frame"},
    {.name = "memory", .argument = "MB", .kind = Kind::integer, .fallback = "0", .range = ranges::memory,
     .subcommands = k_images | bit(info), .group = k_quality,
     .help = "limit of what the scene's file may ask for (0: 2048 MB): textures beyond it are halved, for anything else the "
             "exit code is 3; and of ray tracing trees, caches and layers (0: none), beyond which the exit code is 4"},
    {.name = "max-depth", .argument = "N", .kind = Kind::integer, .fallback = "10", .range = ranges::max_depth,
     .subcommands = k_images | bit(bench_trace), .group = k_quality, .help = "largest number of reflections and refractions along a path"},
    {.name = "max-depth", .argument = "N", .kind = Kind::integer, .fallback = "0", .range = ranges::max_depth,
     .subcommands = bit(bench_culling), .group = k_quality,
     .help = "largest number of reflections and refractions along a path; shadows are computed at all hits; 0: primary "
             "hits only"},
    {.name = "accelerator", .argument = "NAME", .kind = Kind::choice, .fallback = "embree", .choices = k_choices<Accelerator>,
     .subcommands = k_images, .group = k_quality,
     .help = "acceleration structure; kdtree: slow, counts nodes and triangle tests, the same image except at edges"},
    {.name = "isa", .argument = "NAME", .kind = Kind::choice, .fallback = "auto", .choices = k_choices<Arithmetic>,
     .subcommands = k_images | bit(bench_trace), .group = k_quality,
     .help = "what traces rays on the CPU; auto: the same bytes on every processor; native: Embree's code for this one"},

    {.name = "exposure", .argument = "EV|auto|auto-frame", .kind = Kind::number_or_auto, .fallback = "auto",
     .choices = "auto-frame", .range = ranges::exposure, .subcommands = k_images, .group = k_look,
     .help = "exposure in stops. auto: of a video and of a numbered set, computed once from frames spread over the whole "
             "clip; of a single image and in a window, from the frame; of a window's recording, from its first frame; "
             "auto-frame: from each frame separately"},
    {.name = "tonemap", .argument = "NAME", .kind = Kind::choice, .fallback = "neutral", .choices = k_choices<ToneMap>,
     .subcommands = k_images, .group = k_look, .help = "tone mapping operator"},
    {.name = "background", .argument = "COLOR|transparent|environment", .kind = Kind::text, .fallback = "environment",
     .subcommands = k_images, .group = k_look,
     .help = "what the image shows behind the scene: a colour such as white, #ffc or #ffcc00; transparent: nothing, with "
             "alpha in .png, .exr, .mov, .webm, .mkv and .gif; environment: what lights the scene"},
    {.name = "overlay", .argument = "NAME", .kind = Kind::choice, .choices = k_choices<Overlay>,
     .subcommands = k_images, .group = k_look,
     .help = "colour the image by internal state. shadow-states: cached shadows, in a panel of --size for each light "
             "and each emissive object, with a legend; results that differ from tracing every ray are counted and highlighted. redrawn: what the "
             "light views of the rasteriser drew in this frame: red is dynamic, green came to rest, yellow was repaired. "
             "clusters: the light clusters of --indirect quadtree"},
    {.name = "overlay-light", .argument = "N", .kind = Kind::integer, .range = {0, k_many}, .subcommands = k_images,
     .group = k_look, .help = "show shadow states only for this light, counted from 0; emissive objects follow the lights (default: for all)"},

    {.name = "method", .argument = "HOW", .kind = Kind::choice, .choices = "paper|certified", .repeats = true,
     .subcommands = bit(bench_culling), .group = k_shadows, .help = "methods to compare with tracing every ray (default: both)"},
    {.name = "as-printed", .subcommands = bit(bench_culling), .group = k_shadows,
     .help = "follow the paper literally: modes are written within the frame, in scanline order; triangles seen in part "
             "stay so for ever; shadows of dynamic objects are cached; dynamic is what may move in the clip"},
    {.name = "reading", .argument = "NAME", .kind = Kind::text,
     .choices = "as-printed|by-clip|partial-stays|dynamic-blockers|marked-again|cached|parts", .repeats = true,
     .subcommands = bit(bench_culling), .group = k_shadows,
     .help = "also measure another reading of the paper (as-printed, by-clip, partial-stays, dynamic-blockers, "
             "marked-again), or one of its extensions: cached: the last static occluder is asked first; parts: large "
             "triangles are divided; see docs/papers/shadow-culling.md"},
    {.name = "tree", .argument = "NAME", .kind = Kind::choice, .fallback = "separate", .choices = "separate|hierarchy|mixed",
     .subcommands = bit(bench_culling), .group = k_shadows,
     .help = "kd-tree of the counts. separate: a tree for static and one for dynamic objects; hierarchy: one tree, split "
             "along the scene graph; mixed: one tree, split by the surface area heuristic alone"},
    {.name = "no-counts", .subcommands = bit(bench_culling), .group = k_shadows,
     .help = "do not count nodes and triangle tests on the kd-tree"},
    {.name = "as-printed", .subcommands = bit(render), .group = k_shadows,
     .help = "follow the papers literally. --shadow-culling paper: modes are written within the frame, in scanline order "
             "and on one thread; --renderer raster: the colour of a receiver's texture decides alone (results that differ "
             "from comparing distances are counted), and every receiver goes through the light quad-tree, one pass a "
             "level"},
    {.name = "as-printed", .subcommands = bit(bench_shadow_textures), .group = k_shadows,
     .help = "follow the paper literally: the texture's colour decides alone, and per-caster draws all casters nearer "
             "than the receiver, whether or not their extents meet"},
    {.name = "by-footprints", .subcommands = bit(bench_shadow_textures), .group = k_shadows,
     .help = "also measure coherent as published: it makes the texture of every receiver again whose footprint meets "
             "that of a change, even if the receiver lies nearer to the light"},
    {.name = "method", .argument = "HOW", .kind = Kind::choice, .choices = k_choices<ShadowTextures>, .repeats = true,
     .subcommands = bit(bench_shadow_textures), .group = k_shadows,
     .help = "methods to measure, as in render. per-caster: draw, for every receiver, the casters before it (slow); "
             "depth: one depth buffer; coherent: keep it from frame to frame; items: the same with one item buffer in "
             "place of all textures (default: depth coherent items)"},
    {.name = "shadow-culling", .argument = "HOW", .kind = Kind::choice, .fallback = "certified", .choices = k_choices<ShadowCulling>,
     .subcommands = k_images, .group = k_shadows,
     .help = "reuse traced shadows. certified: only proven ones, the same image as off; paper: the approximate method "
             "published in 2009, which can be wrong and depends on earlier frames"},
    {.name = "sun-size", .argument = "DEGREES", .kind = Kind::number, .fallback = "0", .range = ranges::sun_size,
     .subcommands = k_images, .group = k_shadows,
     .help = "angular diameter of directional lights, which gives their shadows soft edges; the sun's is 0.53, and 0 is a "
             "point"},
    {.name = "shadow-textures", .argument = "HOW", .kind = Kind::choice, .fallback = "items",
     .choices = k_choices<ShadowTextures>, .subcommands = k_images, .group = k_shadows,
     .help = "method for rasterised shadows. items: one item buffer for all receivers, redraw only what changed; "
             "coherent: a texture for each receiver, redraw only what changed; depth: draw all textures from one depth "
             "buffer; per-caster: from the casters before each receiver; all give the same image"},
    {.name = "shadow-filter", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::shadow_filter,
     .subcommands = k_images, .group = k_shadows, .help = "width of the edges of rasterised shadows in texels; 0: hard edges"},
    {.name = "moving-lights", .subcommands = bit(bench_culling) | bit(bench_indirect), .group = k_shadows,
     .help = "move every light along a small circle, so that no cached result can be reused"},

    {.name = "method", .argument = "HOW...", .kind = Kind::text, .choices = "visible|quadtree|separate|printed|shadowed|separate-shadowed|rsm",
     .repeats = true, .subcommands = bit(bench_indirect), .group = k_indirect,
     .help = "methods to measure: visible; quadtree:LEVEL, quadtree:LEVEL:MARGIN (see --validity-margin of render); "
             "separate:LEVEL, with separate trees of static and dynamic objects; printed:LEVEL, the published one by one pass "
             "a level; shadowed:LEVEL, separate-shadowed:LEVEL, with shadows of clusters; rsm:SAMPLES, "
             "rsm:SAMPLES:RADIUS (radius of the disk in sides of the light map; 0.3); may be repeated (default: visible; "
             "with --report, every method of the paper)"},
    {.name = "indirect", .argument = "HOW", .kind = Kind::choice, .fallback = "visible", .choices = k_choices<Indirect>,
     .subcommands = k_images, .group = k_indirect,
     .help = "method for indirect light. visible: irradiance cache, all bounces, with shadows and without noise; "
             "quadtree: clusters of lit surfaces, as published in 2007; rsm: samples of a reflective shadow map; the "
             "latter two have one bounce without shadows"},
    {.name = "bounces", .argument = "N|all", .kind = Kind::integer_or_all, .fallback = "all",
     .range = ranges::reference_bounces, .subcommands = k_images, .group = k_indirect,
     .help = "diffuse bounces of method visible, and of the reference, where 0 is direct light alone"},
    {.name = "indirect-memory", .argument = "MB", .kind = Kind::integer, .fallback = "16", .range = ranges::indirect_memory,
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect,
     .help = "visible: size of the irradiance cache, at least twice the points of a frame, four times up to 1 GB; points "
             "unseen for longest are evicted first; affects time, not images"},
    {.name = "indirect-on", .argument = "WHERE", .kind = Kind::choice, .fallback = "auto", .choices = k_choices<IndirectOn>,
     .subcommands = k_images, .group = k_indirect,
     .help = "visible with --renderer raster: where to cut the light tree, trace rays and sum irradiance. vulkan: on the "
             "device, including rays if it has ray-tracing pipelines; auto: on the device unless it is a software "
             "driver; the same image up to rounding"},
    {.name = "rsm-samples", .argument = "N", .kind = Kind::integer, .fallback = "256", .range = ranges::rsm_samples,
     .subcommands = k_images, .group = k_indirect, .help = "rsm: number of samples of the reflective shadow map"},
    {.name = "indirect-level", .argument = "N", .kind = Kind::integer, .fallback = "5", .range = ranges::indirect_level,
     .subcommands = k_images, .group = k_indirect,
     .help = "quadtree: finest level of the cut. 7: 8 x 8 nodes; 6: 16 x 16; 5: 32 x 32; 4: 64 x 64; 1: 512 x 512"},
    {.name = "depth-threshold", .argument = "X", .kind = Kind::number, .fallback = "0.05", .range = ranges::depth_threshold,
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect,
     .help = "quadtree: largest difference of depths in a cluster, as a fraction of the light view's depth range"},
    {.name = "normal-threshold", .argument = "X", .kind = Kind::number, .fallback = "0.9", .range = ranges::normal_threshold,
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect, .help = "quadtree: smallest cosine between normals in a cluster"},
    {.name = "validity-margin", .argument = "X", .kind = Kind::number, .fallback = "0", .range = ranges::validity_margin,
     .subcommands = k_images, .group = k_indirect,
     .help = "quadtree: fraction of the thresholds around them within which a cluster and the four below it share the "
             "light; 0: as published"},
    {.name = "separate-trees", .subcommands = k_images, .group = k_indirect,
     .help = "quadtree, traced: clusters of static and of dynamic objects are kept apart, against flicker; not in the "
             "paper"},
    {.name = "cluster-shadows", .subcommands = k_images, .group = k_indirect,
     .help = "quadtree, traced: clusters are occluded, by rays from the receivers; not in the paper"},
    {.name = "receivers", .argument = "HOW", .kind = Kind::choice, .fallback = "64", .choices = "64|full",
     .subcommands = k_images | bit(bench_indirect), .group = k_indirect,
     .help = "rsm, quadtree: number of receivers along the longer side of the image; full: every pixel"},

    {.name = "reference", .subcommands = bit(render), .group = k_reference,
     .help = "compute indirect light by path tracing: slow, unbiased, with an estimate of its noise"},
    {.name = "spp", .argument = "N", .kind = Kind::integer, .fallback = "1024", .range = ranges::spp,
     .subcommands = bit(render), .group = k_reference, .help = "paths per pixel of the reference"},
    {.name = "spp", .argument = "N", .kind = Kind::integer, .fallback = "4096", .range = {2, ranges::spp.high},
     .subcommands = bit(bench_indirect), .group = k_reference, .help = "paths per point of the reference"},
    {.name = "judged", .argument = "N", .kind = Kind::integer, .fallback = "4", .range = {1, 1000},
     .subcommands = bit(bench_indirect), .group = k_reference, .help = "number of frames in the range that are compared with a reference"},
    {.name = "judged-every", .argument = "PIXELS", .kind = Kind::choice, .fallback = "8", .choices = "1|2|4|8|16",
     .subcommands = bit(bench_indirect), .group = k_reference,
     .help = "pixels from one compared point to the next; blocks of 32 x 32 pixels hold 16 points if it is 8, and 256 "
             "if it is 2"},
    {.name = "keep-references", .argument = "DIR", .kind = Kind::text, .subcommands = bit(bench_indirect),
     .group = k_reference, .help = "folder in which references are kept and reused"},
    {.name = "bounces", .argument = "N", .kind = Kind::integer, .fallback = "1", .range = ranges::bounces,
     .subcommands = bit(bench_indirect), .group = k_reference,
     .help = "diffuse bounces of the reference, and of method visible; 1000: all"},
    {.name = "seed", .argument = "S", .kind = Kind::integer, .fallback = "0", .range = {0, k_many},
     .subcommands = bit(render), .group = k_reference, .help = "seed of the reference's random numbers"},

    {.name = "layer", .argument = "NAME", .kind = Kind::text, .subcommands = bit(compare), .group = k_comparison,
     .help = "layer of OpenEXR files, such as depth, or a channel, such as shadow.L0 (default: the image itself)"},
    {.name = "metric", .argument = "NAME", .kind = Kind::choice, .fallback = "all",
     .choices = "all|rmse|relmse|psnr|ssim|flip", .subcommands = bit(compare), .group = k_comparison, .help = "metric to compute"},
    {.name = "fail-above", .argument = "METRIC=X", .kind = Kind::text, .repeats = true, .subcommands = bit(compare),
     .group = k_comparison, .help = "exit with code 1 if a metric is above X (psnr, ssim: below X); may be repeated"},
    {.name = "heatmap", .argument = "OUT.png", .kind = Kind::text, .subcommands = bit(compare), .group = k_comparison,
     .help = "write the FLIP error map: black where images look the same, pale yellow where they differ most"},

    {.name = "address", .argument = "HOST:PORT", .kind = Kind::text, .fallback = "127.0.0.1:8000", .subcommands = bit(serve),
     .group = k_server,
     .help = "where to answer; port 0: any that is free. Whoever reaches an address other than that of this machine's loopback "
             "can use its processor"},
    {.name = "max-upload", .argument = "MB", .kind = Kind::integer, .fallback = "256", .range = {1, 65536},
     .subcommands = bit(serve), .group = k_server, .help = "largest request; a larger one is refused"},
    {.name = "max-size", .argument = "WxH", .kind = Kind::size, .fallback = "4096x4096", .range = ranges::image_side,
     .subcommands = bit(serve), .group = k_server, .help = "largest image"},
    {.name = "request-time", .argument = "SECONDS", .kind = Kind::number, .fallback = "600", .range = ranges::time_limit,
     .subcommands = bit(serve), .group = k_server, .help = "longest time of one request"},
    {.name = "environment", .argument = "FILE", .kind = Kind::text, .fallback = "builtin:studio", .subcommands = bit(serve),
     .group = k_server, .help = "environment map that lights scenes without lights, or builtin:studio"},
    {.name = "samples", .argument = "N|auto", .kind = Kind::integer_or_auto, .fallback = "auto", .range = ranges::samples,
     .subcommands = bit(serve), .group = k_server, .help = "samples per pixel of colours; auto: as of render"},
    {.name = "exposure", .argument = "EV|auto", .kind = Kind::number_or_auto, .fallback = "0", .range = ranges::exposure,
     .subcommands = bit(serve), .group = k_server, .help = "exposure of colours in stops. auto: from each image"},
    {.name = "tonemap", .argument = "NAME", .kind = Kind::choice, .fallback = "neutral", .choices = k_choices<ToneMap>,
     .subcommands = bit(serve), .group = k_server, .help = "tone mapping operator of colours"},
    {.name = "indirect", .argument = "HOW", .kind = Kind::choice, .fallback = "visible", .choices = k_choices<Indirect>,
     .subcommands = bit(serve), .group = k_server, .help = "method for the indirect light of colours, as of render"},
    {.name = "memory", .argument = "MB", .kind = Kind::integer, .fallback = "0", .range = ranges::memory,
     .subcommands = bit(serve), .group = k_server, .help = "memory that a renderer may hold, as of render; there are three"},

    {.name = "json", .argument = "FILE", .kind = Kind::optional_file, .subcommands = k_every, .group = k_common,
     .help = "write one JSON document to standard output and all other text to standard error; --json=FILE writes it to a file"},
    {.name = "config", .argument = "FILE", .kind = Kind::text, .subcommands = k_every, .group = k_common,
     .help = "file with options as a JSON object, such as {\"size\": \"640x360\"}; the command line takes precedence"},
    {.name = "threads", .argument = "N", .kind = Kind::integer, .fallback = "0", .range = ranges::threads,
     .subcommands = k_every & ~(bit(bench_culling) | bit(bench_shadow_textures)), .group = k_common, .help = "number of threads, 0: all; does not change images"},
    {.name = "time-limit", .argument = "SECONDS", .kind = Kind::number, .range = ranges::time_limit,
     .subcommands = k_every & ~bit(view), .group = k_common,
     .help = "stop after so much time, as an interruption does: exit code 130"},
    {.name = "strict", .subcommands = k_scened | bit(info), .group = k_common,
     .help = "refuse a file with any error, instead of repairing harmless ones with a warning"},
    {.name = "quiet", .subcommands = k_every, .group = k_common, .help = "print only errors"},
    {.name = "verbose", .letter = 'v', .subcommands = k_every, .group = k_common, .help = "print more details"},
    {.name = "help", .letter = 'h', .subcommands = k_every, .group = k_common, .help = "show this help"},
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
