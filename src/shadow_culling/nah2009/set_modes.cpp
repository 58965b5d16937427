// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/nah2009/set_modes.h"

namespace gnomon::shadow_culling {

ShadowMode shadow_bits(StaticPart static_part, bool dynamic_occluded, const SetModesOptions& options)
{
    if (options.remember_dynamic_blockers)
        return dynamic_occluded || static_part == StaticPart::occluded ? ShadowMode::full_shadow
                                                                       : ShadowMode::non_shadow;

    // DEVIATION(Nah 2009, Table 3): the coherence claimed is that of static on static. Only the effect of a static
    // occluder, or the absence of one, is remembered; Table 3 sets FULL_SHADOW for any occluder.
    switch (static_part) {
        case StaticPart::occluded:
            return ShadowMode::full_shadow;
        case StaticPart::free:
            return ShadowMode::non_shadow;
        case StaticPart::unknown:
            break;
    }
    return ShadowMode::init;
}

OcclusionMode occlusion_after(OcclusionMode begun, OcclusionMode marked, std::uint32_t pixels,
                              std::uint32_t most_pixels, const SetModesOptions& options)
{
    if (marked != OcclusionMode::init) return marked;

    switch (begun) {
        case OcclusionMode::init:
            // It was rendered, and never found occluded.
            return OcclusionMode::fully_rendered;
        case OcclusionMode::fully_rendered:
            // After a zoom-in, shadows that were smaller than a pixel may become visible. The shadow bits stay: the
            // next frame traces everything, and new results turn FULL_SHADOW or NON_SHADOW into PARTIAL_SHADOW.
            // DEVIATION(Nah 2009, 2.2): there a zoom-in resets any mode; 2.6 resets only FULLY_RENDERED, as is done
            // here.
            return std::uint64_t{pixels} > std::uint64_t{options.zoom_in} * most_pixels ? OcclusionMode::init : begun;
        case OcclusionMode::partially_occluded:
        case OcclusionMode::dynamic:
            break;
    }
    return begun;
}

}   // namespace gnomon::shadow_culling
