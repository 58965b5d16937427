// SPDX-License-Identifier: Apache-2.0
#pragma once
// Keeps depth and item buffers seen from all lights up to date [Oh and Shin 2004, 3]: determines which buffers change
// in this frame, where, and which objects must be drawn into them.
//
// update() follows one advance() of the scene's state and stores a plan for every view. An executor carries the plans
// out: the Vulkan one, or the CPU reference in software.h. This component does not depend on either.
//
// Invariants, held by tests: after each frame, the rendering buffer of every view of a visible light equals, bit for
// bit, the one that redrawing everything gives; likewise the static buffer for static objects. Mobility, its hysteresis
// and user overrides affect the work that is done, but never the rendering buffers. Cost: see ViewTracker; `touched`
// counts. Where overrides take objects outside of the scene's bounds, all views are drawn anew.

#include "light_views/atlas.h"
#include "light_views/view_tracker.h"
#include "scene/mobility.h"

namespace gnomon::light_views {

struct LightViewsOptions {
    ProjectionOptions projection;
    AtlasOptions atlas;
    int quiet_frames = 8;         // frames at rest after which an object is static
    bool coherence = true;        // false: everything is redrawn in every frame, for comparison
    bool receivers = false;       // also list objects whose shadow textures change
    bool by_footprints = false;   // those nearer to the light than a change, too, as published; for comparison
    bool of_surfaces = true;      // false: lights that approximate surfaces (Light::of_surface) have no views
    bool of_environment = true;   // false: nor have those that approximate an environment image
    bool directional = true;      // false: nor have other directional lights
};

/// The lights whose views are kept, at the current time.
struct ViewedLights {
    std::span<const scene::Light> lights;
    std::span<const scene::LightState> states;   // by light
    std::span<const scene::LightId> moved;       // since the last update, ascending; as FrameChanges::lights_moved
    std::span<const scene::LightId> started;     // those of `moved` that rested before
};

/// One square of the atlas: the view of a spot or directional light, or one face of a point light.
struct LightView {
    scene::LightId light = scene::none;
    int face = 0;
    Tile tile;
    bool shown = false;          // the light is on, and the buffers are valid once this frame's plan is carried out
    ViewProjection projection;   // valid if shown
    ViewPlan plan;               // for this frame
};

struct LightViewsCounts {   // of the last update
    std::uint64_t draws = 0, copies = 0;
    std::uint64_t copied_texels = 0;
    std::uint64_t views_changed = 0;
    std::uint64_t touched = 0;   // objects and index entries visited
};

class LightViews {
 public:
    /// Makes no plans yet. Keeps a reference to the state's scene, but not to the state.
    /// @throws MissingError  more lights than the atlas's budget holds
    explicit LightViews(const scene::SceneState& state, const LightViewsOptions& options = {});
    /// The same for lights that are not the scene's, as places on surfaces. Their number must stay.
    LightViews(const scene::SceneState& state, const ViewedLights& lights, const LightViewsOptions& options);

    /// Makes the plans for the current state. Call once after every advance(); the first call plans complete redraws.
    /// @throws MissingError  other bounds, or a wider cone, need more views than the atlas's budget holds
    void update(const scene::SceneState& state);
    void update(const scene::SceneState& state, const ViewedLights& lights);
    /// Call if the buffers were lost: the next update plans complete redraws.
    void forget();

    /// Overrides the mobility of an object, or removes the override. Takes effect with the next update.
    void set_override(scene::ObjectId object, scene::MobilityOverride value);

    const LightViewsOptions& options() const { return options_; }
    const Atlas& atlas() const { return atlas_; }
    /// Counts the updates that laid out the views anew, because lights have other numbers of views: buffers made for
    /// the atlas before are void.
    std::uint32_t layout_version() const { return layout_version_; }
    const std::vector<LightView>& views() const { return views_; }
    /// The index in views() of a light's first view; its other views follow.
    std::uint32_t first_view(scene::LightId light) const { return atlas_.first_tile[light]; }
    const ViewTracker& tracker(std::size_t view) const { return trackers_[view]; }
    const SceneBounds& bounds() const { return bounds_; }
    const Casters& casters() const { return casters_; }
    bool is_dynamic(scene::ObjectId object) const { return is_dynamic_[object] != 0; }
    std::size_t object_count() const { return is_dynamic_.size(); }
    const LightViewsCounts& counts() const { return counts_; }

 private:
    ViewedLights lights_of(const scene::SceneState& state);
    int views_of(const scene::Light& light) const;
    void lay_out(const ViewedLights& lights);
    void follow_bounds(const scene::SceneState& state, const ViewedLights& lights);
    void note_changes(const scene::SceneState& state);
    void note_mobility(scene::ObjectId object);

    LightViewsOptions options_;
    Casters casters_;
    SceneBounds bounds_;
    Atlas atlas_;
    scene::Mobility mobility_;
    std::vector<LightView> views_;
    std::vector<ViewTracker> trackers_;
    std::vector<char> is_dynamic_;
    std::vector<scene::ObjectId> changed_, dynamics_, overridden_;
    std::vector<scene::LightState> light_states_;   // of the scene's lights
    bool first_ = true;                             // all projections are to be computed
    std::uint32_t layout_version_ = 0;
    std::uint64_t touched_before_ = 0;
    LightViewsCounts counts_;
};

}   // namespace gnomon::light_views
