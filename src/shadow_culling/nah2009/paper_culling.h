// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadow culling as published: J.-H. Nah, W.-C. Park, T.-D. Han, "Shadow Culling for Interactive Ray Tracing" (2009).
//
// The shadows of static geometry on static geometry do not change while the light rests. So every triangle stores, per
// light, whether the shadow rays that left it were all occluded or all free. If all of the triangle was seen, the next
// frame's rays are not traced, or only against dynamic objects.
//
// Steps of a frame:
//   begin_frame           clears the modes that moved lights and objects invalidate
//   decide, trace, note   per hit and light, from any thread, each with its own notes
//   see_image             the occlusion test over the primary hits, before or after the shadow rays
//   end_frame             merges the notes
//
// DEVIATION(Nah 2009, 2.3 to 2.6): modes are read as they were when the frame began, and new results are merged at its
// end; the paper writes them immediately. So the image depends neither on threads nor on the order of the pixels.
// PaperOptions::as_printed() writes immediately; see_pixel() then takes the place of see_image(), and all calls come
// from one thread, pixel by pixel in scanline order.
//
// DEVIATION(Nah 2009, 2.2): the paper does not say when an object is dynamic. Here it is from the frame in which it
// changes until it has rested for some frames (scene/mobility.h); then its primitives have modes as others have.
// PaperOptions::as_printed() calls dynamic what may change in the clip, because the paper gives the share of dynamic
// objects as a property of the scene.
//
// The method is a heuristic and its images can be wrong: shadows smaller than a pixel, primitives whose left or upper
// part is hidden, points that were never shaded. Callers compare with a full trace.
//
// Cost: one look-up per shadow ray, 0 to 2 triangle tests per pixel, and the merge of what was seen. A light that moves
// costs a pass over all modes, an object that starts or stops one over all static triangles.

#include <array>
#include <span>
#include <vector>

#include "scene/mobility.h"
#include "shadow_culling/nah2009/occlusion_test.h"
#include "shadow_culling/nah2009/set_modes.h"
#include "shadow_culling/nah2009/shadow_test.h"

namespace gnomon::shadow_culling {

/// Which objects are dynamic: those that change in the present frame, or did recently (scene::Mobility), or those that
/// may change in the clip (SceneState::is_dynamic).
enum class PaperMobility : std::uint8_t { by_frame, by_clip };

struct PaperOptions {
    SetModesOptions set_modes;
    OcclusionTestOptions occlusion_test;
    PaperMobility mobility = PaperMobility::by_frame;
    bool writes_at_once = false;   // modes are written when they are found, not at the end of the frame
    int part_levels = 0;           // see SceneTriangles

    /// The scheme by the letter: what Tables 1 to 3, 2.2 and 2.6 print. Table 2's `hitResult = false` is the exception,
    /// because the text above it says the opposite.
    static PaperOptions as_printed();
};

struct PaperCounters {
    std::uint64_t rays = 0;                             // shadow rays requested
    std::uint64_t skipped = 0;                          // not traced at all
    std::uint64_t dynamic_only = 0;                     // traced against dynamic objects only
    std::uint64_t extra_tests = 0;                      // triangle tests of the occlusion test
    std::array<std::uint64_t, k_full_reasons> full{};   // traced against everything, by FullReason
    void add(const PaperCounters& other);
};

/// The changes that invalidate modes when a frame begins. Empty lists if nothing changed.
struct PaperChanges {
    std::span<const scene::LightId> lights;     // moved since the last frame
    std::span<const scene::ObjectId> started;   // static objects that are dynamic from now on
    std::span<const scene::ObjectId>
        stopped;   // dynamic objects that are static from now on, in their present positions
};

class PaperCulling {
 public:
    PaperCulling(const scene::SceneState& state, const ray::RayScene& rays, const PaperOptions& options = {});

    /// Follows one advance() of the state. Must be called for every advance().
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays);
    /// The same for given changes.
    void begin_frame(const scene::SceneState& state, const ray::RayScene& rays, const PaperChanges& changes);

    /// The results of one thread in this frame. Reused from frame to frame.
    struct Notes {
        PaperCounters counters;
        std::vector<PrimitiveId> touched;
    };

    /// The primitive at a point of a triangle with barycentric coordinates (u, v).
    PrimitiveId primitive(scene::ObjectId object, std::uint32_t triangle, float u, float v) const
    {
        return triangles_.at(object, triangle, u, v);
    }
    const PaperOptions& options() const { return options_; }
    bool is_dynamic(scene::ObjectId object) const { return triangles_.object_is_dynamic(object); }
    /// Whether any object is dynamic in this frame.
    bool any_dynamic() const { return dynamic_objects_ > 0; }
    /// Whether an object that may change in the clip is not dynamic in this frame.
    bool some_rest() const { return dynamic_objects_ < state_->dynamic_objects().size(); }
    /// Whether a triangle is transparent to shadow rays.
    bool lets_light_through(scene::ObjectId object, std::uint32_t triangle) const;
    /// Decides how to trace one shadow ray.
    ShadowDecision decide(PrimitiveId origin, int light, Notes& notes) const;
    /// Notes the result of a ray whose decision was full_traversal; other rays give no information.
    /// @param dynamic_occluded  by a dynamic object; need not be known if a static one occludes
    void note(PrimitiveId origin, int light, StaticPart static_part, bool dynamic_occluded, Notes& notes);
    /// Runs the occlusion test over all rows of the image; once per frame, by one thread.
    /// @param hits  row by row from the top left, `width` per row
    void see_image(std::span<const PrimaryHit> hits, std::size_t width);
    /// With PaperOptions::writes_at_once: the same for one pixel, before its shadow rays.
    void see_pixel(const PrimaryHit& hit, PrimitiveId left, PrimitiveId upper, bool edge);

    /// Merges and clears the notes of all threads.
    void end_frame(std::span<Notes> notes);

    const PaperCounters& counters() const { return counters_; }   // since begin_frame; complete after end_frame
    const Modes& modes() const { return modes_; }
    const SceneTriangles& triangles() const { return triangles_; }
    std::size_t bytes() const { return modes_.bytes(); }

 private:
    void start(scene::ObjectId object);
    void stop(scene::ObjectId object);
    Box3 bounds_of(scene::ObjectId object) const;   // empty: it was removed from the scene
    void forget_modes(scene::ObjectId object);
    void forget_shadowed_by(const Box3& occluder);
    FullReason reason_of_full(PrimitiveId origin, int light) const;

    const scene::SceneState* state_;
    PaperOptions options_;
    SceneTriangles triangles_;
    Modes modes_;
    std::vector<Box3> static_bounds_;         // by object: of static ones, else empty
    std::vector<PrimitiveId> rendered_;       // in this frame
    std::vector<PrimitiveId> begin_afresh_;   // PARTIALLY_OCCLUDED when the last frame ended
    std::vector<char> partly_seen_;           // by primitive: PARTIALLY_OCCLUDED when it was seen last
    scene::Mobility mobility_;
    std::size_t dynamic_objects_ = 0;
    PaperCounters counters_;
};

/// Whether something in `occluder` may lie between a point of `receiver` and the light. Conservative: may be true where
/// nothing does.
bool may_shadow(const scene::Light& light, const scene::LightState& at, const Box3& occluder, const Box3& receiver);

}   // namespace gnomon::shadow_culling
