// SPDX-License-Identifier: Apache-2.0
#pragma once
// The plain types of the public interface: sizes, enums, counters, progress.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

/// The size of an image in pixels.
struct Size {
    int width = 0;
    int height = 0;
    friend bool operator==(const Size&, const Size&) = default;
};

/// Pixels of an image; x and y from the top left corner, from 0.
struct PixelRectangle {
    int x = 0, y = 0;
    int width = 0, height = 0;
    friend bool operator==(const PixelRectangle&, const PixelRectangle&) = default;
};

/// A range of frames, inclusive, numbered from 1.
struct FrameRange {
    int first = 1;
    int last = 1;
    /// The number of frames; 0 if the range is empty.
    int count() const { return last < first ? 0 : last - first + 1; }
    friend bool operator==(const FrameRange&, const FrameRange&) = default;
};

/// Whether the traced frame remembers which lights each point can see past static geometry. `certified` gives the same
/// image as `off`, bit for bit, with fewer rays. `paper` is the heuristic of Nah, Park and Han (2009): its images
/// depend on earlier frames and can be wrong.
enum class ShadowCulling { off, paper, certified };

/// Light that arrives by one bounce. `visible` accounts for occluders and has neither noise nor dependence on earlier
/// frames. The other two ignore occlusion: `quadtree` gathers clusters of lit surface texels [Ki and Oh 2007]; `rsm`
/// samples these texels [Dachsbacher and Stamminger 2005].
enum class Indirect { off, rsm, quadtree, visible };
/// The device that computes cuts, visibility and sums of Indirect::visible with RenderMethod::raster. automatic: the
/// Vulkan device if it is hardware, else the CPU.
enum class IndirectOn { automatic, cpu, vulkan };

/// The ray tracer: Embree, or a kd-tree that counts its work. The kd-tree is far slower; its images are the same up to
/// edges.
enum class Accelerator { embree, kdtree };

/// A visualisation that replaces the rendered scene. `shadow_states` (traced frames) shows the visibility that was
/// remembered for each light. `redrawn` (rasterised frames) shows which texels of the light views were drawn in this
/// frame: red for dynamic objects, green for objects that came to rest, yellow for static objects that were drawn
/// again, grey for texels that were kept. `clusters` shows the clusters of Indirect::quadtree.
enum class Overlay { none, shadow_states, redrawn, clusters };

/// The curve from linear radiance to screen colour: a cut at white, Khronos PBR Neutral, AgX, or ACES.
enum class ToneMap { none, neutral, agx, aces };

/// How the samples of an image make its pixels. box: the mean of a pixel's own samples. gaussian, blackman_harris:
/// weights that fall off smoothly to 1.5 pixels from the pixel's centre; none is negative, so nothing rings. automatic:
/// blackman_harris with adaptive samples, and box with a fixed number.
enum class PixelFilter { automatic, box, gaussian, blackman_harris };

/// Work that was done and work that was avoided in one frame.
struct FrameCounters {
    /// Shadow rays.
    struct Shadow {
        std::uint64_t rays = 0;                // shadow queries: (shading point, light) pairs that could be lit
        std::uint64_t rays_skipped = 0;        // of these, answered without any ray
        std::uint64_t rays_dynamic_only = 0;   // of these, traced against dynamic objects only
        /// Of these, the number that differ from tracing every ray; counted only with an overlay of shadow states.
        std::optional<std::uint64_t> rays_wrong;
        std::uint64_t textures = 0;           // rasterised: shadow textures of receivers that were drawn
        std::uint64_t textures_waiting = 0;   // textures that changed out of sight, to be drawn when they are seen
        /// Rasterised, with RenderOptions::as_printed: pairs of a surface and a light that it faces.
        std::optional<std::uint64_t> looked_up;
        /// Of these, those in which the texture's colour decides otherwise than the distances to the light.
        std::optional<std::uint64_t> looked_up_wrong;
    } shadow;
    /// Indirect light.
    struct Indirect {
        std::uint64_t clusters = 0;
        std::uint64_t rays = 0;
        bool gathered_by_vulkan = false;   // Indirect::visible: the device computes cuts and sums
        bool traced_by_vulkan = false;     // also traces rays to nodes of a cut, to the sky and past dynamic objects
        // Indirect::rsm, quadtree: what is the same as in the frame before, and was not computed again.
        bool kept_map = false;         // light map, tree and clusters
        bool kept_receivers = false;   // the light of sparse receivers
    } indirect;
    /// Work of Accelerator::kdtree by kind of ray. Rays that an overlay traces to check results are not counted.
    struct KdTree {
        /// The work of one kind of ray.
        struct Work {
            std::uint64_t nodes = 0;   // traversed
            std::uint64_t tests = 0;   // ray against triangle
            friend bool operator==(const Work&, const Work&) = default;
        };
        Work primary, reflection, refraction, shadow, indirect;
        friend bool operator==(const KdTree&, const KdTree&) = default;
    };
    std::optional<KdTree> kdtree;
    bool kept_surfaces = false;   // rasterised: the G-buffer of the frame before was used again
    bool kept_image = false;      // traced: nothing changed, and the frame has the layers of the one before
    /// Work of following the scene's changes since the last frame.
    struct Update {
        std::uint64_t nodes = 0;   // tracks that were evaluated, values that were taken over, nodes that were visited
        std::uint64_t instances = 0;   // objects of the ray scene that were placed or refitted
        bool began_anew = false;       // the scene was new to the renderer, or differs in more than parts that may
                                       // move; or something fixed was promoted
    } update;
    /// Adaptive samples (k_adaptive_samples).
    struct Samples {
        std::uint64_t pixels = 0;   // pixels that have more than one sample
        std::uint64_t taken = 0;    // samples beyond the first of each pixel
        std::uint64_t shaded = 0;   // of these, the ones that could not take their light from neighbouring pixels
    } samples;
    std::uint64_t primary_rays = 0;
    std::uint64_t reflection_rays = 0;
    std::uint64_t refraction_rays = 0;
    std::uint64_t draws = 0;   // draw calls of the rasteriser
};

/// Progress of long work. If the callback returns false, the work stops and throws InterruptedError; if it throws, the
/// work stops and throws the same. It is called every few milliseconds, from any of the threads that work, never from
/// two at once, and not after the work has ended. It should return at once, because it holds up its thread.
struct ProgressStep {
    std::string_view stage;   // "loading", "preparing", "tracing", "drawing", "rendering", "encoding", ...
    double done = 0;          // 0 to 1, within the stage
};
/// Receives the progress, and returns whether to go on.
using Progress = std::function<bool(const ProgressStep&)>;

}   // namespace gnomon
