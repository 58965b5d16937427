// SPDX-License-Identifier: Apache-2.0
// The layout of a record's states in memory, and how records get finer.
#include <algorithm>
#include <cstring>

#include "shadow_culling/certified/shadow_memory.h"

namespace gnomon::shadow_culling {

namespace {

// The states that finer parts inherit: the decided ones, of every light. Two bits per light; 11 is PARTIAL.
constexpr std::uint8_t decided_of(std::uint8_t states)
{
    const unsigned partial = states & (static_cast<unsigned>(states) >> 1) & 0x55u;
    return static_cast<std::uint8_t>(states & ~(partial * 3));
}

// The enclosing part `levels` above, and the part's position relative to it.
MicroTriangle around(const MicroTriangle& part, std::uint32_t levels)
{
    const std::uint32_t n = 1u << levels;
    const std::uint32_t i = part.i & (n - 1), j = part.j & (n - 1);
    return {part.i >> levels, part.j >> levels, i + j + part.upper >= n ? 1u : 0u};
}
MicroTriangle within(const MicroTriangle& around, const MicroTriangle& part, std::uint32_t levels)
{
    if (!around.upper) return {part.i - (around.i << levels), part.j - (around.j << levels), part.upper};
    return {((around.i + 1) << levels) - 1 - part.i, ((around.j + 1) << levels) - 1 - part.j, 1 - part.upper};
}
// The inverse: from relative to absolute.
MicroTriangle out_of(const MicroTriangle& around, const MicroTriangle& part, std::uint32_t levels)
{
    if (!around.upper) return {part.i + (around.i << levels), part.j + (around.j << levels), part.upper};
    return {((around.i + 1) << levels) - 1 - part.i, ((around.j + 1) << levels) - 1 - part.j, 1 - part.upper};
}

constexpr std::uint32_t pieces_at(std::uint32_t level)
{
    return 1u << (2 * (level - k_piece_levels));
}
// The address of the states of the upper levels, after the table.
constexpr std::uint32_t states_begin(std::uint32_t level)
{
    return static_cast<std::uint32_t>(sizeof(std::uint32_t)) * pieces_at(level);
}

}   // namespace

ShadowMemory::Shape ShadowMemory::shape_of(RecordId id) const
{
    const Record& record = records_[id];
    const std::uint32_t begin = record.begin.load(std::memory_order_relaxed);
    Shape shape{begin, record.level, record.open != 0};
    if (shape.open && !shape.in_pieces()) shape.base -= pyramid_offset(shape.level);
    return shape;
}

std::uint32_t ShadowMemory::entry(const Shape& shape, std::uint32_t piece) const
{
    std::uint32_t value;
    std::memcpy(&value, states_[0].get() + shape.base + sizeof value * piece, sizeof value);
    return value;
}

void ShadowMemory::set_entry(const Shape& shape, std::uint32_t piece, std::uint32_t value)
{
    std::memcpy(states_[0].get() + shape.base + sizeof value * piece, &value, sizeof value);
}

std::uint32_t ShadowMemory::address_in(const Shape& shape, const MicroTriangle& part, std::uint32_t at_level) const
{
    if (!shape.open) return shape.base;
    if (!shape.in_pieces()) return shape.base + pyramid_offset(at_level) + micro_index(part, at_level);
    const std::uint32_t above = shape.level - k_piece_levels;
    if (at_level <= above)
        return shape.base + states_begin(shape.level) + pyramid_offset(at_level) + micro_index(part, at_level);
    const std::uint32_t below = at_level - above;
    const MicroTriangle top = around(part, below);
    const std::uint32_t begin = entry(shape, micro_index(top, above));
    if (!(begin & k_has_piece)) return begin;
    return (begin & ~k_has_piece) - pyramid_offset(k_piece_levels) + pyramid_offset(below) +
           micro_index(within(top, part, below), below);
}

std::uint32_t ShadowMemory::address(RecordId id, const MicroTriangle& part, std::uint32_t at_level) const
{
    return address_in(shape_of(id), part, at_level);
}

bool ShadowMemory::is_open(RecordId id, const MicroTriangle& part, std::uint32_t at_level) const
{
    const Shape shape = shape_of(id);
    if (!shape.open || at_level == shape.level) return false;
    if (!shape.in_pieces() || at_level != shape.level - k_piece_levels) return true;
    return (entry(shape, micro_index(part, at_level)) & k_has_piece) != 0;
}

// Allocates a part's piece, and fills all its levels with the decided states of the part.
bool ShadowMemory::add_piece(const Shape& shape, std::uint32_t piece)
{
    const std::uint32_t base = allocate(k_piece_levels);
    if (base == k_no_slot) return false;
    const std::uint32_t above = shape.level - k_piece_levels;
    const std::uint32_t part = shape.base + states_begin(shape.level) + pyramid_offset(above) + piece;
    for (const Block& block : states_)
        std::memset(block.get() + base, decided_of(block.get()[part]), pyramid_size(k_piece_levels));
    set_entry(shape, piece, (base + pyramid_offset(k_piece_levels)) | k_has_piece);
    return true;
}

bool ShadowMemory::open(RecordId id, const MicroTriangle& part, std::uint32_t at_level)
{
    if (is_open(id, part, at_level)) return true;
    Record& record = records_[id];
    const Shape shape = shape_of(id);
    if (shape.open) return add_piece(shape, micro_index(part, at_level));

    const Shape opened{allocate(shape.level), shape.level, true};
    if (opened.base == k_no_slot) return false;
    hand_down(shape, opened);
    release(shape);
    record.open = true;
    record.begin.store(opened.begin(), std::memory_order_relaxed);
    return true;
}

// Copies a record's states to a new, finer layout. Parts that were PARTIAL at the finest level are unknown below.
void ShadowMemory::hand_down(const Shape& from, const Shape& to)
{
    const std::uint32_t kept = from.open ? from.level : 0;   // levels that `from` has
    const std::uint32_t above = to.in_pieces() ? to.level - k_piece_levels : to.level;
    for (std::uint32_t k = 0; k <= above; ++k)
        for (std::uint32_t i = 0; i < 1u << (2 * k); ++i) {
            const MicroTriangle part = micro_at(i, k);
            const std::uint32_t at = address_in(to, part, k);
            const std::uint32_t source = k <= kept ? address_in(from, part, k) : address_in(to, parent_of(part), k - 1);
            for (const Block& block : states_) {
                const std::uint8_t states = block.get()[source];
                block.get()[at] = k <= kept ? states : decided_of(states);
            }
        }
    if (!to.in_pieces()) return;
    for (std::uint32_t piece = 0; piece < pieces_at(to.level); ++piece) {
        set_entry(to, piece, to.base + states_begin(to.level) + pyramid_offset(above) + piece);
        hand_piece_down(from, to, piece);
    }
}

void ShadowMemory::hand_piece_down(const Shape& from, const Shape& to, std::uint32_t piece)
{
    const std::uint32_t above = to.level - k_piece_levels;
    const std::uint32_t kept = from.open ? std::min(from.level, to.level) : 0;
    const MicroTriangle top = micro_at(piece, above);
    const std::uint32_t own = to.base + states_begin(to.level) + pyramid_offset(above) + piece;
    // Copy all levels of the piece, by group, beginning with the part itself.
    std::uint8_t states[pyramid_size(k_piece_levels)];
    bool added = false;
    for (const Block& group : states_) {
        std::uint8_t* const block = group.get();
        bool differs = decided_of(block[own]) != block[own];
        states[0] = block[own];
        for (std::uint32_t k = 1; k <= k_piece_levels; ++k)
            for (std::uint32_t i = 0; i < 1u << (2 * k); ++i) {
                const MicroTriangle part = micro_at(i, k);
                std::uint8_t& state = states[pyramid_offset(k) + i];
                state = above + k <= kept
                            ? block[address_in(from, out_of(top, part, k), above + k)]
                            : decided_of(states[pyramid_offset(k - 1) + micro_index(parent_of(part), k - 1)]);
                differs = differs || state != block[own];
            }
        if (!differs && !added) continue;
        if (!added) {
            added = add_piece(to, piece);
            if (!added) {   // memory is full: PARTIAL parts here become unknown
                for (const Block& each : states_) each.get()[own] = decided_of(each.get()[own]);
                return;
            }
        }
        const std::uint32_t begin = (entry(to, piece) & ~k_has_piece) - pyramid_offset(k_piece_levels);
        std::memcpy(block + begin, states, sizeof states);
    }
}

bool ShadowMemory::deepen(RecordId id, std::uint32_t level)
{
    Record& record = records_[id];
    level = std::min(level, k_max_level);
    if (!has(id) || level <= record.level) return false;
    const Shape shape = shape_of(id);
    const bool partial = std::any_of(states_.begin(), states_.end(), [&](const Block& block) {
        const std::uint8_t root = block.get()[address_in(shape, {}, 0)];
        return decided_of(root) != root;
    });
    Shape deeper{shape.base, level, shape.open};
    if (shape.open || partial) {
        deeper = {allocate(level), level, true};
        if (deeper.base == k_no_slot) return false;
        hand_down(shape, deeper);
        release(shape);
    }
    take_evidence(id);
    record.level = static_cast<std::uint8_t>(level) & 0x7f;
    record.open = deeper.open;
    record.begin.store(deeper.begin(), std::memory_order_relaxed);
    return true;
}

void ShadowMemory::release(const Shape& shape)
{
    if (shape.in_pieces())
        for (std::uint32_t piece = 0; piece < pieces_at(shape.level); ++piece)
            if (const std::uint32_t at = entry(shape, piece); at & k_has_piece)
                release((at & ~k_has_piece) - pyramid_offset(k_piece_levels), k_piece_levels);
    release(shape.base, shape.open ? shape.level : 0);
}

// Calls `change` for all byte ranges that contain a record's states.
template <class Change>
void ShadowMemory::for_each_range(const Shape& shape, const Change& change) const
{
    if (!shape.in_pieces()) {
        change(shape.base, shape.open ? pyramid_size(shape.level) : 1);
        return;
    }
    change(shape.base + states_begin(shape.level), pyramid_size(shape.level - k_piece_levels));
    for (std::uint32_t piece = 0; piece < pieces_at(shape.level); ++piece)
        if (const std::uint32_t at = entry(shape, piece); at & k_has_piece)
            change((at & ~k_has_piece) - pyramid_offset(k_piece_levels), pyramid_size(k_piece_levels));
}

void ShadowMemory::forget_in(const Shape& shape, int light, bool but_none)
{
    std::uint8_t* const states = states_[static_cast<std::size_t>(light / k_lights_per_group)].get();
    const int shift = 2 * (light % k_lights_per_group);
    for_each_range(shape, [&](std::uint32_t begin, std::uint32_t size) {
        for (std::uint32_t i = begin; i < begin + size; ++i)
            if (!but_none || static_cast<ShadowState>((states[i] >> shift) & 3) != ShadowState::none)
                states[i] &= static_cast<std::uint8_t>(~(3u << shift));
    });
}

}   // namespace gnomon::shadow_culling
