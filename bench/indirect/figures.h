// SPDX-License-Identifier: Apache-2.0
#pragma once
// Figures 1, 3, 5 and 10 of [Ki and Oh 2007]: a scene in direct and in indirect light, what a light map holds, and
// which of its nodes are valid, level by level.

#include "bench/indirect/report.h"
#include "light_quadtree/light_map.h"

namespace gnomon::bench {

/// What a spot light's map holds [Figure 3], and the validity of its levels [Figure 5], as images.
struct LightMapFigures {
    std::vector<NamedImage> map;        // flux, position, normal, depth
    std::vector<NamedImage> validity;   // finest level first; the paper's level 1 and on
};

/// Casts the light map of the scene's first light at a frame.
LightMapFigures light_map_figures(const std::shared_ptr<const scene::Scene>& scene, int frame,
                                  const light_quadtree::LightMapOptions& options, Tasks& tasks);

/// The frame lit directly, indirectly, and by both, with one exposure [Figures 1 and 10].
std::vector<NamedImage> light_figures(const IndirectStudy& study, const std::vector<glm::vec3>& irradiance);

}   // namespace gnomon::bench
