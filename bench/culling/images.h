// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images of wrong shadows: the primary hits in direct light with every ray traced and with the published method.

#include "base/image.h"
#include "bench/culling/counts.h"

namespace gnomon::bench {

/// Renders the frame's direct light without reflections, with every ray traced and with the published method. In the
/// third image every pixel in which the result of a light differs is red and the others are faded. All are in sRGB with
/// the same exposure.
WrongImages wrong_images(const scene::SceneState& state, Size size, const std::vector<CullingTile>& tiles,
                         const CullingFrame& frame);

}   // namespace gnomon::bench
