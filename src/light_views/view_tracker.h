// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tracks one light view: the footprints of static objects, the rectangles in which dynamic objects were drawn, and the
// plan that follows from a frame's changes.
//
// Cost per frame: the objects that changed or are dynamic, and the static ones that meet them; all objects for a view
// that is new or whose light moves. Nothing is drawn here.

#include <span>

#include "light_views/casters.h"
#include "light_views/footprint_index.h"
#include "light_views/view_plan.h"

namespace gnomon::light_views {

/// The changes of a frame, shared by all views.
struct FrameMobility {
    const scene::SceneState& state;
    const Casters& casters;
    std::span<const scene::ObjectId> changed;    // moved, deformed, appeared, vanished, or changed mobility; ascending
    std::span<const scene::ObjectId> dynamics;   // all dynamic objects, ascending
    const std::vector<char>& is_dynamic;         // by object
};

/// Which objects whose shadow textures may have changed a plan lists.
enum class ListedReceivers : std::uint8_t {
    none,
    behind_changes,   // whose footprint meets that of a change, unless they lie completely nearer to the light
    by_footprints     // whose footprint meets that of a change [Oh and Shin 2004, 3.2]
};

class ViewTracker {
 public:
    ViewTracker(int size, std::size_t object_count) : index_(size, object_count) {}

    /// Makes the plan for this frame. Must be called for every frame, or `forget` before the next call.
    /// @param restless   the light moves, so the projection is expected to change again
    void plan(const FrameMobility& frame, const ViewProjection& projection, bool restless, ListedReceivers receivers,
              ViewPlan& plan);
    /// Without coherence: empties the view and draws everything.
    void plan_full_redraw(const FrameMobility& frame, const ViewProjection& projection, ViewPlan& plan);
    /// Call if the buffers are no longer valid (the light was off).
    void forget() { known_ = statics_known_ = false; }

    const ViewProjection& projection() const { return projection_; }
    /// Whether the static buffer is up to date; not while the light moves.
    bool statics_known() const { return statics_known_; }
    const FootprintIndex& index() const { return index_; }
    /// Objects and index entries visited so far.
    std::uint64_t touched() const { return touched_ + index_.touched(); }

 private:
    struct Drawn {
        scene::ObjectId object;
        Rect rect;
        float nearest;   // distance to the light, along the view
        friend bool operator==(const Drawn&, const Drawn&) = default;
    };
    void place_dynamics(const FrameMobility& frame);
    void plan_whole(const FrameMobility& frame, ListedReceivers receivers, ViewPlan& plan);
    void plan_restless(const FrameMobility& frame, ViewPlan& plan);
    void plan_incremental(const FrameMobility& frame, ListedReceivers receivers, ViewPlan& plan);
    bool is_drawn(scene::ObjectId object) const;
    bool affects_view(const FrameMobility& frame) const;

    ViewProjection projection_;
    FootprintIndex index_;                 // static objects; valid if statics_known_
    std::vector<Drawn> drawn_, present_;   // dynamic objects in the rendering buffer, and in this frame; ascending
    std::vector<scene::ObjectId> found_;   // scratch
    bool known_ = false;                   // the rendering buffer holds the last frame with projection_
    bool statics_known_ = false;
    std::uint64_t touched_ = 0;
};

}   // namespace gnomon::light_views
