// SPDX-License-Identifier: Apache-2.0
#pragma once
// Allocates the views of all lights in one atlas, within a budget.
//
// The layout depends on the lights of the scene only. It is made once, so no light ever loses its place to another. If
// the views do not fit at the requested size, lights get smaller squares (halved from the last light to the first), but
// never none. Cost: O(views log views), once.

#include <span>
#include <vector>

#include "light_views/rect.h"

namespace gnomon::light_views {

struct AtlasOptions {
    int view_size = 1024;                   // requested texels a side, a power of two; faces of a cube get half of it
    int least_size = 32;                    // texels a side to which a view may be reduced
    std::int64_t budget_texels = 1 << 24;   // of all views together
};

/// A square within a page. Pages are squares of side `Atlas::page_size`.
struct Tile {
    int page = 0, x = 0, y = 0, size = 0;
    Rect rect() const { return {x, y, x + size, y + size}; }
};

struct Atlas {
    int page_size = 0, pages = 0;
    std::vector<std::uint32_t> first_tile;   // by light; with one more entry at the end
    std::vector<Tile> tiles;                 // views of light 0, of light 1, ...
    std::int64_t texels() const;
};

/// @param views  number of views of each light: 0, 1, 2, 5 or 6
/// @throws MissingError  the budget is too small even for squares of the least size
Atlas make_atlas(std::span<const int> views, const AtlasOptions& options);

}   // namespace gnomon::light_views
