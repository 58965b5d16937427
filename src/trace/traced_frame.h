// SPDX-License-Identifier: Apache-2.0
#pragma once
// One frame by ray tracing, Whitted's way [Whitted 1980], in packets and queues.
//
// The image is cut into tiles; a tile is one task. Within it nothing recurses: all rays of one kind and depth wait in
// a queue and are traced together, neighbours side by side, so that packets stay full and coherent:
//
//   primary rays -> hits, sorted by object -> points to shade -> per light one queue of shadow rays
//                                                             -> reflection queue, refraction queue -> next depth
//
// Cost: the rays. The image depends on the scene, the view and the options alone: a tile's order of work is fixed,
// and tiles share nothing that is written.

#include <cstdint>
#include <vector>

#include "base/tasks.h"
#include "gnomon/types.h"
#include "ray/ray_scene.h"
#include "scene/view.h"
#include "shading/frame_buffers.h"

namespace gnomon::shadow_culling {
class CertifiedCulling;
class PaperCulling;
}   // namespace gnomon::shadow_culling
namespace gnomon::light_quadtree {
class MapLight;
}
namespace gnomon::irradiance_cache {
class IrradianceCache;
}
namespace gnomon::reference {
class ReferenceLight;
}

namespace gnomon::trace {

struct TracedOptions {
    int max_depth = 10;                                     // reflections and refractions in a row
    int samples = 1;                                        // per pixel
    bool layers = false;                                    // fill all of shading::FrameBuffers, not `color` alone
    const reference::ReferenceLight* reference = nullptr;   // path-traced indirect light; then without ambient light
    float min_throughput = 1 / 300.f;   // a ray that would bring less than this share of a pixel is not traced
    // Points of bounced light: so many times further apart in mirrors and behind glass, and there the more, the less
    // (by the square root) they bring of a pixel.
    float mirrored_spacing = 4;
    int tile = 32;   // pixels a side; a power of two
};

/// Every bulk trace of a frame, in order: the rays alone can then be traced again, for comparison (bench trace).
struct TraceLog {
    struct Entry {
        ray::RayQueue rays;
        bool any_hit = false;
    };
    std::vector<Entry> entries;

    std::uint64_t rays() const;
    /// Traces it all again on the caller's thread and returns a number that depends on the results.
    std::uint64_t replay(const ray::RayScene& scene) const;
};

struct StateMap;

/// What is remembered from frame to frame. At most one of the two of shadow culling.
struct Remembered {
    shadow_culling::CertifiedCulling* certified = nullptr;   // the image is the same to the bit
    shadow_culling::PaperCulling* paper = nullptr;           // a heuristic: the image can be wrong
    irradiance_cache::IrradianceCache* visible = nullptr;    // bounced light, at most one of the two
    light_quadtree::MapLight* map = nullptr;                 // the same without visibility
    bool judge_later = false;   // certified culling: the caller calls judge() once the image is shown
    // Optional, its lights set: filled, and every answer is checked by tracing every ray.
    StateMap* states = nullptr;

    Remembered(shadow_culling::CertifiedCulling* culling = nullptr) : certified(culling) {}   // NOLINT: one or none
};

/// @param log  optional; only with one thread, and with nothing remembered
/// @throws InterruptedError  progress returned false; a memory of the published culling is then to be thrown away
FrameCounters trace_frame(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                          const TracedOptions& options, Tasks& tasks, shading::FrameBuffers& out,
                          const Remembered& remembered = {}, TraceLog* log = nullptr, const Progress& progress = {});

}   // namespace gnomon::trace
