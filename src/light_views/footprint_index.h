// SPDX-License-Identifier: Apache-2.0
#pragma once
// A spatial index in light space: finds the static objects whose footprints meet a rectangle of a light view.
//
// It is a stack of grids over the view's texels, each with cells half as wide as the one above. An object is stored
// once, on the level whose cells are just large enough for its footprint, in the cell of the footprint's corner. On
// each level that is not empty, a query visits the cells in which a footprint that meets the rectangle can start. Cost:
// insert and erase O(1); a query: linear in the cells and objects near the rectangle, independent of all others
// (`touched` counts visited entries).

#include <cstdint>
#include <vector>

#include "light_views/rect.h"
#include "scene/ids.h"

namespace gnomon::light_views {

class FootprintIndex {
 public:
    /// @param size  texels a side; a power of two
    FootprintIndex(int size, std::size_t object_count);

    void clear();
    /// @param rect  not empty, inside the view; the object must not be in the index
    void insert(scene::ObjectId object, const Rect& rect);
    void erase(scene::ObjectId object);
    bool contains(scene::ObjectId object) const { return entry_[object] != scene::none; }
    /// Empty if the object is not in the index.
    Rect rect(scene::ObjectId object) const { return contains(object) ? entries_[entry_[object]].rect : Rect{}; }
    std::size_t count() const { return count_; }

    /// Appends each object whose footprint meets `rect` once, in no particular order.
    void query(const Rect& rect, std::vector<scene::ObjectId>& found) const;
    /// Appends all objects.
    void all(std::vector<scene::ObjectId>& found) const;

    /// Entries visited by queries since construction.
    std::uint64_t touched() const { return touched_; }

 private:
    struct Entry {
        Rect rect;
        scene::ObjectId object = scene::none;
        std::uint32_t next = scene::none, previous = scene::none, cell = 0;   // links of the cell's list
    };
    struct Level {
        int cell = 0, side = 0;         // texels per cell side, cells per grid side
        std::uint32_t first_cell = 0;   // index in heads_
        std::uint32_t count = 0;        // objects
    };
    Level& level_of(const Rect& rect);

    std::vector<Level> levels_;          // finest first
    std::vector<std::uint32_t> heads_;   // by cell: the first entry, or none
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> entry_;   // by object: index in entries_
    std::size_t count_ = 0;
    mutable std::uint64_t touched_ = 0;
};

}   // namespace gnomon::light_views
