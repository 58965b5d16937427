// SPDX-License-Identifier: Apache-2.0
// Points for which a coarse answer will do: a few cells stand in for all (cell_visibility.h).
#include "environment_light/cell_query.h"

namespace gnomon::environment_light {

namespace {

// A point that sees less than this fraction of the light above it sees little: a cell is much of its light.
constexpr float k_dim = 1 / 4.0f;

// Calls body(row, leaf) for each row of leaves some of which are above a surface, with the one that stands in for them
// there: the first one above it if that of all is not.
template <class Body>
void for_each_row(std::span<const StoodFor> rows, std::span<const std::uint64_t> above, const Body& body)
{
    for (const StoodFor& row : rows) {
        std::size_t leaf = row.stand_in;
        if (!has(above, leaf)) {
            leaf = row.first;
            while (leaf < row.first + row.leaves && !has(above, leaf)) ++leaf;
            if (leaf == row.first + row.leaves) continue;
        }
        body(row, leaf);
    }
}

// Sets or clears leaves of a row.
void set_row(std::span<std::uint64_t> mask, const StoodFor& row, std::span<const std::uint64_t> of, bool value)
{
    for_each_word(row.first, row.leaves, [&](std::size_t w, std::uint64_t bits) {
        mask[w] = value ? mask[w] | (bits & of[w]) : mask[w] & ~bits;
    });
}

}   // namespace

// Decides the cells of coarse points. Those that see little then count as others, which decide all of their cells.
void CellVisibility::decide_coarse(Query& query) const
{
    if (query.rough) return decide_roughly(query);
    Scratch& scratch = query.scratch;
    const auto for_each_point = [&](const auto& body) {
        for (std::size_t k = 0; k < query.count(); ++k)
            if (query.coarse(k)) body(k);
    };
    for_each_point([&](std::size_t k) {
        const auto above = query.of(scratch.above, k), wanted = query.of(scratch.wanted, k);
        for (std::size_t w = 0; w < above.size(); ++w) wanted[w] = above[w] & cells_.stand_ins()[w];
    });
    decide_wanted(query, 0);
    for_each_point([&](std::size_t k) { follow_stand_ins(query, k); });
    decide_wanted(query, 0);
    for_each_point([&](std::size_t k) {
        if (!query.guides[k].unless_dark) return;
        const glm::vec3& normal = query.point(k).normal;
        if (light_of(query.seen.of(k), normal) < k_dim * light_of(query.of(scratch.above, k), normal))
            query.is_coarse[k] = 0;
    });
}

// Decides the cells of rough points.
void CellVisibility::decide_roughly(const Query& query) const
{
    Scratch& scratch = query.scratch;
    for (std::size_t k = query.first; k < query.count(); ++k) {
        const auto wanted = query.of(scratch.wanted, k);
        for_each_row(cells_.few_stood_for(), query.of(scratch.above, k),
                     [&](const StoodFor&, std::size_t leaf) { set(wanted, leaf, true); });
    }
    decide_wanted(query, 0);
    for (std::size_t k = query.first; k < query.count(); ++k) {
        const auto above = query.of(scratch.above, k);
        const auto mask = query.seen.of(k);
        for_each_row(cells_.few_stood_for(), above,
                     [&](const StoodFor& row, std::size_t leaf) { set_row(mask, row, above, has(mask, leaf)); });
    }
}

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
    if (query.rough)
        return for_each_row(cells_.few_stood_for(), above, [&](const StoodFor& row, std::size_t leaf) {
            const bool asks = has(wanted, leaf);
            set_row(wanted, row, above, false);
            set(wanted, leaf, asks);
        });
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
    if (query.rough)
        return for_each_row(cells_.few_stood_for(), above, [&](const StoodFor& row, std::size_t leaf) {
            if (!has(mask, leaf)) set_row(mask, row, above, false);
        });
    for_each_bit(mask, [&](std::size_t leaf) {
        const std::size_t stand_in = cells_.stand_in_of(leaf);
        if (has(above, stand_in) && !has(mask, stand_in)) mask[leaf / 64] &= ~(std::uint64_t{1} << (leaf % 64));
    });
}

}   // namespace gnomon::environment_light
