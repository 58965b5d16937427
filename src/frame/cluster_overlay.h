// SPDX-License-Identifier: Apache-2.0
#pragma once
// The image of --overlay clusters: every lit surface in the colour of the cluster that it belongs to in the light's
// tree, one colour a cluster, the darker the finer; grey where no light map reaches. Shapes come from how far a surface
// faces the viewer.

#include "base/image.h"
#include "light_quadtree/map_light.h"
#include "scene/view.h"

namespace gnomon::frame {

/// Casts a ray a pixel. Where several lights reach a point, the first shows.
Image8 paint_clusters(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view,
                      const light_quadtree::MapLight& light, Tasks& tasks);

}   // namespace gnomon::frame
