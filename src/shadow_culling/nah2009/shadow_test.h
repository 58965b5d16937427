// SPDX-License-Identifier: Apache-2.0
#pragma once
// The shadow test of shadow culling [Nah 2009, 2.4, Table 2]: which shadow rays need not be traced, or not whole.
//
// Cost: one look-up a shadow ray. What it saves rests on hope, not proof: a shadow that falls between the pixels of
// the frames in which the primitive was seen is missed, and so are points of it that were never shaded.

#include "shadow_culling/nah2009/modes.h"

namespace gnomon::shadow_culling {

enum class ShadowDecision : std::uint8_t {
    full_traversal,   // trace against everything, and note what the ray met
    dynamic_only,     // trace against what moves alone
    in_shadow,        // no ray: the point is in shadow
};

/// @param origin  the primitive that the shadow ray leaves; that of any ray's hit, not of primary rays alone
inline ShadowDecision test_shadow(const Modes& modes, PrimitiveId origin, int light)
{
    // What was never seen whole is not trusted.
    if (modes.occlusion(origin) != OcclusionMode::fully_rendered) return ShadowDecision::full_traversal;

    switch (modes.shadow(origin, light)) {
        case ShadowMode::full_shadow:
            // DEVIATION(Nah 2009, Table 2): the listing sets hitResult = false here; the text takes the ray as
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
