// SPDX-License-Identifier: Apache-2.0
#pragma once
// Sets the modes of shadow culling: the shadow mode after each traced ray [Nah 2009, 2.5, Table 3], and the occlusion
// mode of each rendered primitive at the end of the frame [2.6].

#include "shadow_culling/nah2009/modes.h"

namespace gnomon::shadow_culling {

struct SetModesOptions {
    // As printed in Table 3: a ray that a dynamic object occludes sets FULL_SHADOW like any other.
    bool remember_dynamic_blockers = false;
    // A primitive that covers more than so many times its former maximum of pixels may show shadows that were too small
    // to be seen before [2.2].
    std::uint32_t zoom_in = 4;
    // As printed in 2.6: PARTIALLY_OCCLUDED stays for ever.
    bool partially_occluded_stays = false;
};

/// The result of a traced shadow ray among the static objects.
enum class StaticPart : std::uint8_t { free, occluded, unknown };

/// The bits that a ray traced against everything sets [Table 3]; INIT: none.
/// @param unknown for a ray that ended at a moving object before all static ones were tried
ShadowMode shadow_bits(StaticPart static_part, bool dynamic_occluded, const SetModesOptions& options);

/// The occlusion mode of a primitive at the end of a frame that rendered it [2.6].
/// @param begun        the mode at the beginning of the frame
/// @param marked       by the occlusion test: INIT (not at all), PARTIALLY_OCCLUDED or DYNAMIC
/// @param pixels       that show it in this frame
/// @param most_pixels  in any frame before
OcclusionMode occlusion_after(OcclusionMode begun, OcclusionMode marked, std::uint32_t pixels,
                              std::uint32_t most_pixels, const SetModesOptions& options);

}   // namespace gnomon::shadow_culling
