// SPDX-License-Identifier: Apache-2.0
#include "light_views/footprint_index.h"

#include <bit>

#include "base/check.h"

namespace gnomon::light_views {

namespace {
constexpr int k_finest_cell = 8;   // texels
}

FootprintIndex::FootprintIndex(int size, std::size_t object_count) : entry_(object_count, scene::none)
{
    GNOMON_CHECK(std::has_single_bit(static_cast<unsigned>(size)));
    std::uint32_t cells = 0;
    for (int cell = std::min(k_finest_cell, size);; cell *= 2) {
        Level level;
        level.cell = cell;
        level.side = size / cell;
        level.first_cell = cells;
        levels_.push_back(level);
        cells += static_cast<std::uint32_t>(level.side * level.side);
        if (cell == size) break;
    }
    heads_.assign(cells, scene::none);
}

void FootprintIndex::clear()
{
    std::fill(heads_.begin(), heads_.end(), scene::none);
    std::fill(entry_.begin(), entry_.end(), scene::none);
    for (Level& level : levels_) level.count = 0;
    entries_.clear();
    free_.clear();
    count_ = 0;
}

FootprintIndex::Level& FootprintIndex::level_of(const Rect& rect)
{
    const int extent = std::max(rect.width(), rect.height());
    std::size_t l = 0;
    while (levels_[l].cell < extent) ++l;
    return levels_[l];
}

void FootprintIndex::insert(scene::ObjectId object, const Rect& rect)
{
    GNOMON_CHECK(!rect.empty() && !contains(object));
    Level& level = level_of(rect);
    ++level.count;
    ++count_;
    std::uint32_t e;
    if (free_.empty()) {
        e = static_cast<std::uint32_t>(entries_.size());
        entries_.emplace_back();
    } else {
        e = free_.back();
        free_.pop_back();
    }
    const auto cell =
        level.first_cell + static_cast<std::uint32_t>(rect.y0 / level.cell * level.side + rect.x0 / level.cell);
    entries_[e] = {rect, object, heads_[cell], scene::none, cell};
    if (heads_[cell] != scene::none) entries_[heads_[cell]].previous = e;
    heads_[cell] = e;
    entry_[object] = e;
}

void FootprintIndex::erase(scene::ObjectId object)
{
    GNOMON_CHECK(contains(object));
    const std::uint32_t e = entry_[object];
    const Entry& entry = entries_[e];
    --level_of(entry.rect).count;
    --count_;
    (entry.previous != scene::none ? entries_[entry.previous].next : heads_[entry.cell]) = entry.next;
    if (entry.next != scene::none) entries_[entry.next].previous = entry.previous;
    entry_[object] = scene::none;
    free_.push_back(e);
}

void FootprintIndex::query(const Rect& rect, std::vector<scene::ObjectId>& found) const
{
    if (rect.empty()) return;
    for (const Level& level : levels_) {
        if (level.count == 0) continue;
        // A footprint on this level is at most one cell wide, so it starts in the cells of the query or in the one
        // before.
        const int x0 = std::max(rect.x0 / level.cell - 1, 0), x1 = std::min((rect.x1 - 1) / level.cell, level.side - 1);
        const int y0 = std::max(rect.y0 / level.cell - 1, 0), y1 = std::min((rect.y1 - 1) / level.cell, level.side - 1);
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x)
                for (std::uint32_t e = heads_[level.first_cell + static_cast<std::uint32_t>(y * level.side + x)];
                     e != scene::none; e = entries_[e].next) {
                    ++touched_;
                    if (entries_[e].rect.overlaps(rect)) found.push_back(entries_[e].object);
                }
    }
}

void FootprintIndex::all(std::vector<scene::ObjectId>& found) const
{
    for (const std::uint32_t head : heads_)
        for (std::uint32_t e = head; e != scene::none; e = entries_[e].next) found.push_back(entries_[e].object);
}

}   // namespace gnomon::light_views
