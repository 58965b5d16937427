// SPDX-License-Identifier: Apache-2.0
#pragma once
// Adds the direct light of lights with size to the points of the traced frame.
//
// For each light and point: the unshadowed contribution in closed form (shading/polygon_light.h), times the visible
// share (sized_visibility.h; few_places.h where the light is dim beside an environment image).
//
// A light is counted once. A smooth surface shows it in the ray that it reflects, and draws no highlight of it; a rough
// one draws a highlight, and its reflected ray does not see emission. In between, both are blended by roughness. A coat
// does the same for its part of the ray, by its own roughness.

#include <functional>
#include <optional>

#include "shading/between_horizons.h"
#include "shading/polygon_light.h"
#include "trace/few_places.h"
#include "trace/passing_light.h"
#include "trace/sized_visibility.h"

namespace gnomon::trace {

/// The share of the highlights of lights with size in a surface's reflection of them: 0 where reflected rays show
/// emissive surfaces, 1 where the glossy lobe reflects the lights instead.
float highlight_share(const shading::SurfacePoint& s);
/// The share of an environment image that a surface's lobe reflects, likewise: of metals, from smoother ones on.
float image_share(const shading::SurfacePoint& s);
/// The same of the coat of a layered surface; 0 without.
float coat_highlight_share(const shading::SurfacePoint& s);

/// One per thread.
class SizedLighting {
 public:
    SizedLighting(const scene::SizedLights& lights, SizedVisibility& visibility, const ray::RayScene& rays)
        : lights_(lights), visibility_(visibility.make_worker()), rays_(rays), few_(lights, rays), passing_(rays)
    {
    }
    /// Calls add(point, radiance) with the light reflected at points of the batch towards the viewer, throughput left
    /// out; light by light.
    /// @param image  by point: the luminance that it reflects of an environment image; empty: there is none
    void light(const PointBatch& batch, std::span<const float> image, const AddReflected& add);
    /// To places of dim lights; others are counted by the worker.
    std::uint64_t few_rays() const { return few_.rays_traced(); }
    std::unique_ptr<SizedVisibility::Worker> take_worker() { return std::move(visibility_); }

 private:
    const scene::SizedLights& lights_;
    std::unique_ptr<SizedVisibility::Worker> visibility_;
    const ray::RayScene& rays_;
    FewPlaces few_;
    PassingLight passing_;
    // By point of the batch.
    std::vector<float> highlight_, coat_highlight_;
    std::vector<std::optional<shading::PolygonLobe>> lobes_, coat_lobes_;   // where the shares above are not 0
    // A light as a point sees it: the surface, and its coat.
    struct Arriving {
        shading::UnshadowedLight base;
        glm::vec3 coat{0};   // radiance that the coat's lobe reflects
        bool any() const
        {
            return base.irradiance != glm::vec3(0) || base.lobe != glm::vec3(0) || coat != glm::vec3(0);
        }
    };
    struct Asked {
        std::uint32_t point = 0;
        Arriving arrives;
    };
    glm::vec3 reflected(const PointBatch& batch, std::uint32_t point, const Arriving& light) const;
    glm::vec3 by_lobes(std::uint32_t point, const Arriving& light) const;
    Arriving seen_of(const PointBatch& batch, const scene::SizedLight& light, const Asked& asked,
                     std::span<const scene::SizedPlace> places, std::span<const std::uint8_t> seen, int whole) const;
    void add_seen(const PointBatch& batch, const scene::SizedLight& light, const Asked& asked, Arriving seen,
                  const AddReflected& add);

    // Points that the present light could reach, by visibility; those between the horizons of smooth meshes apart.
    std::vector<Asked> fine_, dim_, between_;
    shading::SeenBetween between_seen_;
    std::vector<std::uint32_t> points_;   // of fine_
    SizedVisible visible_;
};

}   // namespace gnomon::trace
