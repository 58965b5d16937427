// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which places of a light triangles hide from a point.
//
// A triangle and a point span a cone with three side planes; what of the light's plane lies in the cone, beyond the
// triangle, is hidden. Each side plane and the triangle's own is a linear function over the light. Along a row of
// places, it is positive on one side of one place; so the hidden places of a row are one run of bits. The side planes
// of two triangles that share an edge are exact negatives of each other, so that no place between them stays visible.
//
// A place counts as hidden if the segment from the point to ray::k_shadow_ray_end of the way meets the triangle, front
// or back, up to rounding in single precision. Places below the receiver's horizon have any value.
//
// Results are the same for any instruction set, and do not depend on triangles that hide nothing.
// Cost: some 20 ns for a triangle that the point's cone to the light misses, and 100 for one that it meets (AVX-512).

#include <span>

#include "area_light/light_places.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {

/// Triangles and planar convex quadrilaterals in a structure of arrays, padded so that the last vector can be read
/// whole.
struct TriangleList {
    static constexpr std::size_t k_pad = 16;
    std::array<std::array<std::vector<float>, 3>, 4> at;   // by corner and axis; of a triangle, the last two are equal
    std::vector<std::uint8_t> corners;                     // 3 or 4
    std::size_t count = 0;

    void clear();
    void push(const glm::vec3 (&corner)[3]);
    void push(const glm::vec3 (&corner)[4]);
    /// Repeats the last triangle to the end of its vector. Call after the last push().
    void pad();
};

/// Adds to `blocked` the places that triangles hide from a point, of those inside the light.
/// @return  whether any of them may hide one
bool add_blocked(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places, PlaceMask& blocked);

/// The same for one place and one triangle, in the same arithmetic: the reference.
bool blocks_place(const glm::vec3& point, const glm::vec3 (&corner)[3], const LightPlaces& places, int row, int place);

}   // namespace gnomon::area_light
