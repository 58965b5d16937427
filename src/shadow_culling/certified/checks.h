// SPDX-License-Identifier: Apache-2.0
#pragma once
// What remembered shadows rest on, check by check, so that tests can leave one out and see what goes wrong.
//
// Checks that are a number (margin, clearance, ...) are options of their own (certificates.h). Nothing but a test has a
// reason to leave one out. Cost: a test of a bit where a certificate is made, none where a shadow is looked up.

#include <cstdint>

namespace gnomon::shadow_culling {

enum class Check : std::uint8_t {
    // NONE
    nothing_in_shaft,   // no static triangle meets the shaft
    masked_blocks,      // alpha-tested triangles count as being there
    // FULL
    opaque_occluder,    // the first triangle of a patch lets no light through
    opaque_neighbour,   // nor do those that the patch goes on to
    same_bits,          // edges are shared to the bit, not nearly
    occluder_in_way,    // the first triangle lies in the shaft
    no_open_edge,       // an edge in the shaft has another triangle behind it
    no_silhouette,      // which goes on, seen from the light, on the other side
    // What moves
    dynamic_tested,          // NONE is about static geometry alone
    light_moves,             // nothing is remembered of a light that moves
    light_stops,             // which starts afresh when it stands still
    promoted_not_receiver,   // a static object moved by hand is no remembered receiver
    promoted_not_occluder,   // nor an occluder in new certificates
    promoted_shadow_gone,    // what it may have shadowed is judged again
};

/// A set of checks to leave out; empty for everybody but tests.
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

}   // namespace gnomon::shadow_culling
