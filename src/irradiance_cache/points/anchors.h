// SPDX-License-Identifier: Apache-2.0
#pragma once
// Keys of cache points: places on surfaces that depend on the geometry and on a level of detail, and on nothing else.
// So a frame does not depend on the frames before it.
//
// Lattice points lie where the lines of a cubic lattice of spacing 2^level, along the axis that the surface faces most,
// meet static geometry near a lattice plane. The four lines around a surface point are interpolated. Parts are
// micro-triangles; their point is the centre. They are used where no lattice line is near. On dynamic objects the
// corners of micro-triangles are interpolated.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

using AnchorKey = std::uint64_t;

/// Lattice points contribute to surfaces whose plane is closer than this fraction of the spacing.
inline constexpr float k_plane_distance = 0.35f;

/// A surface point whose irradiance is needed.
struct IndirectPoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the viewer's side
    glm::vec3 normal{0};             // unit, shading
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
    float width = 0;          // of a pixel at the point, scene units
    glm::vec3 to_viewer{0};   // unit, or 0: unknown
    // Place in a tile of pixels, for points that the camera sees directly; each place once per call. -1: none.
    std::int16_t x = -1, y = -1;
    bool of_many = false;   // one of many points of which the mean is shown, as those that rays of one lobe meet
};

/// Level of detail: the largest power of two not above a spacing, and how far the spacing is towards the next.
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
    float x, y;   // place of the point between the lines, 0 to 1
};
/// @return  false if a coordinate is out of range
bool lattice_cell(const IndirectPoint& point, int level, LatticeCell& cell);

/// The same for a sequence of points; values that neighbours share are computed once.
class LatticeCursor {
 public:
    enum class Step : std::uint8_t { outside, same, other };   // the cell, compared with that of the last step
    Step go(const IndirectPoint& point, int level);
    /// The cell of the last step that was not outside.
    const LatticeCell& cell() const { return cell_; }

 private:
    LatticeCell cell_{};
    bool any_ = false;
    int level_ = 0, axis_ = 0, b_ = 0, c_ = 0;
    glm::vec3 normal_{0};
    float per_h_ = 0, slope_b_ = 0, slope_c_ = 0;
    float i_ = 0, j_ = 0, k_[4] = {};
};

/// The line on which a lattice point lies: from `from` to `from` + `direction`, at best in the middle.
struct LatticeLine {
    glm::vec3 from, direction;
};
LatticeLine lattice_line(AnchorKey key);
float lattice_spacing(AnchorKey key);
/// The axis of its line; the lattice's other two axes follow cyclically.
int lattice_axis(AnchorKey key);
bool is_lattice(AnchorKey key);

/// A part of a triangle.
struct Part {
    std::uint32_t triangle = 0;   // among all triangles of the scene
    bool front = true;            // by world winding
    std::uint32_t level = 0, index = 0;
    bool slice = false;    // of a slender triangle (slices.h), not a micro-triangle
    bool corner = false;   // a corner of micro-triangles, not one of them
};
/// How often a triangle's sides are halved until a part is no larger than `spacing`.
struct PartDetail {
    std::uint32_t level;   // up to k_part_levels
    float fraction;        // how far beyond the level before, 0 to 1; 1 if there is none
};
inline constexpr std::uint32_t k_part_levels = 8;
PartDetail part_detail(float triangle_area, float spacing);
AnchorKey part_key(std::uint32_t scene_triangle, bool front, std::uint32_t level, float u, float v);
AnchorKey key_of(const Part& part);
/// The corner (i, j) of the micro-triangles of a level: u = i / 2^level, v = j / 2^level.
/// @param level  up to k_corner_levels
AnchorKey corner_key(std::uint32_t scene_triangle, bool front, std::uint32_t level, std::uint32_t i, std::uint32_t j);
inline constexpr std::uint32_t k_corner_levels = 7;
/// Barycentric (u, v) of a corner.
/// @param inset  how far those on the triangle's sides are moved inwards, as a fraction of a micro-triangle's height
/// @pre part.corner
glm::vec2 place_of_corner(const Part& part, float inset);
/// The inset of cache points, which have the corner's normal: just at a side, what touches the triangle there would be
/// in the way.
inline constexpr float k_corner_inset = 0.15f;
Part part_of(AnchorKey key);
/// By object: the number of its first triangle among all triangles of the scene.
/// @throws MissingError  if there are more triangles than 32 bits can number
std::vector<std::uint32_t> first_triangles(const scene::Scene& scene);

/// Numbers the triangles of all objects of a scene.
class TriangleNumbers {
 public:
    explicit TriangleNumbers(const scene::Scene& scene) : first_(first_triangles(scene)) {}
    /// Numbers the triangles of objects that were added; those of the others keep their numbers.
    void follow(const scene::Scene& scene) { first_ = first_triangles(scene); }
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

/// Marks the key of a part's near-field point (near_field/), which is a cache point of its own.
inline constexpr AnchorKey k_near_anchor = 1ull << 61;
inline bool is_near(AnchorKey key)
{
    return !is_lattice(key) && (key & k_near_anchor) != 0;
}

}   // namespace gnomon::irradiance_cache
