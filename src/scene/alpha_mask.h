// SPDX-License-Identifier: Apache-2.0
#pragma once
// Holes in surfaces of AlphaMode::mask.

#include "scene/scene.h"

namespace gnomon::scene {

/// glTF's alpha mask: whether a masked surface has a hole at (1-u-v) p0 + u p1 + v p2, that is, whether the product of
/// the alphas of texture, factor and vertex colour is below the cutoff.
bool cut_away(const Scene& scene, const Mesh& mesh, const Material& material, std::uint32_t triangle, float u, float v);

}   // namespace gnomon::scene
