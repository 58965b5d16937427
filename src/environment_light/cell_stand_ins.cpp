// SPDX-License-Identifier: Apache-2.0
// Points for which a coarse answer will do: a few cells stand in for all (cell_visibility.h).
#include "environment_light/cell_query.h"

namespace gnomon::environment_light {

// Takes each cell to be as the one that stands in for it, and wants it where that lies below the surface.
void CellVisibility::follow_stand_ins(const Query& query, std::size_t k) const
{
    const auto above = query.of(query.scratch.above, k), wanted = query.of(query.scratch.wanted, k);
    const auto mask = query.seen.of(k);
    for (const StoodFor& cells : cells_.stood_for()) {
        const bool asked = has(above, cells.stand_in), sees = has(mask, cells.stand_in);
        for_each_word(cells.first, cells.leaves, [&](std::size_t w, std::uint64_t bits) {
            bits &= above[w];
            if (!asked)
                wanted[w] |= bits;
            else
                mask[w] = sees ? mask[w] | bits : mask[w] & ~bits;
        });
    }
}

// Leaves of the wanted cells those that stand in for others, and those whose stand-in lies below the surface.
void CellVisibility::leave_stand_ins(const Query& query, std::size_t k) const
{
    const auto above = query.of(query.scratch.above, k), wanted = query.of(query.scratch.wanted, k);
    for_each_bit(wanted, [&](std::size_t leaf) {
        const std::size_t stand_in = cells_.stand_in_of(leaf);
        if (stand_in != leaf && has(above, stand_in)) wanted[leaf / 64] &= ~(std::uint64_t{1} << (leaf % 64));
    });
}

// Takes away the cells whose stand-ins were found hidden.
void CellVisibility::follow_hidden(const Query& query, std::size_t k) const
{
    const auto above = query.of(query.scratch.above, k);
    const auto mask = query.seen.of(k);
    for_each_bit(mask, [&](std::size_t leaf) {
        const std::size_t stand_in = cells_.stand_in_of(leaf);
        if (has(above, stand_in) && !has(mask, stand_in)) mask[leaf / 64] &= ~(std::uint64_t{1} << (leaf % 64));
    });
}

}   // namespace gnomon::environment_light
