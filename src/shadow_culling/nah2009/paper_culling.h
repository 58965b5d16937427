// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadow culling as published: J.-H. Nah, W.-C. Park, T.-D. Han, "Shadow Culling for Interactive Ray Tracing" (2009).
//
// What static geometry does to static geometry under a light that stands still does not change from frame to frame. So
// every triangle remembers, per light, whether the shadow rays that left it were all occluded or all free; where all of
// the triangle was seen, the next frame's rays are not traced, or against moving objects alone.
//
// A frame goes:
//   begin_frame     forgets what moved lights and objects have made untrue
//   decide, trace, note   per hit and light, from any threads; each with its own notes
//   see_image     the occlusion test over the primary hits (before or after the shadow rays, at any time in the
//   frame) end_frame       merges the notes
//
// DEVIATION(Nah 2009, 2.3 to 2.6): modes are read as they stood when the frame began, and what is learned is merged
// when it ends; the paper writes them as it goes. So the image does not depend on threads, nor on the order of the
// pixels.
//
// The scheme is a heuristic and its images can be wrong: shadows smaller than a pixel, primitives whose left or upper
// part is hidden, points never shaded. Nothing here hides that: callers compare against a full trace.
//
// Cost: one look-up a shadow ray; 0 to 2 triangle tests a pixel; the merge of what was seen. A light that moves costs a
// pass over all modes, an object that starts or stops one over all static triangles.

#include <span>
#include <vector>

#include "shadow_culling/nah2009/occlusion_test.h"
#include "shadow_culling/nah2009/set_modes.h"
#include "shadow_culling/nah2009/shadow_test.h"

namespace gnomon::shadow_culling {

struct PaperOptions {
    SetModesOptions set_modes;
    OcclusionTestOptions occlusion_test;
};

struct PaperCounters {
    std::uint64_t rays = 0;           // shadow rays asked for
    std::uint64_t skipped = 0;        // not traced at all
    std::uint64_t dynamic_only = 0;   // traced against moving objects alone
    std::uint64_t extra_tests = 0;    // triangle tests of the occlusion test
    void add(const PaperCounters& other);
};

/// What is no longer true when a frame begins. Empty lists for a still scene.
struct PaperChanges {
    std::span<const scene::LightId> lights;     // moved since the frame before
    std::span<const scene::ObjectId> started;   // static objects that are dynamic from now on
    std::span<const scene::ObjectId> stopped;   // dynamic objects that are static from now on, where they now stand
};

class PaperCulling {
 public:
    /// Objects are dynamic as the scene has them, over the whole clip.
    PaperCulling(const scene::SceneState& state, const ray::RayScene& rays, const PaperOptions& options = {});

    /// Follows one advance() of the state. A static object moved by hand is dynamic from then on, as the ray scene has
    /// it.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays);
    /// The same, told what changed.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const PaperChanges& changes);

    /// What one thread learned in this frame. Kept from frame to frame for its memory.
    struct Notes {
        PaperCounters counters;
        std::vector<PrimitiveId> touched;
    };

    PrimitiveId primitive(scene::ObjectId object, std::uint32_t triangle) const
    {
        return triangles_.id(object, triangle);
    }
    /// What to do about one shadow ray.
    ShadowDecision decide(PrimitiveId origin, int light, Notes& notes) const;
    /// What a ray met whose decision was full_traversal; the others teach nothing.
    /// @param dynamic_occluded  by a moving object; need not be known where a static one blocks
    void note(PrimitiveId origin, int light, StaticPart static_part, bool dynamic_occluded, Notes& notes);
    /// The occlusion test over all rows of the image; once a frame, by one thread.
    /// @param hits  row by row from the top left, width a row
    void see_image(std::span<const PrimaryHit> hits, std::size_t width);

    /// Merges and empties the notes of all threads that took part.
    void end_frame(std::span<Notes> notes);

    const PaperCounters& counters() const { return counters_; }   // since begin_frame; whole after end_frame
    const Modes& modes() const { return modes_; }
    const SceneTriangles& triangles() const { return triangles_; }
    std::size_t bytes() const { return modes_.bytes(); }

 private:
    void start(scene::ObjectId object);
    void stop(scene::ObjectId object);
    void forget_shadowed_by(const Box3& occluder);

    const scene::SceneState* state_;
    PaperOptions options_;
    SceneTriangles triangles_;
    Modes modes_;
    std::vector<Box3> static_bounds_;         // by object; where it stood while static, else empty
    std::vector<PrimitiveId> rendered_;       // in this frame
    std::vector<PrimitiveId> begin_afresh_;   // PARTIALLY_OCCLUDED when the last frame ended
    PaperCounters counters_;
};

/// Whether something in `occluder` may stand between some point of `receiver` and the light. Conservative: may say yes
/// where nothing does.
bool may_shadow(const scene::Light& light, const scene::LightState& at, const Box3& occluder, const Box3& receiver);

}   // namespace gnomon::shadow_culling
