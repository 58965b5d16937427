// SPDX-License-Identifier: Apache-2.0
#pragma once
// Slices of a slender triangle: parts that are about as long as they are wide.
//
// Halving all sides of a triangle (base/micro_triangles.h) keeps its shape, so that the parts of a bevel 2 m long and
// 2 cm wide are long, too, until they are far narrower than a pixel. Slices halve the longest side, and the height
// above it only when a slice would be shorter than wide.

#include <array>

#include "irradiance_cache/points/anchors.h"

namespace gnomon::irradiance_cache {

/// How a triangle lies above its longest side.
struct SlenderTriangle {
    int first = 0;                // corner from which that side goes to the next one
    float length = 0;             // of that side
    float height = 0, foot = 0;   // of the third corner; where it stands on that side, as a fraction of the length
    std::uint32_t levels = 0;     // how often the side is halved before the height is
};

/// @param corner  of a triangle with an area
SlenderTriangle slender_triangle(const glm::vec3 corner[3]);
/// Whether a triangle is so slender that slices are better than micro-triangles.
bool is_slender(const SlenderTriangle& triangle);

/// The key of the slice around barycentric coordinates.
/// @param level  how often the side is halved, up to k_part_levels
AnchorKey slice_key(const SlenderTriangle& triangle, std::uint32_t scene_triangle, bool front, std::uint32_t level,
                    float u, float v);

/// The two slices along the longest side between whose middles barycentric coordinates lie, with their weights.
struct SlicesAround {
    AnchorKey key[2];
    float weight[2];
};
SlicesAround slices_around(const SlenderTriangle& triangle, std::uint32_t scene_triangle, bool front,
                           std::uint32_t level, float u, float v);

/// The middle of a slice, as weights of the corners, and its size: the square root of its mean area.
struct SliceMiddle {
    std::array<float, 3> weight;
    float size;
};
/// @pre part.slice
SliceMiddle middle_of_slice(const SlenderTriangle& triangle, const Part& part);

}   // namespace gnomon::irradiance_cache
