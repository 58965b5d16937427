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

#include <algorithm>
#include <bit>
#include <functional>
#include <span>

#include "area_light/light_places.h"
#include "visibility/static_triangles.h"

namespace gnomon::area_light {

/// Triangles and planar convex quadrilaterals in a structure of arrays, padded so that the last vector can be read
/// whole.
class TriangleList {
 public:
    static constexpr std::size_t k_pad = 16;

    void clear() { count_ = 0; }
    void push(const glm::vec3 (&corner)[3]) { push_corners({corner[0], corner[1], corner[2], corner[2]}, 3); }
    void push(const glm::vec3 (&corner)[4]) { push_corners({corner[0], corner[1], corner[2], corner[3]}, 4); }
    /// Adds the two triangles of a quadrilateral to another list.
    void push_halves(std::size_t entry, TriangleList& halves) const;
    /// Repeats the last entry to the end of its vector, or a short list, padded to lanes(), from there on. Call after
    /// the last push().
    void pad();
    /// The lanes of a vector that a list takes: a power of 2, at most k_pad.
    std::size_t lanes() const { return std::min(std::bit_ceil(count_), k_pad); }
    std::size_t size() const { return count_; }
    /// One coordinate of one corner, by entry; of a triangle, the last two corners are equal.
    const float* at(std::size_t corner, std::size_t axis) const { return at_[corner][axis].data(); }
    int corners(std::size_t entry) const { return corners_[entry]; }

 private:
    void push_corners(const std::array<glm::vec3, 4>& corner, std::uint8_t corners)
    {
        if (count_ == corners_.size()) grow();
        for (std::size_t c = 0; c < 4; ++c)
            for (int axis = 0; axis < 3; ++axis) at_[c][static_cast<std::size_t>(axis)][count_] = corner[c][axis];
        corners_[count_++] = corners;
    }
    void grow();

    std::array<std::array<std::vector<float>, 3>, 4> at_;
    std::vector<std::uint8_t> corners_;
    std::size_t count_ = 0;
};

/// Adds to `blocked` the places that triangles hide from a point, of those inside the light.
/// @return  whether any of them may hide one
bool add_blocked(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places, PlaceMask& blocked);

/// The same for several points, several of them at once if the list is short.
/// @param blocked, hides  by point
void add_blocked(std::span<const glm::vec3> points, const TriangleList& triangles, const LightPlaces& places,
                 std::span<PlaceMask> blocked, std::span<bool> hides);

/// Calls hides(entry, mask) for each triangle of a list that may hide places, with what it alone hides.
void for_each_blocker(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places,
                      const std::function<void(std::size_t, const PlaceMask&)>& hides);

/// The same for one place and one triangle, in the same arithmetic: the reference.
bool blocks_place(const glm::vec3& point, const glm::vec3 (&corner)[3], const LightPlaces& places, int row, int place);

}   // namespace gnomon::area_light
