// SPDX-License-Identifier: Apache-2.0
#include "light_views/light_views.h"

#include <algorithm>

namespace gnomon::light_views {

namespace {

bool holds(std::span<const scene::LightId> ascending, scene::LightId light)
{
    return std::binary_search(ascending.begin(), ascending.end(), light);
}

}   // namespace

LightViews::LightViews(const scene::SceneState& state, const LightViewsOptions& options)
    : LightViews(state, {state.scene().lights, {}, {}, {}}, options)
{
}

LightViews::LightViews(const scene::SceneState& state, const ViewedLights& lights, const LightViewsOptions& options)
    : options_(options),
      casters_(state),
      bounds_(state.present_bounds()),
      mobility_(state.scene().objects.size(), options.quiet_frames),
      is_dynamic_(state.scene().objects.size(), 0)
{
    lay_out(lights);
}

ViewedLights LightViews::lights_of(const scene::SceneState& state)
{
    const std::vector<scene::Light>& lights = state.scene().lights;
    light_states_.clear();
    for (scene::LightId l = 0; l < lights.size(); ++l) light_states_.push_back(state.light(l));
    return {lights, light_states_, state.changes().lights_moved, state.changes().lights_started};
}

int LightViews::views_of(const scene::Light& light) const
{
    if (light.of_surface && !options_.of_surfaces) return 0;
    if (light.type == scene::LightType::directional &&
        !(light.of_environment ? options_.of_environment : options_.directional))
        return 0;
    return view_count(light, bounds_, options_.projection);
}

// Makes the atlas and the views of all lights.
void LightViews::lay_out(const ViewedLights& viewed)
{
    const std::span<const scene::Light> lights = viewed.lights;
    std::vector<int> counts;
    for (const scene::Light& light : lights) counts.push_back(views_of(light));
    atlas_ = make_atlas(counts, options_.atlas);
    views_.clear();
    trackers_.clear();
    touched_before_ = 0;
    for (scene::LightId l = 0; l < lights.size(); ++l)
        for (std::uint32_t v = atlas_.first_tile[l]; v < atlas_.first_tile[l + 1]; ++v) {
            LightView view;
            view.light = l;
            view.face = static_cast<int>(v - atlas_.first_tile[l]);
            view.tile = atlas_.tiles[v];
            views_.push_back(std::move(view));
            trackers_.emplace_back(atlas_.tiles[v].size, is_dynamic_.size());
        }
}

// Follows the bounds of the scene, and lights whose cones changed.
void LightViews::follow_bounds(const scene::SceneState& state, const ViewedLights& viewed)
{
    const bool other = !(state.present_bounds() == bounds_);
    if (!other && viewed.moved.empty()) return;
    if (other) {
        bounds_ = state.present_bounds();
        first_ = true;
    }
    const std::span<const scene::Light> lights = viewed.lights;
    for (scene::LightId l = 0; l < lights.size(); ++l) {
        const auto views = static_cast<int>(atlas_.first_tile[l + 1] - atlas_.first_tile[l]);
        if (views == views_of(lights[l])) continue;
        lay_out(viewed);
        ++layout_version_;
        return;
    }
}

void LightViews::set_override(scene::ObjectId object, scene::MobilityOverride value)
{
    mobility_.set_override(object, value);
    overridden_.push_back(object);
}

void LightViews::forget()
{
    for (ViewTracker& tracker : trackers_) tracker.forget();
}

void LightViews::note_mobility(scene::ObjectId object)
{
    const char now = mobility_.is_dynamic(object) ? 1 : 0;
    if (is_dynamic_[object] == now) return;
    is_dynamic_[object] = now;
    changed_.push_back(object);
}

// Lists the objects that changed, and those whose mobility differs from that of the last update.
void LightViews::note_changes(const scene::SceneState& state)
{
    const scene::FrameChanges& changes = state.changes();
    casters_.update(state);
    mobility_.update(changes);
    changed_ = changes.changed;
    for (const scene::ObjectId object : mobility_.became_dynamic()) note_mobility(object);
    for (const scene::ObjectId object : mobility_.became_static()) note_mobility(object);
    for (const scene::ObjectId object : overridden_) note_mobility(object);
    overridden_.clear();
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    dynamics_ = mobility_.dynamic_objects();
    std::sort(dynamics_.begin(), dynamics_.end());
}

void LightViews::update(const scene::SceneState& state)
{
    update(state, lights_of(state));
}

void LightViews::update(const scene::SceneState& state, const ViewedLights& viewed)
{
    follow_bounds(state, viewed);
    note_changes(state);
    const FrameMobility frame{state, casters_, changed_, dynamics_, is_dynamic_};

    counts_ = {};
    counts_.touched = changed_.size() + dynamics_.size();
    std::uint64_t touched = 0;
    // Plan light by light, view by view.
    for (std::size_t v = 0; v < views_.size();) {
        const scene::LightId l = views_[v].light;
        const std::size_t end = atlas_.first_tile[l + 1];
        const scene::LightState& light = viewed.states[l];
        const bool moves = holds(viewed.moved, l);
        const bool was_shown = views_[v].shown;
        if (light.visible && (moves || first_ || !was_shown)) {
            // Compute the light's current projections.
            const auto projections =
                project(viewed.lights[l], light, bounds_, views_[v].tile.size, options_.projection);
            for (std::size_t i = v; i < end; ++i) views_[i].projection = projections[i - v];
        }
        const ListedReceivers listed = !options_.receivers      ? ListedReceivers::none
                                       : options_.by_footprints ? ListedReceivers::by_footprints
                                                                : ListedReceivers::behind_changes;
        const bool restless = moves && !holds(viewed.started, l);
        for (; v < end; ++v) {
            LightView& view = views_[v];
            view.shown = light.visible;
            if (light.visible) {
                if (options_.coherence)
                    trackers_[v].plan(frame, view.projection, restless, listed, view.plan);
                else
                    trackers_[v].plan_full_redraw(frame, view.projection, view.plan);
            } else {
                trackers_[v].forget();
                view.plan.clear();
            }
            // Count the work of the plan.
            if (view.plan.kind != ViewPlan::Kind::idle) ++counts_.views_changed;
            counts_.draws += view.plan.draws();
            counts_.copies += view.plan.copies();
            for (const auto* rects : {&view.plan.erase, &view.plan.rebuild})
                for (const Rect& rect : *rects) counts_.copied_texels += static_cast<std::uint64_t>(rect.area());
            for (const ViewPlan::Settle& settle : view.plan.settle)
                counts_.copied_texels += static_cast<std::uint64_t>(settle.rect.area());
            touched += trackers_[v].touched();
        }
    }
    counts_.touched += touched - touched_before_;
    touched_before_ = touched;
    first_ = false;
}

}   // namespace gnomon::light_views
