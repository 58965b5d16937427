// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shadow test of shadow culling [Nah 2009, 2.4, Table 2]: decides which shadow rays are not traced, or only against
// dynamic objects.
//
// Cost: one look-up per shadow ray. The decision is a heuristic without proof: it misses a shadow that fell between the
// pixels of the frames in which the primitive was seen, and points of it that were never shaded.

#include "shadow_culling/nah2009/modes.h"

namespace gnomon::shadow_culling {

enum class ShadowDecision : std::uint8_t {
    full_traversal,   // trace against everything, and note the result
    dynamic_only,     // trace against dynamic objects only
    in_shadow,        // no ray: the point is in shadow
    lit,              // no ray: NON_SHADOW while nothing is dynamic (PaperCulling decides so, not Table 2)
};

/// Why a ray is traced against everything: what Table 2 found at its origin.
enum class FullReason : std::uint8_t {
    dynamic,              // the primitive is dynamic
    partially_occluded,   // it was hidden in part, or cut off by the screen, when it was seen last
    not_seen,             // no primary ray met it before, or it was reset after a zoom-in
    partly_shadowed,      // seen whole, PARTIAL_SHADOW
    not_shadowed,         // seen whole, but no ray of this light was traced from it before
};
inline constexpr std::size_t k_full_reasons = 5;

/// @param origin  the primitive that the shadow ray leaves: of any hit, not only of primary rays
inline ShadowDecision test_shadow(const Modes& modes, PrimitiveId origin, int light)
{
    // Do not trust a primitive that was never seen whole.
    if (modes.occlusion(origin) != OcclusionMode::fully_rendered) return ShadowDecision::full_traversal;

    switch (modes.shadow(origin, light)) {
        case ShadowMode::full_shadow:
            // DEVIATION(Nah 2009, Table 2): the listing sets hitResult = false here; the text treats the ray as
            // intersected, and in shadow is right.
            return ShadowDecision::in_shadow;
        case ShadowMode::non_shadow:
            return ShadowDecision::dynamic_only;
        case ShadowMode::init:
        case ShadowMode::partial_shadow:
            break;
    }
    return ShadowDecision::full_traversal;
}

}   // namespace gnomon::shadow_culling
