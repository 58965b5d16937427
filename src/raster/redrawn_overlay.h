// SPDX-License-Identifier: Apache-2.0
#pragma once
// The overlay of what was redrawn: the image in grey, and each object in the colour of what the light views did with
// it in this frame. Grey: nothing; its depths were kept.
//
// Cost: O(objects + pixels).

#include "light_views/light_views.h"
#include "raster/raster_frame.h"

namespace gnomon::raster {

/// In ascending order of what counts where an object was drawn into several views.
enum class Redrawn : std::uint8_t {
    kept,       // not drawn
    settled,    // green: has come to rest, and was drawn to stay
    repaired,   // yellow: stands still, and was drawn again where something has left, or because its light changed
    moved       // red: moves, and was drawn on top of what stands still
};

/// By object, of the views' last update.
std::vector<Redrawn> redrawn_objects(const light_views::LightViews& views);

/// Paints over an image in linear light, as it is to be shown: exposed, within 0 to 1.
/// @param ids       object + 1 of each pixel, 0 for none, and another number
/// @param exposure  in stops, of `color`
void paint_redrawn(const IdImage& ids, const std::vector<Redrawn>& objects, double exposure, ImageF& color);

}   // namespace gnomon::raster
