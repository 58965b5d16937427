// SPDX-License-Identifier: Apache-2.0
#pragma once
// The checks that make remembered shadows correct, one by one, so that tests can leave one out and see the errors.
//
// Checks with a number (margin, clearance, ...) are options of their own (certificates.h). Only tests leave checks out.
// Cost: a bit test per certificate; none per look-up.

#include <cstdint>

namespace gnomon::visibility {

enum class Check : std::uint8_t {
    // NONE
    nothing_in_shaft,   // no static triangle intersects the shaft
    masked_blocks,      // alpha-tested triangles count as occluders
    // FULL
    opaque_occluder,    // the first triangle of a patch is opaque
    opaque_neighbour,   // so are all others of the patch
    same_bits,          // shared edges are equal to the bit, not nearly
    occluder_in_way,    // the first triangle lies in the shaft
    no_open_edge,       // every edge in the shaft has a second triangle,
    no_silhouette,      // which lies, seen from the light, on the other side of the edge
    // Changes
    dynamic_tested,          // NONE covers static geometry only; dynamic objects are tested
    light_moves,             // nothing is remembered for a moving light
    light_stops,             // memory of a light that stopped starts empty
    promoted_not_receiver,   // a promoted object is not a remembered receiver,
    promoted_not_occluder,   // nor an occluder in new certificates
    promoted_shadow_gone,    // what it may have shadowed is judged again
};

/// A set of checks to leave out; empty except in tests.
struct LeftOut {
    std::uint32_t bits = 0;
    constexpr LeftOut() = default;
    constexpr LeftOut(Check check) : bits(1u << static_cast<unsigned>(check)) {}   // NOLINT: a set of one
    constexpr LeftOut operator|(LeftOut other) const
    {
        LeftOut both;
        both.bits = bits | other.bits;
        return both;
    }
    constexpr bool has(Check check) const { return (bits >> static_cast<unsigned>(check)) & 1; }
};

}   // namespace gnomon::visibility
