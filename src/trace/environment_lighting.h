// SPDX-License-Identifier: Apache-2.0
#pragma once
// Adds the direct light of the environment image, and of directional lights with a size, to the points of the traced
// frame (environment_light/).
//
// Diffuse: the irradiance from all visible directions. Glossy: as with other lights with size (sized_lighting.h), a
// smooth surface shows the image in the ray that it reflects; the lobe of a rough one sees it blurred, times the
// visible share, and its reflected ray does not see it; in between, both are blended by roughness. A surface with rays
// of its lobe (shading/lobe_rays.h) shows the image where these meet nothing, each with the mean radiance of what the
// lobe sees of the image: what is hidden and what hides it are then one estimate. Points that rays of
// lobes meet share places (shared_places.h). What points in mirrors and glass see is interpolated between places
// (place_lattice.h) where these see nearly as much light as each other.
//
// Of a sun, a point reflects the light of its middle times the visible share; its highlight is wider by the disc.

#include <functional>
#include <memory>
#include <vector>

#include "environment_light/environment_light.h"
#include "trace/passing_light.h"
#include "trace/place_lattice.h"
#include "trace/point_batch.h"
#include "trace/shared_places.h"

namespace gnomon::trace {

/// The environment of a frame, with what points of its tiles remember. It outlives frames: make one for a scene state,
/// and let it follow.
class EnvironmentTechnique {
 public:
    explicit EnvironmentTechnique(const environment_light::EnvironmentOptions& options = {}) : light_(options) {}

    /// After the state advanced and the ray scene followed. The state must be the one of the call before, or one that
    /// continues it.
    void begin_frame(const FrameContext& frame, std::size_t tiles);
    bool empty() const { return light_.empty(); }
    PlaceMemory& shared_places() { return shared_places_; }
    PlaceGroups& place_groups() { return place_groups_; }
    const environment_light::EnvironmentLight& light() const { return light_; }
    /// What points of a tile remember; null in the first frame, because a single image has no use for it.
    /// @param sun  in EnvironmentLight::suns(); -1: of the image
    environment_light::PointMemory* memory(std::size_t tile, int sun = -1)
    {
        return remembers_ ? &memories_[tile][static_cast<std::size_t>(sun) + 1] : nullptr;
    }
    /// Whether points see their cells roughly in the frames that begin from now on, by some 40 rays each.
    void be_rough(bool rough) { rough_ = rough; }
    bool rough() const { return rough_; }
    /// Points remember from the first frame on.
    void remember_first() { remembers_ = begun_ = true; }
    /// Every direction of a sun is traced from every point, and reflected by itself: the reference.
    bool every_ray() const { return every_ray_; }
    /// For the reference: suns alone.
    static std::unique_ptr<EnvironmentTechnique> of_every_ray(double sun_diameter);
    std::size_t bytes() const;

    /// Of the last frame.
    const environment_light::VisibilityCounters& counters() const { return counters_; }
    void set_counters(const environment_light::VisibilityCounters& counters) { counters_ = counters; }

 private:
    environment_light::EnvironmentLight light_;
    std::vector<std::vector<environment_light::PointMemory>> memories_;   // by tile: of the image, of each sun
    PlaceMemory shared_places_;
    PlaceGroups place_groups_;
    std::shared_ptr<const scene::Environment> image_;   // of which shared places know what they see
    std::uint32_t version_ = 0, suns_version_ = 0;
    bool every_ray_ = false;
    bool rough_ = false, was_rough_ = false;   // this frame, and the last one
    bool begun_ = false, remembers_ = false;   // whether a frame was begun; whether it is not the first
    environment_light::VisibilityCounters counters_;
};

/// One per thread.
class EnvironmentLighting {
 public:
    EnvironmentLighting(EnvironmentTechnique& technique, const ray::RayScene& rays)
        : technique_(technique), rays_(rays), passing_(rays), lattice_(rays), places_(rays, &technique.place_groups())
    {
    }
    /// Calls add(point, radiance, by_lobe) with the light reflected at points of the batch towards the viewer, and with
    /// the part of it that lobes reflect, throughput left out.
    /// @param tile  its number in the frame
    void light(const PointBatch& batch, std::size_t tile, const AddReflected& add)
    {
        light_some(batch, tile, 0, batch.points.size(), add);
    }
    /// The same for the points [first, end). Only of first hits; those before `first` are those of calls just before,
    /// and may guide these. Of points after `end`, some may follow.
    void light_some(const PointBatch& batch, std::size_t tile, std::size_t first, std::size_t end,
                    const AddReflected& add);
    /// Of the last call of light(), by point of the batch: the luminance of the radiance that it added.
    std::span<const float> reflected() const { return reflected_; }
    struct ByLobe {
        float share = 0;     // what the lobe showed of the image, as a share of what it reflects by itself
        glm::vec3 open{0};   // mean radiance that its rays show of the image where they meet nothing
    };
    /// Likewise.
    std::span<const ByLobe> by_lobes() const { return by_lobes_; }
    /// Likewise: the share of the hemisphere, by cosine, that surfaces fill, at most. 1 where that is not known,
    /// because the point was not asked for diffuse light, or because surfaces let light through that they also reflect.
    std::span<const float> hidden() const { return hidden_; }
    /// The same with the light of suns. Also gives the light and its visible share.
    void light_by_suns(const PointBatch& batch, std::size_t tile, const scene::SceneState& state,
                       const std::function<void(const TilePoint&, const glm::vec3&, scene::LightId, float)>& add);
    bool has_image() const { return !technique_.empty(); }
    /// Of the image, on a surface that sees everything above it. @pre has_image()
    glm::vec3 open_irradiance(const glm::vec3& normal) const { return technique_.light().light().irradiance(normal); }
    bool has_sun(scene::LightId light) const;
    environment_light::VisibilityCounters counters() const
    {
        environment_light::VisibilityCounters sum = scratch_.counters;
        sum.add(own_scratch_.counters);
        return sum;
    }

