// SPDX-License-Identifier: Apache-2.0
#pragma once
// Keeps one light view's books: where static objects lie in it, where dynamic ones were drawn, and what follows from a
// frame's changes.
//
// Cost a frame: the objects that changed or are dynamic, and the static ones that meet them. A view that is new or
// whose light moves costs all objects, that view alone. Nothing is drawn here.

#include <span>

#include "light_views/casters.h"
#include "light_views/footprint_index.h"
#include "light_views/view_plan.h"

namespace gnomon::light_views {

/// The frame as all views read it.
struct FrameMobility {
    const scene::SceneState& state;
    const Casters& casters;
    std::span<const scene::ObjectId> changed;    // moved, deformed, appeared, vanished or of new mobility; ascending
    std::span<const scene::ObjectId> dynamics;   // all that count as dynamic now, ascending
    const std::vector<char>& is_dynamic;         // by object
};

class ViewTracker {
 public:
    ViewTracker(int size, std::size_t object_count) : index_(size, object_count) {}

    /// Says what to do for this frame. Must be called for every frame, or `forget` be called before the next.
    /// @param restless   the light moves: do not expect the projection to stay
    /// @param receivers  also list whose shadow textures change
    void plan(const FrameMobility& frame, const ViewProjection& projection, bool restless, bool receivers,
              ViewPlan& plan);
    /// Without coherence: empties the view and draws everything in it.
    void plan_anew(const FrameMobility& frame, const ViewProjection& projection, ViewPlan& plan);
    /// The buffers are no longer to be trusted (the light was off).
    void forget() { known_ = statics_known_ = false; }

    const ViewProjection& projection() const { return projection_; }
    /// Whether the static buffer holds what is static now: not while the light moves.
    bool statics_known() const { return statics_known_; }
    const FootprintIndex& index() const { return index_; }
    /// Objects and index entries looked at so far.
    std::uint64_t touched() const { return touched_ + index_.touched(); }

 private:
    struct Drawn {
        scene::ObjectId object;
        Rect rect;
        float nearest;   // to the light, along the view
        friend bool operator==(const Drawn&, const Drawn&) = default;
    };
    void place_dynamics(const FrameMobility& frame);
    void plan_whole(const FrameMobility& frame, bool receivers, ViewPlan& plan);
    void plan_restless(const FrameMobility& frame, ViewPlan& plan);
    void plan_incremental(const FrameMobility& frame, bool receivers, ViewPlan& plan);
    bool is_drawn(scene::ObjectId object) const;
    bool concerned(const FrameMobility& frame) const;

    ViewProjection projection_;
    FootprintIndex index_;                 // static objects; valid with statics_known_
    std::vector<Drawn> drawn_, present_;   // dynamic objects in the rendering buffer, and in this frame; ascending
    std::vector<scene::ObjectId> found_;   // scratch
    bool known_ = false;                   // the rendering buffer holds projection_'s view of the last frame
    bool statics_known_ = false;
    std::uint64_t touched_ = 0;
};

}   // namespace gnomon::light_views
