// SPDX-License-Identifier: Apache-2.0
#pragma once
// Queues of rays through Embree in packets as wide as the processor.

#include <cstdint>

#include "ray/embree/embree.h"
#include "ray/queue.h"
#include "ray/traceable.h"

namespace gnomon::ray {

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
/// @param active  per lane: -1 to trace, 0 to leave alone; on return 0 as well for those that are occluded
void occlude_packet(int width, RTCScene scene, RTCScene then, TraceContext& context, const RayQueue& rays,
                    std::size_t begin, int count, int* active);

}   // namespace gnomon::ray
