// SPDX-License-Identifier: Apache-2.0
#pragma once
// Remembers what rays found at points of static surfaces: which of the cells that are open for the point's part it sees
// past static geometry, and which parts of cells. A point that was not asked for in a frame is forgotten after it.
//
// For one thread at a time. Cost: a look-up per point. Memory: 56 bytes a point, two bits for each open cell, or for
// each cell where more than half are open, and 16 bytes for each cell that was divided.

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "environment_light/cell_proofs.h"
#include "visibility/shadow_point.h"

namespace gnomon::environment_light {

/// What rays found in the parts of a cell (part_directions.h).
struct KnownParts {
    std::uint32_t leaf = 0;
    std::uint64_t seen = 0;   // a bit for each part
};

class PointMemory {
 public:
    struct Known {
        const PartMasks* masks = nullptr;   // null: the point is unknown
        std::uint32_t cells = 0;            // which cells they are of: as add() said
        // Whether rays went to a cell, and whether they left the scene: a bit for each open cell, in their order; or
        // for each cell (has_all_bits()).
        const std::uint64_t *traced = nullptr, *seen = nullptr;
        std::span<const KnownParts> parts;   // by leaf, rising
    };
    /// Whether points of a part have a bit for each cell, because more than half of its cells are open.
    static bool has_all_bits(const PartMasks& masks)
    {
        std::size_t open = 0;
        for (const std::uint64_t word : masks.open) open += static_cast<std::size_t>(std::popcount(word));
        return 2 * open > 64 * masks.open.size();
    }
    /// Points that were not asked for since the last call are forgotten.
    void begin_frame();
    /// Valid until the next add() or begin_frame().
    Known find(const visibility::ShadowPoint& point);
    /// @param cells  a number of theirs
    /// @param bits   as in Known: words of those that were traced, then as many of those seen
    /// @param parts  by leaf, rising
    void add(const visibility::ShadowPoint& point, const PartMasks& masks, std::uint32_t cells,
             const std::vector<std::uint64_t>& bits, std::span<const KnownParts> parts);
    void forget() { now_ = {}, before_ = {}; }
    std::size_t bytes() const { return now_.bytes() + before_.bytes(); }

 private:
    struct Key {
        std::uint64_t triangle = 0, place = 0;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct Entry {
        Key key;
        const PartMasks* masks = nullptr;   // null: no entry
        std::uint32_t first = 0, words = 0;
        std::uint32_t cells = 0;
        std::uint32_t first_part = 0, parts = 0;
    };
    struct Table {
        std::vector<Entry> entries;   // a power of two, or none
        std::vector<std::uint64_t> seen;
        std::vector<KnownParts> parts;
        std::size_t count = 0;
        std::size_t bytes() const
        {
            return entries.capacity() * sizeof(Entry) + seen.capacity() * sizeof(std::uint64_t) +
                   parts.capacity() * sizeof(KnownParts);
        }
        const Entry* find(const Key& key) const;
        void add(const Entry& entry, const std::uint64_t* words, const KnownParts* first_part);
    };
    static Key key_of(const visibility::ShadowPoint& point);

    Table now_, before_;
};

}   // namespace gnomon::environment_light
