// SPDX-License-Identifier: Apache-2.0
#pragma once
// A coarse voxel grid of a scene's surfaces, used to estimate the surroundings of a point. Each cell stores the
// directions that surfaces in it face. For choosing default cameras and lights; not for shading.
//
// Cost: linear in triangles and covered cells; the number of samples is bounded whatever the triangles' sizes.
// Weakness: surfaces that are thinner than a cell fill it.

#include <vector>

#include "scene/scene.h"

namespace gnomon::scene {

class SpaceGrid {
 public:
    struct Options {
        int cells = 80;                           // along the longest side
        std::uint64_t most_samples = 8'000'000;   // over all triangles
    };
    /// Samples everything that is visible at a time; empty for a scene without extent.
    SpaceGrid(const Scene& scene, double time, const Options& options);
    SpaceGrid(const Scene& scene, double time) : SpaceGrid(scene, time, Options()) {}

    const Box3& box() const { return box_; }
    bool empty() const { return facing_.empty(); }
    float cell() const { return cell_; }
    bool occupied(const glm::vec3& point) const;

    enum class Met : std::uint8_t { nothing, front, back };
    struct Hit {
        Met met = Met::nothing;
        float distance = 0;            // to where the ray left the grid, if it hit nothing
        std::uint32_t triangles = 0;   // in the cell that was hit
    };
    /// Finds the first surface along a ray from any origin; the cell of the origin is ignored.
    Hit cast(const glm::vec3& origin, const glm::vec3& direction) const;

    /// The fraction of all directions in which the point sees the front of a surface: 1 in a closed room.
    float enclosure(const glm::vec3& point) const;

 private:
    glm::ivec3 cell_of(const glm::vec3& point) const;
    std::size_t index(const glm::ivec3& c) const
    {
        return (static_cast<std::size_t>(c.z) * size_.y + c.y) * static_cast<std::size_t>(size_.x) + c.x;
    }

    Box3 box_;
    glm::ivec3 size_{0};
    float cell_ = 0;
    std::vector<std::uint32_t> triangles_;   // triangles whose centre is in the cell
    std::vector<std::uint8_t> facing_;       // bits +x -x +y -y +z -z; 0: no surface
};

/// Directions spread evenly over the sphere [Swinbank and Purser 2006].
glm::vec3 sphere_direction(int i, int count);

}   // namespace gnomon::scene
