// SPDX-License-Identifier: Apache-2.0
#pragma once
// One atlas for the views of all lights, within a budget.
//
// The layout depends on the lights of the scene alone: it is made once, no light ever loses its place to another, and
// nothing can thrash. Lights that do not fit at the wanted size get smaller squares (the last ones first, by halves),
// never none.
// Cost: O(views log views), once.

#include <span>
#include <vector>

#include "light_views/rect.h"

namespace gnomon::light_views {

struct AtlasOptions {
    int view_size = 1024;                   // wanted texels a side, a power of two; faces of a cube get half of it
    int least_size = 32;                    // what a light may be cut down to
    std::int64_t budget_texels = 1 << 24;   // of all views together
};

/// A square of a page. Pages are squares of `Atlas::page_size`.
struct Tile {
    int page = 0, x = 0, y = 0, size = 0;
    Rect rect() const { return {x, y, x + size, y + size}; }
};

struct Atlas {
    int page_size = 0, pages = 0;
    std::vector<std::uint32_t> first_tile;   // by light; one more entry than lights
    std::vector<Tile> tiles;                 // views of light 0, of light 1, ...
    std::int64_t texels() const;
};

/// @param views  of each light: 1, 2 or 6
/// @throws MissingError  if the budget does not even hold squares of the least size
Atlas make_atlas(std::span<const int> views, const AtlasOptions& options);

}   // namespace gnomon::light_views
