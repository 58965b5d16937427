// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where indirect light is remembered: points on surfaces that depend on the geometry and on a level of detail, and on
// nothing else. So an image does not depend on which frames came before it.
//
// Lattice anchors: the lines of a cubic lattice of spacing 2^level along the axis that the surface faces most, where
// they meet static geometry near a lattice plane. Four lines surround a point; what they hold is interpolated. Part
// anchors: the middle of a part of a triangle (micro-triangles), for what no lattice line meets, and for what moves.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

using AnchorKey = std::uint64_t;

/// Lattice points contribute to surfaces whose plane is closer than this fraction of the spacing.
inline constexpr float k_plane_distance = 0.35f;

/// A point that wants indirect light.
struct IndirectPoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the viewer's side
    glm::vec3 normal{0};             // unit, shading
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    float width = 0;          // of a pixel there, scene units
    glm::vec3 to_viewer{0};   // unit, or 0: not known
    // Place in a tile of pixels, of what the camera itself sees, at most once in a call; -1: not in one.
    std::int16_t x = -1, y = -1;
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

/// The same for one point after another: what neighbours have in common is reckoned once.
class LatticeCursor {
 public:
    enum class Step : std::uint8_t { outside, same, other };   // cell, compared with the last step's
    Step go(const IndirectPoint& point, int level);
    /// Of the last step that was not outside.
    const LatticeCell& cell() const { return cell_; }

 private:
    LatticeCell cell_{};
    bool any_ = false;
    int level_ = 0, axis_ = 0, b_ = 0, c_ = 0;
    glm::vec3 normal_{0};
    float per_h_ = 0, slope_b_ = 0, slope_c_ = 0;
    float i_ = 0, j_ = 0, k_[4] = {};
};

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
/// How often a triangle is halved both ways until a part of it is no larger than `spacing`.
struct PartDetail {
    std::uint32_t level;   // up to k_part_levels
    float fraction;        // how far beyond the level before, 0 to 1; 1 where there is no other
};
inline constexpr std::uint32_t k_part_levels = 8;
PartDetail part_detail(float triangle_area, float spacing);
AnchorKey part_key(std::uint32_t scene_triangle, bool front, std::uint32_t level, float u, float v);
Part part_of(AnchorKey key);
/// By object: the number of its first triangle among all triangles of the scene.
/// @throws MissingError  where there are more than numbers
std::vector<std::uint32_t> first_triangles(const scene::Scene& scene);

/// Numbers the triangles of all objects of a scene.
class TriangleNumbers {
 public:
    explicit TriangleNumbers(const scene::Scene& scene) : first_(first_triangles(scene)) {}
    /// The number of an object's first triangle.
    std::uint32_t first(scene::ObjectId object) const { return first_[object]; }
    /// The object that a triangle belongs to.
    scene::ObjectId object_of(std::uint32_t triangle) const
    {
        const auto after = std::upper_bound(first_.begin(), first_.end(), triangle);
        return static_cast<scene::ObjectId>(after - first_.begin() - 1);
    }

 private:
    std::vector<std::uint32_t> first_;
};

/// The same place for near light (near_light.h), which is remembered apart.
inline constexpr AnchorKey k_near_anchor = 1ull << 61;
inline bool is_near(AnchorKey key)
{
    return !is_lattice(key) && (key & k_near_anchor) != 0;
}

}   // namespace gnomon::irradiance_cache
