// SPDX-License-Identifier: Apache-2.0
#pragma once
// A view as the rasteriser's passes take it: culling planes, the clip transform, and the constants of a frame.

#include "raster/gbuffer.h"
#include "raster/raster_shared.h"
#include "scene/state.h"
#include "scene/view.h"

namespace gnomon::raster {

/// Planes of a view that point inwards, for culling: left, right, bottom, top, near, far.
void frustum_planes(const scene::View& view, glm::vec4 (&planes)[6]);

/// The transform from a point's offset from the eye to clip space, with reversed depth: 1 at the near plane, 0 far
/// away.
/// @param sample  place in the pixel, in [0, 1)^2
/// @param unlimited_far  where an orthographic view without a far plane ends
shared::DrawPush draw_push(const scene::View& view, const glm::vec2& sample, float unlimited_far);

/// @param stand_in  ambient light stands in for bounced light
/// @param further   a sky's own colour stands in for light of further bounces
/// @param apart     as RasterOptions::backdrop_apart
/// @param surroundings  that light the frame; may be null
shared::RasterFrame frame_constants(const scene::Scene& scene, const scene::View& view, bool stand_in, bool further,
                                    bool apart, const SurroundingLight* surroundings);

}   // namespace gnomon::raster
