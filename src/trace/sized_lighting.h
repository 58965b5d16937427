// SPDX-License-Identifier: Apache-2.0
#pragma once
// Adds the direct light of lights with size to the points of the traced frame.
//
// For each light and point: the unshadowed contribution in closed form (shading/polygon_light.h), times the visible
// share (sized_visibility.h).
//
// A light is counted once. A smooth surface shows it in the ray that it reflects, and draws no highlight of it; a rough
// one draws a highlight, and its reflected ray does not see emission. In between, both are blended by roughness.

#include <functional>

#include "shading/between_horizons.h"
#include "shading/polygon_light.h"
#include "trace/passing_light.h"
#include "trace/sized_visibility.h"

namespace gnomon::trace {

/// The share of the highlights of lights with size in a surface's reflection of them: 0 where reflected rays show
/// emissive surfaces, 1 where the glossy lobe reflects the lights instead.
float highlight_share(const shading::SurfacePoint& s);

/// One per thread.
class SizedLighting {
 public:
    SizedLighting(const scene::SizedLights& lights, SizedVisibility& visibility, const ray::RayScene& rays)
        : lights_(lights), visibility_(visibility.make_worker()), rays_(rays), passing_(rays)
    {
    }
    /// Calls add(point, radiance) with the light reflected at points of the batch towards the viewer, throughput left
    /// out; light by light.
    void light(const PointBatch& batch, const std::function<void(const TilePoint&, const glm::vec3&)>& add);
    std::unique_ptr<SizedVisibility::Worker> take_worker() { return std::move(visibility_); }

 private:
    struct Arriving {
        std::uint32_t point;
        shading::UnshadowedLight light;
    };
    glm::vec3 reflect(const TilePoint& point, float highlight, const shading::UnshadowedLight& light) const;

    const scene::SizedLights& lights_;
    std::unique_ptr<SizedVisibility::Worker> visibility_;
    const ray::RayScene& rays_;
    PassingLight passing_;
    std::vector<float> highlight_;                    // by point of the batch
    std::vector<std::uint32_t> asked_;                // points that the present light could reach
    std::vector<shading::UnshadowedLight> arrives_;   // by asked point
    SizedVisible visible_;
    // Points of smooth meshes to which a part of the present light is behind the triangle, and what they see.
    std::vector<Arriving> between_;
    shading::SeenBetween between_seen_;
};

}   // namespace gnomon::trace
