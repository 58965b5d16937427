// SPDX-License-Identifier: Apache-2.0
#pragma once
// How shadow culling learns: the shadow mode after each traced ray [Nah 2009, 2.5, Table 3], the occlusion mode of each
// rendered primitive when the frame ends [2.6].

#include "shadow_culling/nah2009/modes.h"

namespace gnomon::shadow_culling {

struct SetModesOptions {
    // As Table 3 is printed: a ray that a moving object blocks sets FULL_SHADOW like any other.
    bool remember_dynamic_blockers = false;
    // A primitive that covers more than this times the most pixels it ever had may show shadows that were too small
    // to be seen before [2.2].
    std::uint32_t zoom_in = 4;
};

/// What a traced shadow ray met among the static objects.
enum class StaticPart : std::uint8_t { free, occluded, unknown };

/// Table 3, the bits that a ray traced against everything sets; INIT: none.
/// @param unknown for a ray that ended at a moving object before all static ones were tried
ShadowMode shadow_bits(StaticPart static_part, bool dynamic_occluded, const SetModesOptions& options);

/// 2.6: what the occlusion mode becomes at the end of a frame that rendered the primitive.
/// @param begun        as the frame began
/// @param marked       by the occlusion test: INIT (not at all), PARTIALLY_OCCLUDED or DYNAMIC
/// @param pixels       that show it in this frame
/// @param most_pixels  in any frame before
OcclusionMode occlusion_after(OcclusionMode begun, OcclusionMode marked, std::uint32_t pixels,
                              std::uint32_t most_pixels, const SetModesOptions& options);

}   // namespace gnomon::shadow_culling
