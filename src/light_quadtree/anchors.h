// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where indirect light is remembered: points on surfaces that depend on the geometry and on a level of detail, and on
// nothing else. So a picture does not depend on which frames came before it.
//
// Lattice anchors: the lines of a cubic lattice of spacing 2^level along the axis that the surface faces most, where
// they meet static geometry near a lattice plane. Four lines surround a point; what they hold is interpolated. Part
// anchors: the middle of a part of a triangle (micro-triangles), for what no lattice line meets, and for what moves.

#include <cstdint>

#include "ray/ray_scene.h"

namespace gnomon::light_quadtree {

using AnchorKey = std::uint64_t;

/// A point that wants indirect light.
struct IndirectPoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the viewer's side
    glm::vec3 normal{0};             // unit, shading
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    float width = 0;   // of a pixel there, scene units
};

/// Level of detail: the largest power of two not above the wanted spacing, and how far towards the next.
struct Detail {
    int level;        // spacing is 2^level
    float fraction;   // 0 to 1
};
Detail detail_of(float spacing);
/// 2^level
float spacing_of(int level);

/// The four lattice lines around a point.
struct LatticeCell {
    AnchorKey key[4];
    float x, y;   // place between the lines, 0 to 1
};
/// @return false where a coordinate is out of range
bool lattice_cell(const IndirectPoint& point, int level, LatticeCell& cell);

/// A lattice anchor's line: search from `from` along `direction` (its length is how far); the wanted place is half-way.
struct LatticeLine {
    glm::vec3 from, direction;
};
LatticeLine lattice_line(AnchorKey key);
float lattice_spacing(AnchorKey key);
/// The axis along which it searches; the lattice's other two follow cyclically.
int lattice_axis(AnchorKey key);
bool is_lattice(AnchorKey key);

/// A part anchor.
struct Part {
    std::uint32_t triangle = 0;   // among all triangles of the scene
    bool front = true;            // by world winding
    std::uint32_t level = 0, index = 0;
};
/// @param spacing  wanted size of a part
AnchorKey part_key(std::uint32_t scene_triangle, bool front, float triangle_area, float u, float v, float spacing);
Part part_of(AnchorKey key);

}   // namespace gnomon::light_quadtree
