// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sparse receivers of an image: what the view sees at every so many pixels, for light that is gathered there and
// interpolated between [Ki and Oh 2007, 3.3].

#include "gnomon/renderer.h"
#include "irradiance_cache/irradiance_cache.h"
#include "light_quadtree/map_light.h"
#include "scene/view.h"

namespace gnomon::trace {

struct IndirectGrid {
    std::vector<light_quadtree::MapReceiver> receivers;   // row by row, from pixel (0, 0) on
    int columns = 0;
};

/// Of Indirect::rsm and Indirect::quadtree.
light_quadtree::MapLightOptions map_light_options(const RenderOptions& options);
/// Of Indirect::visible.
irradiance_cache::CacheOptions visible_light_options(const RenderOptions& options);

/// Casts one ray at every step-th pixel, and one beyond the image's last in each row and column.
IndirectGrid cast_indirect_grid(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view, int step,
                                Tasks& tasks);

}   // namespace gnomon::trace
