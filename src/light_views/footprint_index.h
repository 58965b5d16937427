// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light-space index: which static objects fall on a rectangle of a light view?
//
// A stack of grids over the view's texels, each with cells half as wide as the one above. An object is kept once, on
// the level whose cells are just as large as its footprint, in the cell of the footprint's corner; a query looks at the
// cells that a footprint touching it can start from, on levels that hold something.
// Cost: insert and erase O(1); a query: the cells under it and the objects around it, whatever else there is
// (`touched` counts entries looked at).

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
    /// Empty if the object is not there.
    Rect rect(scene::ObjectId object) const { return contains(object) ? entries_[entry_[object]].rect : Rect{}; }
    std::size_t count() const { return count_; }

    /// Appends the objects whose footprint meets `rect`, in no particular order, each once.
    void query(const Rect& rect, std::vector<scene::ObjectId>& found) const;
    /// Appends all.
    void all(std::vector<scene::ObjectId>& found) const;

    /// Entries that queries have looked at since construction.
    std::uint64_t touched() const { return touched_; }

 private:
    struct Entry {
        Rect rect;
        scene::ObjectId object = scene::none;
        std::uint32_t next = scene::none, previous = scene::none, cell = 0;   // of the cell's list
    };
    struct Level {
        int cell = 0, side = 0;         // texels of a cell, cells a side
        std::uint32_t first_cell = 0;   // in heads_
        std::uint32_t count = 0;        // objects
    };
    Level& level_of(const Rect& rect);

    std::vector<Level> levels_;          // finest first
    std::vector<std::uint32_t> heads_;   // by cell: the first entry, or none
    std::vector<Entry> entries_;
    std::vector<std::uint32_t> free_;
    std::vector<std::uint32_t> entry_;   // by object
    std::size_t count_ = 0;
    mutable std::uint64_t touched_ = 0;
};

}   // namespace gnomon::light_views
