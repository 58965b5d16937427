// SPDX-License-Identifier: Apache-2.0
#pragma once
// What patches receive of the light of dynamic objects, for several patches at once (Highway). Same bytes on every
// processor: no sum runs over the lanes of a vector.

#include "irradiance_cache/light_tree/light_tree.h"

namespace gnomon::irradiance_cache {

/// A run of patches as a structure of arrays. Values past `count` are 0.
struct PatchRows {
    static constexpr std::size_t k_most = 512;
    std::size_t count = 0;
    alignas(64) float sample[3][k_most]{};     // places for which visibility is tested
    alignas(64) float normal[3][k_most]{};     // unit
    alignas(64) float albedo[k_most]{};        // luminance of the reflectance
    alignas(64) float already[k_most]{};       // luminance of the exitance that static light gives
    alignas(64) float received[3][k_most]{};   // irradiance, to which the kernel adds
};

/// Adds a light's irradiance at those patches at which nobody sees whether it is occluded: they reflect less of it than
/// a fraction of what they give already, and the light's halves need not stand for it.
/// @param untested  that fraction
/// @param tested    gets the others that face the light, in ascending order; room for rows.count
/// @return how many these are
std::size_t receive_untested(PatchRows& rows, const DynamicVirtualLight& light, float untested, std::uint16_t* tested);

}   // namespace gnomon::irradiance_cache
