// SPDX-License-Identifier: Apache-2.0
#pragma once
// Traces packets of rays through a SceneTree with arithmetic that every processor rounds alike.
//
// Rays are tested against triangles in a space in which the ray is the z axis [Woop, Benthin and Wald 2013, 'Watertight
// Ray/Triangle Intersection']. All operations are additions, multiplications, divisions, minima and maxima of single
// precision, each rounded once: no fused multiply-add, no approximate reciprocal. A lane's result depends on its ray
// alone: of equal distances the later object wins, then the later triangle. So the width of vectors, the packet and
// the order of the traversal change the time only.
//
// A packet is traced together as long as several of its rays visit a node; the others go on singly, four boxes or four
// triangles at a time.

#include <cstdint>
#include <span>
#include <vector>

#include "ray/portable/tree.h"
#include "ray/queue.h"

namespace gnomon::ray {

/// Rays of a packet.
inline constexpr std::size_t k_packet_rays = 16;

/// What rays look for.
struct RayQuery {
    unsigned mask = k_mask_seen;
    bool front_only = false;                // closest hits: not the back of one-sided surfaces
    std::vector<ThinHit>* thin = nullptr;   // with k_mask_thins: takes the hits; their `ray` is the lane
};

/// Rays and their nearest hits so far. Lanes that are not in use have an end of -1.
struct RayPacket {
    alignas(64) float origin[3][k_packet_rays], direction[3][k_packet_rays];
    alignas(64) float tnear[k_packet_rays];
    alignas(64) float t[k_packet_rays];   // the end of the ray; then the distance of the nearest hit
    alignas(64) float u[k_packet_rays], v[k_packet_rays];
    std::uint32_t geometry[k_packet_rays], triangle[k_packet_rays];
    const TreeInstance* instance[k_packet_rays];   // null: no hit
};

/// Finds the nearest hits, or keeps those that the packet has.
void find_closest(std::span<const SceneTree* const> scenes, const RayQuery& query, RayPacket& packet);
/// @param lanes  bits of the lanes to trace
/// @return       those that are occluded; none with RayQuery::thin
unsigned find_occluded(std::span<const SceneTree* const> scenes, const RayQuery& query, RayPacket& packet,
                       unsigned lanes);

}   // namespace gnomon::ray
