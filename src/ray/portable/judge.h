// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the material of a surface says about a hit, for the portable ray tracer: Embree's filters (embree/solid.cpp) do
// the same.

#include <cstddef>
#include <cstdint>

#include "ray/portable/kernels.h"

namespace gnomon::ray {

/// Whether a point of a surface is in a hole of a masked one. (Sides are judged by TriangleBlock::unmet.)
bool is_hole(const TreeInstance& instance, std::uint32_t geometry, std::uint32_t triangle, float u, float v);
/// Whether the surface blocks the ray. Notes how much light it lets through, if the query asks for that; it does not
/// block then.
bool occludes(const TreeInstance& instance, std::uint32_t geometry, std::uint32_t triangle, float u, float v,
              const RayQuery& query, std::size_t lane);
/// Whether the first of two hits at the same distance wins: the later object, then the later triangle. (Where the walls
/// of a room meet, ceilings and floors often come first and extend into the walls.)
bool comes_first(const TreeInstance& a, std::uint32_t a_geometry, std::uint32_t a_triangle, const TreeInstance& b,
                 std::uint32_t b_geometry, std::uint32_t b_triangle);
/// The object and the triangle of its mesh.
scene::ObjectId object_of(const TreeInstance& instance, std::uint32_t geometry);
std::uint32_t triangle_of(const TreeInstance& instance, std::uint32_t geometry, std::uint32_t triangle);

}   // namespace gnomon::ray
