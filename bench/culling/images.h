// SPDX-License-Identifier: Apache-2.0
#pragma once
// Images of what a method that guesses got wrong: primary hits in their lights' light, as traced and as remembered.

#include "base/image.h"
#include "bench/culling/counts.h"

namespace gnomon::bench {

/// The frame's direct light without reflections, every ray traced and by the published method; and the former faded,
/// with every pixel red where a light's result differs. All in sRGB, equally exposed.
WrongImages wrong_images(const scene::SceneState& state, Size size, const std::vector<CullingTile>& tiles,
                         const CullingFrame& frame);

}   // namespace gnomon::bench