 private:
    static bool may_reflect(const TilePoint& point);
    environment_light::Guides guides_of(const PointBatch& batch, std::span<const std::uint32_t> points, std::uint32_t k,
                                        std::size_t answered, int step, int pass) const;
    void find_guides(const PointBatch& batch, std::span<const std::uint32_t> points, std::size_t answered);
    void find_guides_of_moving(const PointBatch& batch, std::span<const std::uint32_t> points);
    void find_seen(const PointBatch& batch, std::size_t tile, std::size_t before);
    void find_passing(const PointBatch& batch, std::size_t before);
    void find_shared();
    bool is_between(std::size_t k) const;
    void see_between(const PlaceLattice::Around& around);
    glm::vec3 reflect_sun(const environment_light::Sun& sun, const shading::SurfacePoint& surface,
                          const glm::vec3& to_light, const glm::vec3& color, std::span<const std::uint64_t> seen,
                          float share) const;

    EnvironmentTechnique& technique_;
    const ray::RayScene& rays_;
    PassingLight passing_;
    PlaceLattice lattice_;
    environment_light::SeenCells lattice_seen_;
    std::vector<environment_light::FromCells> lattice_light_;   // by place
    std::vector<glm::vec3> lattice_passes_;                     // likewise; empty: nothing thins light
    SharedPlaces places_;
    std::vector<glm::vec3> own_passes_;          // by place of one point; only where something thins light
    std::vector<PlaceMemory::Place*> shared_;    // by shared place
    std::vector<std::uint32_t> claimed_;         // indices of shared places
    std::deque<PlaceMemory::Place> abandoned_;   // stand in for places that another thread abandoned
    environment_light::SeenCells shared_seen_;
    environment_light::CellVisibility::Scratch scratch_,
        own_scratch_;   // the latter of points with places of their own
    environment_light::SeenCells seen_;
    std::vector<float> reflected_;
    std::vector<ByLobe> by_lobes_;
    std::vector<float> hidden_;
    std::vector<std::uint32_t> asked_;          // points that could reflect light
    std::vector<std::uint32_t> follow_;         // of points that may follow, those that could
    std::vector<std::uint32_t> apart_;          // of these, those that are not between places
    std::vector<std::uint32_t> apart_at_;       // by asked point: its index there; k_between
    std::vector<std::uint64_t> between_mask_;   // what one point sees by the places around it
    std::vector<environment_light::PartialCell> between_partial_;
    std::vector<std::uint32_t> between_leaves_;
    std::vector<std::uint32_t> asked_places_;                // all places
    std::vector<environment_light::Guides> guides_;          // by asked place or point; empty: none has any
    std::vector<environment_light::Guides> moving_guides_;   // likewise, for what moves
    std::vector<std::uint32_t> asked_of_pixel_;
    std::vector<std::uint64_t> smooth_seen_;   // of one point of a smooth mesh
    // Points to which a sun's disc is partly behind the triangle, but not behind the smooth horizon.
    std::vector<std::uint32_t> between_, between_asked_;
    std::vector<visibility::ShadowPoint> between_points_;
    environment_light::SeenCells between_seen_;
};

}   // namespace gnomon::trace
