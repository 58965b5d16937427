// SPDX-License-Identifier: Apache-2.0
#pragma once
// The plain types of the public interface: sizes, choices, counters, progress.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

/// An image's size in pixels.
struct Size {
    int width = 0;
    int height = 0;
    friend bool operator==(const Size&, const Size&) = default;
};

/// Which frames: inclusive, counted from 1.
struct FrameRange {
    int first = 1;
    int last = 1;
    int count() const { return last < first ? 0 : last - first + 1; }
    friend bool operator==(const FrameRange&, const FrameRange&) = default;
};

/// Whether the traced frame remembers which points which lights reach past everything that stands still. `certified`
/// gives the same image as `off`, to the bit, with fewer rays. `paper` guesses, as Nah, Park and Han published it in
/// 2009: its images depend on the frames before, and can be wrong.
enum class ShadowCulling { off, paper, certified };

/// Light that arrives by one bounce. `visible` knows what stands between; it is free of noise and of history. The
/// others let light pass through everything: `quadtree` gathers clusters of lit surface parts, as Ki and Oh published
/// it in 2007; `rsm` samples these parts, after Dachsbacher and Stamminger 2005.
enum class Indirect { off, rsm, quadtree, visible };
/// Who cuts, traces and sums for Indirect::visible with RenderMethod::raster. automatic: the device, if it is hardware.
enum class IndirectOn { automatic, cpu, vulkan };

/// What finds a ray's hit: Embree, or a kd-tree that counts its work, far slower and the same up to edges.
enum class Accelerator { embree, kdtree };

/// An image of the method's inside instead of the scene's light. `shadow_states`, of the traced frame: per light, what
/// was remembered where. `redrawn`, of the rasterised frame: what the light views drew anew in this frame, red what
/// moves, green what has come to rest, yellow what stands still and was drawn again; grey was kept. `clusters`: what
/// Indirect::quadtree takes for one light.
enum class Overlay { none, shadow_states, redrawn, clusters };

enum class ToneMap { none, neutral, agx, aces };

/// What was computed and what was not, for one frame.
struct FrameCounters {
    struct Shadow {
        std::uint64_t rays = 0;                // shadow rays asked for: (shading point, light) pairs that could be lit
        std::uint64_t rays_skipped = 0;        // of these, answered without any ray
        std::uint64_t rays_dynamic_only = 0;   // of these, traced against what moves alone
        /// Of these, answered otherwise than by tracing every ray; counted with an overlay of shadow states alone.
        std::optional<std::uint64_t> rays_wrong;
    } shadow;
    struct Indirect {
        std::uint64_t clusters = 0;
        std::uint64_t rays = 0;
        bool gathered_by_vulkan = false;   // Indirect::visible: cuts and sums are the device's
        bool traced_by_vulkan = false;     // and so are its rays to what is in a cut, to the sky, and past what moves
    } indirect;
    /// Work of Accelerator::kdtree by what the rays were for. What an overlay asks to check answers is not in it.
    struct KdTree {
        struct Work {
            std::uint64_t nodes = 0;   // traversed
            std::uint64_t tests = 0;   // ray against triangle
            friend bool operator==(const Work&, const Work&) = default;
        };
        Work primary, reflection, refraction, shadow, indirect;
        friend bool operator==(const KdTree&, const KdTree&) = default;
    };
    std::optional<KdTree> kdtree;
    std::uint64_t primary_rays = 0;
    std::uint64_t reflection_rays = 0;
    std::uint64_t refraction_rays = 0;
    std::uint64_t draws = 0;   // draw calls of the rasteriser
};

/// One step of long work. Return false from the callback to stop: the work then throws InterruptedError.
struct ProgressStep {
    std::string_view stage;   // "loading", "rendering", "encoding"
    double done = 0;          // 0 to 1
};
using Progress = std::function<bool(const ProgressStep&)>;

}   // namespace gnomon
