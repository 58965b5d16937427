// SPDX-License-Identifier: Apache-2.0
#pragma once
// The limits of rays that may be traced, by Embree, by the k-d tree and by the device's pipelines alike.

#include <cmath>

#include "base/volume.h"

namespace gnomon::ray {

/// Whether a ray may be traced; all others hit nothing. A ray with a negative end may not, because Embree marks
/// occluded rays that way.
inline bool traceable(float ox, float oy, float oz, float tnear, float dx, float dy, float dz, float tfar)
{
    // Combine integers instead of booleans, so that the compiler emits no branches and checks whole packets.
    const auto fits = [](float x) { return static_cast<unsigned>(std::abs(x) <= k_largest_coordinate); };   // 0 for NaN
    const auto at_least = [](float x, float least) { return static_cast<unsigned>(x >= least); };
    return (fits(ox) & fits(oy) & fits(oz) & fits(dx) & fits(dy) & fits(dz) & at_least(tnear, 0) &
            at_least(k_infinity, tnear) & at_least(tfar, 0)) != 0;
}

}   // namespace gnomon::ray
