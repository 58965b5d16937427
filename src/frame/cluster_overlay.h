// SPDX-License-Identifier: Apache-2.0
#pragma once
// Paints the image of --overlay clusters: every lit surface in the colour of its cluster in the light quad-tree. Each
// cluster has one colour, and finer clusters are darker; surfaces outside all light maps are grey. Shapes are drawn by
// the angle between surface and viewer.

#include "base/image.h"
#include "light_quadtree/map_light.h"
#include "scene/view.h"

namespace gnomon::frame {

/// Casts one ray per pixel. Where several lights reach a point, the cluster of the first is shown.
Image8 paint_clusters(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view,
                      const light_quadtree::MapLight& light, Tasks& tasks);

}   // namespace gnomon::frame
