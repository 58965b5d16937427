// SPDX-License-Identifier: Apache-2.0
#pragma once
// Queues of rays through Embree in packets as wide as the processor.

#include <cmath>
#include <cstdint>

#include "base/math.h"
#include "ray/embree.h"
#include "ray/queue.h"

namespace gnomon::ray {

// Embree asserts, in release builds too, that rays are numbers within 1.8e18, also in the space of an instance. So rays
// beyond k_largest_coordinate (scene units) meet nothing, nor do instances that magnify rays by more than
// k_largest_inverse: together they stay below 6 * 1e9 * 1e8.
inline constexpr float k_largest_coordinate = 1e9f;
inline constexpr double k_largest_inverse = 1e8;

/// Whether a ray may be handed to Embree; the others meet nothing.
inline bool traceable(float ox, float oy, float oz, float tnear, float dx, float dy, float dz, float tfar)
{
    // Numbers and no truth values, so that there are no branches and packets are checked at once.
    const auto fits = [](float x) { return static_cast<unsigned>(std::abs(x) <= k_largest_coordinate); };   // 0 for NaN
    const auto at_least = [](float x, float least) { return static_cast<unsigned>(x >= least); };
    return (fits(ox) & fits(oy) & fits(oz) & fits(dx) & fits(dy) & fits(dz) & at_least(tnear, 0) &
            at_least(k_infinity, tnear) & at_least(tfar, -k_infinity)) != 0;
}

/// What a packet met, in Embree's numbers.
struct RawHits {
    alignas(64) float t[16], u[16], v[16];
    alignas(64) unsigned geometry[16], instance[16], triangle[16];
};

/// @param width  16, 8 or 4
/// @param tfar   per lane: where rays end (earlier hits shorten them)
/// @param count  lanes in use, 1 to width
void intersect_packet(int width, RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin,
                      int count, const float* tfar, RawHits& hits);
/// Asks one scene, and then another (null: none) with what the first let pass: rays are loaded once.
/// @param active  per lane: -1 to trace, 0 to leave alone; on return 0 as well for those that are blocked
void occlude_packet(int width, RTCScene scene, RTCScene then, TraceContext& context, const RayQueue& rays,
                    std::size_t begin, int count, int* active);

}   // namespace gnomon::ray
