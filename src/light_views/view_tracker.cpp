// SPDX-License-Identifier: Apache-2.0
#include "light_views/view_tracker.h"

#include <algorithm>

namespace gnomon::light_views {

namespace {

void sort_unique(std::vector<scene::ObjectId>& ids)
{
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

bool holds(std::span<const scene::ObjectId> ascending, scene::ObjectId object)
{
    return std::binary_search(ascending.begin(), ascending.end(), object);
}

// Erases the whole view if the rectangles together are larger, because that is cheaper.
void join_if_larger(std::vector<Rect>& rects, const Rect& whole)
{
    std::int64_t area = 0;
    for (const Rect& rect : rects) area += rect.area();
    if (area >= whole.area()) rects.assign(1, whole);
}

// A rectangle in which something changed, and the least distance of the change from the light.
// DEVIATION(Oh and Shin 2004, 3.2): the texture of an object that lies nearer is kept. By footprints alone, nearly
// twice as many textures would be redrawn in a scene as dense as the paper's.
struct Change {
    Rect rect;
    float nearest;
};

// Joins rectangles that overlap so much that drawing into their union costs no more. Quadratic, so only for short
// lists.
void join_overlapping(std::vector<Rect>& rects)
{
    constexpr std::size_t k_short = 64;
    if (rects.size() > k_short) return;
    for (std::size_t i = 0; i < rects.size();) {
        bool grown = false;
        for (std::size_t j = i + 1; j < rects.size();) {
            const Rect both = around(rects[i], rects[j]);
            if (both.area() <= rects[i].area() + rects[j].area()) {
                rects[i] = both;
                rects[j] = rects.back();
                rects.pop_back();
                grown = true;
            } else {
                ++j;
            }
        }
        if (!grown) ++i;
    }
}

}   // namespace

void ViewTracker::plan(const FrameMobility& frame, const ViewProjection& projection, bool restless,
                       ListedReceivers receivers, ViewPlan& plan)
{
    plan.clear();
    if (!known_ || !projection_.same_bits(projection)) {
        projection_ = projection;
        statics_known_ = false;
        if (known_ && restless) {
            plan_restless(frame, plan);
        } else {
            place_dynamics(frame);
            plan_whole(frame, receivers, plan);
        }
        known_ = true;
        return;
    }
    place_dynamics(frame);
    if (statics_known_)
        plan_incremental(frame, receivers, plan);
    else if (affects_view(frame))   // a light that has come to rest: its static buffer is made when it is first needed
        plan_whole(frame, receivers, plan);
}

void ViewTracker::plan_full_redraw(const FrameMobility& frame, const ViewProjection& projection, ViewPlan& plan)
{
    plan.clear();
    projection_ = projection;
    known_ = statics_known_ = false;
    plan_restless(frame, plan);
}

// Computes the footprints of dynamic objects.
void ViewTracker::place_dynamics(const FrameMobility& frame)
{
    present_.clear();
    for (const scene::ObjectId object : frame.dynamics) {
        const Rect rect = frame.casters.footprint(projection_, frame.state, object);
        if (!rect.empty())
            present_.push_back({object, rect, frame.casters.distance(projection_, frame.state, object).nearest});
    }
    touched_ += frame.dynamics.size();
}

bool ViewTracker::is_drawn(scene::ObjectId object) const
{
    const auto at = std::lower_bound(drawn_.begin(), drawn_.end(), object,
                                     [](const Drawn& d, scene::ObjectId o) { return d.object < o; });
    return at != drawn_.end() && at->object == object;
}

// Whether anything that changed is or was in view. After a restless frame, drawn_ holds every object.
bool ViewTracker::affects_view(const FrameMobility& frame) const
{
    for (const scene::ObjectId object : frame.changed) {
        if (!frame.casters.footprint(projection_, frame.state, object).empty()) return true;
        if (is_drawn(object)) return true;
    }
    return false;
}

void ViewTracker::plan_restless(const FrameMobility& frame, ViewPlan& plan)
{
    plan.kind = ViewPlan::Kind::restless;
    drawn_.clear();
    const auto count = static_cast<scene::ObjectId>(frame.is_dynamic.size());
    for (scene::ObjectId object = 0; object < count; ++object) {
        const Rect rect = frame.casters.footprint(projection_, frame.state, object);
        if (rect.empty()) continue;
        drawn_.push_back({object, rect, -k_infinity});
        plan.dynamics.push_back(object);
    }
    plan.receivers = plan.dynamics;
    touched_ += count;
}

void ViewTracker::plan_whole(const FrameMobility& frame, ListedReceivers receivers, ViewPlan& plan)
{
    plan.kind = ViewPlan::Kind::whole;
    index_.clear();
    plan.rebuild.push_back(projection_.whole());
    const auto count = static_cast<scene::ObjectId>(frame.is_dynamic.size());
    for (scene::ObjectId object = 0; object < count; ++object) {
        if (frame.is_dynamic[object]) continue;
        const Rect rect = frame.casters.footprint(projection_, frame.state, object);
        if (rect.empty()) continue;
        index_.insert(object, rect);
        plan.redraw.push_back({object, 0});
    }
    for (const Drawn& drawn : present_) plan.dynamics.push_back(drawn.object);
    if (receivers != ListedReceivers::none) {
        for (const ViewPlan::Redraw& redraw : plan.redraw) plan.receivers.push_back(redraw.object);
        plan.receivers.insert(plan.receivers.end(), plan.dynamics.begin(), plan.dynamics.end());
        std::sort(plan.receivers.begin(), plan.receivers.end());
    }
    std::swap(drawn_, present_);
    statics_known_ = true;
    touched_ += count;
}

void ViewTracker::plan_incremental(const FrameMobility& frame, ListedReceivers receivers, ViewPlan& plan)
{
    // Classify changes of static objects: objects that left their place (SD), and objects that came to rest (DS).
    for (const scene::ObjectId object : frame.changed) {
        ++touched_;
        const bool was_static = index_.contains(object);
        if (was_static) {
            plan.rebuild.push_back(index_.rect(object));
            index_.erase(object);
        }
        const Rect rect = frame.casters.footprint(projection_, frame.state, object);
        if (receivers != ListedReceivers::none && rect.empty() && (was_static || is_drawn(object)))
            plan.departed.push_back(object);
        if (!frame.is_dynamic[object] && !rect.empty()) plan.settle.push_back({object, rect});
    }

    // Determine whether any dynamic object came, went, or changed within its footprint.
    bool moved = drawn_ != present_;
    for (std::size_t i = 0; !moved && i < present_.size(); ++i) moved = holds(frame.changed, present_[i].object);
    if (!moved && plan.rebuild.empty() && plan.settle.empty()) return;
    plan.kind = ViewPlan::Kind::incremental;

    // List where depths may differ from the last frame's, to find the textures to redraw.
    std::vector<Change> dirty;
    if (receivers != ListedReceivers::none) {
        for (const Rect& rect : plan.rebuild) dirty.push_back({rect, -k_infinity});
        for (const ViewPlan::Settle& settle : plan.settle)
            dirty.push_back({settle.rect, frame.casters.distance(projection_, frame.state, settle.object).nearest});
        const auto changes = [&](const Drawn& d) {
            if (holds(frame.changed, d.object)) dirty.push_back({d.rect, d.nearest});
        };
        for (const Drawn& d : drawn_) changes(d);
        for (const Drawn& d : present_) changes(d);
    }

    // Erase the dynamic objects of the last frame.
    for (const Drawn& drawn : drawn_) plan.erase.push_back(drawn.rect);
    join_if_larger(plan.erase, projection_.whole());

    // Rebuild the rectangles that static objects left, with the static objects that meet them.
    join_overlapping(plan.rebuild);
    join_if_larger(plan.rebuild, projection_.whole());
    for (std::size_t r = 0; r < plan.rebuild.size(); ++r) {
        found_.clear();
        index_.query(plan.rebuild[r], found_);
        sort_unique(found_);
        for (const scene::ObjectId object : found_) plan.redraw.push_back({object, static_cast<std::uint32_t>(r)});
    }

    // Add objects that came to rest, and draw dynamic objects.
    for (const ViewPlan::Settle& settle : plan.settle) index_.insert(settle.object, settle.rect);
    for (const Drawn& drawn : present_) plan.dynamics.push_back(drawn.object);

    if (receivers != ListedReceivers::none) {
        plan.receivers = plan.dynamics;
        for (const Change& change : dirty) {
            found_.clear();
            index_.query(change.rect, found_);
            for (const scene::ObjectId object : found_)
                if (receivers == ListedReceivers::by_footprints ||
                    frame.casters.distance(projection_, frame.state, object).farthest >= change.nearest)
                    plan.receivers.push_back(object);
        }
        sort_unique(plan.receivers);
    }
    std::swap(drawn_, present_);
}

}   // namespace gnomon::light_views
