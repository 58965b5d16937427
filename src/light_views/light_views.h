// SPDX-License-Identifier: Apache-2.0
#pragma once
// What all lights of a scene see, kept up to date [Oh and Shin 2004, 3]: which depth buffers change this frame, where,
// and what must be drawn into them.
//
// update() follows one advance() of the scene's state and leaves a plan for every view; an executor (the Vulkan one, or
// the slow twin in software.h) carries the plans out. Nothing here knows how.
//
// Invariants, held by tests: after each frame the rendering buffer of every view of a visible light equals, to the bit,
// the one that drawing everything anew gives; the static buffer likewise, of what is static. Mobility, its hysteresis
// and overrides by hand change what is done, never the rendering buffers.
// Cost: see ViewTracker; `touched` counts.

#include "light_views/atlas.h"
#include "light_views/view_tracker.h"
#include "scene/mobility.h"

namespace gnomon::light_views {

struct LightViewsOptions {
    ProjectionOptions projection;
    AtlasOptions atlas;
    int quiet_frames = 8;     // frames of rest after which an object counts as static
    bool coherence = true;    // false: everything is drawn in every frame, as without this house's second idea
    bool receivers = false;   // list whose shadow textures change, too
};

/// One square of the atlas: a spot or directional light, or a face of a point light.
struct LightView {
    scene::LightId light = scene::none;
    int face = 0;
    Tile tile;
    bool shown = false;          // its light is on, and the buffers are valid after this frame's plan
    ViewProjection projection;   // valid while shown
    ViewPlan plan;               // of this frame
};

struct LightViewsCounts {   // of the last update
    std::uint64_t draws = 0, copies = 0;
    std::uint64_t copied_texels = 0;
    std::uint64_t views_changed = 0;
    std::uint64_t touched = 0;   // objects and index entries looked at
};

class LightViews {
 public:
    /// Plans nothing yet. Keeps a reference to the state's scene, not to the state.
    /// @throws MissingError  more lights than the atlas's budget holds
    explicit LightViews(const scene::SceneState& state, const LightViewsOptions& options = {});

    /// Makes the plans for the state's present. Call once after every advance(); the first call plans everything.
    void update(const scene::SceneState& state);
    /// The buffers were lost: the next update plans everything.
    void forget();

    /// Fixes an object as static or dynamic, or leaves it to its motion again. Takes effect with the next update.
    void set_override(scene::ObjectId object, scene::MobilityOverride value);

    const LightViewsOptions& options() const { return options_; }
    const Atlas& atlas() const { return atlas_; }
    const std::vector<LightView>& views() const { return views_; }
    /// A light's views are views()[first_view(light)] and those after it.
    std::uint32_t first_view(scene::LightId light) const { return atlas_.first_tile[light]; }
    const ViewTracker& tracker(std::size_t view) const { return trackers_[view]; }
    const SceneBounds& bounds() const { return bounds_; }
    const Casters& casters() const { return casters_; }
    bool is_dynamic(scene::ObjectId object) const { return is_dynamic_[object] != 0; }
    std::size_t object_count() const { return is_dynamic_.size(); }
    const LightViewsCounts& counts() const { return counts_; }

 private:
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
    bool first_ = true;
    std::uint64_t touched_before_ = 0;
    LightViewsCounts counts_;
};

}   // namespace gnomon::light_views
