// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sparse receivers of an image: the surfaces seen at every so many pixels, where light is gathered and between
// which it is interpolated [Ki and Oh 2007, 3.3].

#include "light_quadtree/map_light.h"
#include "scene/view.h"

namespace gnomon::trace {

struct IndirectGrid {
    std::vector<light_quadtree::MapReceiver> receivers;   // row by row, from pixel (0, 0) on
    int columns = 0;
};

/// Casts one ray at every step-th pixel, and one beyond the image's last in each row and column.
IndirectGrid cast_indirect_grid(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view, int step,
                                Tasks& tasks);

}   // namespace gnomon::trace
