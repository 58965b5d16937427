// SPDX-License-Identifier: Apache-2.0
#pragma once
// Traces queues of rays with Embree, in packets as wide as the processor's vectors.

#include <cstdint>

#include "ray/embree/embree.h"
#include "ray/queue.h"
#include "ray/traceable.h"

namespace gnomon::ray {

/// The hits of a packet, with Embree's ids.
struct RawHits {
    alignas(64) float t[16], u[16], v[16];
    alignas(64) unsigned geometry[16], instance[16], triangle[16];
};

/// @param width  16, 8 or 4
/// @param tfar   by lane: where rays end (earlier hits shorten them)
/// @param count  lanes in use, 1 to width
void intersect_packet(int width, RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin,
                      int count, const float* tfar, RawHits& hits);
/// Tests a packet against one scene, then the rays that are not occluded against another (null: none). Loads rays once.
/// @param active  by lane: -1 to trace, 0 to skip; set to 0 for rays that are occluded
void occlude_packet(int width, RTCScene scene, RTCScene then, TraceContext& context, const RayQueue& rays,
                    std::size_t begin, int count, int* active);

/// Collects the hits on surfaces that thin light in `context.thin`; their `ray` is the lane.
void thin_packet(int width, RTCScene scene, TraceContext& context, const RayQueue& rays, std::size_t begin, int count);

}   // namespace gnomon::ray
