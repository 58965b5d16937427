// SPDX-License-Identifier: Apache-2.0
#pragma once
// What may be traced: which rays, and which instances they may meet. Of all that trace, the device's pipelines too.

#include <cmath>

#include "base/volume.h"

namespace gnomon::ray {

/// Whether a ray may be handed to Embree; the others meet nothing. One that ends behind its beginning may not: Embree
/// marks occluded rays by such an end.
inline bool traceable(float ox, float oy, float oz, float tnear, float dx, float dy, float dz, float tfar)
{
    // Numbers and no truth values, so that there are no branches and packets are checked at once.
    const auto fits = [](float x) { return static_cast<unsigned>(std::abs(x) <= k_largest_coordinate); };   // 0 for NaN
    const auto at_least = [](float x, float least) { return static_cast<unsigned>(x >= least); };
    return (fits(ox) & fits(oy) & fits(oz) & fits(dx) & fits(dy) & fits(dz) & at_least(tnear, 0) &
            at_least(k_infinity, tnear) & at_least(tfar, 0)) != 0;
}

}   // namespace gnomon::ray
