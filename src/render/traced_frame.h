// SPDX-License-Identifier: Apache-2.0
#pragma once
// One frame by ray tracing, Whitted's way [Whitted 1980], in packets and queues.
//
// The picture is cut into tiles; a tile is one task. Within it nothing recurses: all rays of one kind and depth wait in
// a queue and are traced together, neighbours side by side, so that packets stay full and coherent:
//
//   primary rays -> hits, sorted by object -> points to shade -> per light one queue of shadow rays
//                                                             -> reflection queue, refraction queue -> next depth
//
// Cost: the rays. The picture depends on the scene, the view and the options alone: a tile's order of work is fixed,
// and tiles share nothing that is written.

#include <cstdint>
#include <vector>

#include "base/image.h"
#include "base/tasks.h"
#include "gnomon/frame_times.h"
#include "gnomon/types.h"
#include "ray/ray_scene.h"
#include "render/view.h"

namespace gnomon::shadow_culling {
class CertifiedCulling;
class PaperCulling;
}   // namespace gnomon::shadow_culling
namespace gnomon::light_quadtree {
class MapLight;
class VisibleLight;
}   // namespace gnomon::light_quadtree

namespace gnomon::render {

class ReferenceLight;

struct TracedOptions {
    int max_depth = 10;                          // reflections and refractions in a row
    int samples = 1;                             // per pixel
    bool layers = false;                         // fill all of FrameBuffers, not `color` alone
    const ReferenceLight* reference = nullptr;   // path-traced indirect light; then without ambient light
    float min_share = 1 / 300.f;                 // a ray that would bring less than this share of a pixel is not traced
    // Points of bounced light: so many times further apart in mirrors and behind glass, and there the more, the less
    // (by the square root) they bring of a pixel.
    float mirrored_spacing = 4;
    int tile = 32;   // pixels a side; a power of two
};

/// Linear, averaged over samples; depth and normal are the first sample's.
struct FrameBuffers {
    ImageF color;      // 3
    ImageF depth;      // 1: along the view's forward axis; 0 where nothing was hit
    ImageF normal;     // 3: shading normal in world space
    ImageF albedo;     // 3
    ImageF direct;     // 3: what lights add at primary hits; with a reference also the surroundings
    ImageF indirect;   // 3: what bounced light adds there
    ImageF shadow;     // one channel a light: 1 lit, 0 in shadow or unlit, at primary hits
    // With a reference alone, layers or not, 3 each.
    ImageF variance;              // of color
    ImageF irradiance;            // by bounces, at primary hits of surfaces that scatter light
    ImageF irradiance_variance;   // of that
    FrameTimes times;             // of the frame; stages `scene` and `picture` are not its own
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
    shadow_culling::CertifiedCulling* certified = nullptr;   // the picture is the same to the bit
    shadow_culling::PaperCulling* paper = nullptr;           // a heuristic: the picture can be wrong
    light_quadtree::VisibleLight* visible = nullptr;         // bounced light, at most one of the two
    light_quadtree::MapLight* map = nullptr;                 // the same without visibility
    bool judge_later = false;   // certified culling: the caller calls judge() once the picture is shown
    // Optional, its lights set: filled, and every answer is checked by tracing every ray.
    StateMap* states = nullptr;

    Remembered(shadow_culling::CertifiedCulling* culling = nullptr) : certified(culling) {}   // NOLINT: one or none
};

/// @param log  optional; only with one thread, and with nothing remembered
/// @throws InterruptedError  progress returned false; a memory of the published culling is then to be thrown away
FrameCounters trace_frame(const scene::SceneState& state, const ray::RayScene& rays, const View& view,
                          const TracedOptions& options, Tasks& tasks, FrameBuffers& out,
                          const Remembered& remembered = {}, TraceLog* log = nullptr, const Progress& progress = {});

}   // namespace gnomon::render
