// SPDX-License-Identifier: Apache-2.0
#pragma once
// Renders one frame by recursive ray tracing [Whitted 1980], in packets and queues.
//
// The image is cut into tiles, and a tile is one task. Within it nothing recurses: all rays of one kind and depth wait
// in a queue and are traced together, neighbours side by side, so that packets stay full and coherent:
//
//   primary rays -> hits, sorted by object -> points to shade -> shadow test: per light one queue of rays
//                                                             -> indirect light: one batch
//                                                             -> reflection queue, refraction queue -> next depth
//
// Rough metals reflect by the rays of their lobes (shading/lobe_rays.h). Those of a tile's primary hits are traced
// after its other rays; what they bring is filtered between pixels once all tiles are traced (lobe_filter.h).
//
// Which lights reach a batch of points, and which light arrives there by bounces, is decided by two interfaces
// (shadow_tester.h, indirect_light.h); the tiles contain no branch on a technique.
//
// Cost: the rays. The image depends on the scene, the view and the options alone, because a tile's order of work is
// fixed and tiles share nothing that is written.

#include <optional>

#include "base/tasks.h"
#include "gnomon/types.h"
#include "scene/sized_light.h"
#include "scene/view.h"
#include "shading/centre_samples.h"
#include "shading/frame_buffers.h"
#include "trace/trace_log.h"

namespace gnomon::trace {

class Blur;
class EnvironmentTechnique;
struct FrameScratch;
class IndirectLight;
class ShadowTester;
class SizedVisibility;

struct TracedOptions {
    int max_depth = 10;                      // reflections and refractions in a row
    int samples = 1;                         // per pixel
    PixelFilter filter = PixelFilter::box;   // not automatic
    /// More samples where something ends in a pixel (refinement.h). @pre samples is 1, and no random lobes
    bool adaptive = false;
    /// Of these: soft light of first samples is interpolated between pixels where it is alike (tile_lattice.cpp).
    bool interpolates = true;
    /// Of these, and of a filter wider than the pixel, in stops. None: that of the image of one sample a pixel, which a
    /// filter of a fixed number of samples has traced first, without counting its rays.
    std::optional<float> exposure{};
    shading::RefineOptions refine{};   // of adaptive samples; its exposure is set from the above
    /// Light above the display's white counts less in a filter wider than the pixel (image/pixel_filter.h).
    bool filters_shown = true;
    bool layers = false;   // fill all of shading::FrameBuffers, not `color` alone
    /// Leave what lies behind the scene out of `color`, and fill `alpha`. A surface that catches shadows counts as what
    /// lies behind, and its shadows as a dark surface.
    bool backdrop_apart = false;
    float min_throughput = 1 / 300.f;   // a ray whose path has a lower throughput is not traced
    int tile = 32;                      // pixels a side; a power of two
    // Reflection by rough metals (shading/lobe_rays.h), unless max_depth is 0.
    int lobe_rays = 16;            // of a pixel at most, all samples together; of each, a power of two
    bool random_lobes = false;     // for a reference: random directions, not filtered, and their error
    std::uint64_t lobe_seed = 0;   // of these
    /// Keep the first hits of tiles in the scratch memory, and use those that lie there (kept_tiles.h). Has no effect
    /// with more than one sample, layers, alpha, a filter of these, blur, lights with size, an environment image, or
    /// surfaces that thin light.
    bool keeps = false;
    bool continues = false;   // of these: see KeptTiles::begin_frame()
};

/// The techniques of a frame.
struct Techniques {
    ShadowTester* shadows = nullptr;     // null: every shadow ray is traced
    IndirectLight* indirect = nullptr;   // null: ambient light stands in for it
    /// Lights with size, in place of the lights that approximate emissive surfaces; follows the state. Null: these.
    const scene::SizedLights* sized = nullptr;
    SizedVisibility* sized_visibility = nullptr;   // of `sized`; null: a ray to each sample place
    /// The environment image, in place of the lights that approximate it. Null: these.
    EnvironmentTechnique* environment = nullptr;
    FrameScratch* scratch = nullptr;   // null: memory of the frame's own
};

/// @param blur  optional: the frame is at its shutter's middle; finds the touched pixels, and prepares its rounds
/// @param log  optional; only with one thread, and without a shadow technique
/// @param progress  in place of the current Interruption
/// @throws InterruptedError  the current work was interrupted (base/interruption.h). shadows->begin_frame() was called;
/// end_frame() may not have been called. The culling of [Nah 2009], which takes notes during a frame, must then be
/// discarded, and so must a light map.
FrameCounters trace_frame(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                          const TracedOptions& options, Tasks& tasks, shading::FrameBuffers& out,
                          const Techniques& techniques = {}, TraceLog* log = nullptr, const Progress& progress = {},
                          Blur* blur = nullptr);

/// Traces those samples of the blur's round that belong to one of its times.
/// @param state   at this time; so for rays, view and techniques
/// @param times   added to
/// @param time    none: takes no samples; the techniques follow the state
FrameCounters trace_blurred(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                            const TracedOptions& options, Tasks& tasks, FrameTimes& times, const Techniques& techniques,
                            Blur& blur, std::optional<int> time);

/// Writes the blurred pixels into the layers of the frame at the shutter's middle.
void finish_blur(const Blur& blur, const TracedOptions& options, Tasks& tasks, shading::FrameBuffers& out);

}   // namespace gnomon::trace
