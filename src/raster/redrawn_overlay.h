// SPDX-License-Identifier: Apache-2.0
#pragma once
// Paints the overlay of redrawn objects: the image in grey, and over it each object that the light views drew in this
// frame, in a colour that says why. Objects whose depths were kept stay grey.
//
// Cost: O(objects + pixels).

#include "light_views/light_views.h"
#include "raster/raster_frame.h"

namespace gnomon::raster {

/// In ascending order: of an object drawn into several views, the highest value counts.
enum class Redrawn : std::uint8_t {
    kept,       // not drawn
    settled,    // green: came to rest, and was drawn into the static depths
    repaired,   // yellow: is static, and was drawn again where an object has left, or because its light changed
    moved       // red: moves, and was drawn on top of the static depths
};

/// Adds what the last update of some views drew.
/// @param objects  by object: the highest value so far
void add_redrawn(const light_views::LightViews& views, std::vector<Redrawn>& objects);

/// Paints over an image in linear light; the result is exposed, within 0 to 1.
/// @param ids       object + 1 of each pixel, 0 for none, and another number
/// @param exposure  in stops, of `color`
void paint_redrawn(const IdImage& ids, const std::vector<Redrawn>& objects, double exposure, ImageF& color);

}   // namespace gnomon::raster
