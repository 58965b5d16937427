// SPDX-License-Identifier: Apache-2.0
#pragma once
// The state of a frame that all steps of the irradiance cache read.

#include "irradiance_cache/cache_options.h"
#include "irradiance_cache/near_field/near_field.h"
#include "irradiance_cache/points/anchors.h"
#include "irradiance_cache/points/rough_light.h"
#include "irradiance_cache/points/sky_light.h"
#include "irradiance_cache/points/triangle_clusters.h"
#include "irradiance_cache/ray_budget.h"

namespace gnomon::irradiance_cache {

/// References to the cache's parts, and the numbers of the current frame. The steps read them; of what they refer to,
/// the clusters, the hints of the near field and the budget are thread-safe and may change.
struct CacheFrame {
    const CacheOptions& options;
    const LightTree& lights;
    const MovingSpheres& dynamic_bounds;   // spheres that enclose the dynamic objects
    const SkyLight& sky;
    const SkyLight& sky_of_parts;   // from fewer directions, for parts of static objects
    const TriangleNumbers& triangles;
    TriangleClusters& clusters;
    NearField& near_field;
    RayBudget& budget;
    const RoughLight& rough;   // if rays are limited

    const scene::SceneState* state = nullptr;
    const ray::RayScene* rays = nullptr;
    std::uint32_t number = 0;            // counts frames from 1 on
    std::uint32_t dynamic_version = 1;   // counts the frames in which a dynamic object changed

    /// How far a level of detail has faded in: 0 where it begins, 1 from `level_blend` beyond that.
    float fade_in(float beyond) const
    {
        if (beyond >= options.level_blend) return 1;
        const float t = std::max(beyond, 0.0f) / options.level_blend;
        return t * t * (3 - 2 * t);
    }
    /// How much of a part's near field comes from the part itself, where a pixel is so wide, instead of from near-field
    /// points that are a few pixels apart.
    float near_by_parts(float width) const { return fade_in(width / near_field.fade_width() - 1); }
};

}   // namespace gnomon::irradiance_cache
