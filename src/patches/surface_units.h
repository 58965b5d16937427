// SPDX-License-Identifier: Apache-2.0
#pragma once
// The static surfaces of a scene as units of similar use to patches: triangles, in scenes of very many groups of small
// ones (triangle_groups.h), and tiles of the triangles of a ground that reach far beyond the scene's detail.
//
// Tiles are parts of a triangle (base/micro_triangles.h) of several levels, smaller near the detail (detail_region.h):
// at most half as long as they are far away, or as half of the region's size. A ground of two triangles, a hundred
// times as wide as what stands on it, has some hundreds.
//
// Memory: eight bytes for each triangle or group, and twelve for each tile.

#include <cstdint>
#include <vector>

#include "patches/detail_region.h"
#include "patches/triangle_groups.h"
#include "ray/ray_scene.h"

namespace gnomon::patches {

struct UnitOptions {
    // Of scenes with more triangles than `ungrouped`, `grouped` groups are aimed at, each of at most a fraction of the
    // mean area of a patch.
    std::size_t ungrouped = std::size_t{1} << 20, grouped = std::size_t{1} << 18;
    double group_area = 1.0 / 64;
    std::size_t tiles = 16384;   // in all, at most
};

class SurfaceUnits {
 public:
    /// @param patches  how many there will be of one side of all surfaces
    SurfaceUnits(const scene::SceneState& state, const ray::RayScene& rays, const UnitOptions& options,
                 std::size_t patches);

    std::uint32_t size() const { return whole_ + static_cast<std::uint32_t>(tiles_.size()); }

    /// Only before forget_areas(). 0: nothing of it blocks light, or tiles have taken its place.
    float area(std::uint32_t unit) const { return area_[unit]; }
    /// How much its surface matters (DetailRegion::weight). Only before forget_areas().
    float weight(std::uint32_t unit) const { return weight_[unit]; }
    void forget_areas() { area_ = {}, weight_ = {}; }

    const DetailRegion& region() const { return region_; }

    scene::ObjectId object(std::uint32_t unit) const { return objects_[index_of(unit)]; }
    /// The triangle of a unit, or the one that represents it.
    std::uint32_t triangle(std::uint32_t unit) const;
    /// Those of a tile, else of the triangle.
    void corners(const ray::RayScene& rays, std::uint32_t unit, glm::vec3 (&p)[3]) const;
    /// Whether it stands for one triangle or a part of it, not for several.
    bool divides(std::uint32_t unit) const;
    /// Of a sphere around the triangle's centre that encloses the unit; 0 where its corners tell.
    float radius_of_group(const ray::RayScene& rays, std::uint32_t unit) const;
    /// Barycentric coordinates in the triangle of those in the unit.
    glm::vec2 in_triangle(std::uint32_t unit, const glm::dvec2& uv) const;

    struct Place {
        std::uint32_t unit = scene::none;
        float u = 0, v = 0;   // in the unit
    };
    /// The unit at a point of a triangle; none on dynamic objects, and where nothing blocks light. Thread-safe.
    Place at(scene::ObjectId object, std::uint32_t triangle, float u, float v) const;

    std::size_t bytes() const;

 private:
    struct Tile {
        std::uint32_t whole = 0;   // the unit that it is a part of
        std::uint32_t code = 0;    // where it begins on the path of quarters to parts of level k_most_tile_level
        std::uint32_t part = 0;    // its micro index, times 16, and its level
        std::uint32_t level() const { return part & 15; }
        std::uint32_t index() const { return part >> 4; }
    };
    void number(const scene::SceneState& state, const ray::RayScene& rays, const UnitOptions& options,
                std::size_t patches);
    void group_meshes(const scene::SceneState& state, const ray::RayScene& rays, const UnitOptions& options,
                      std::size_t triangles, std::size_t patches);
    void divide_far(const ray::RayScene& rays, std::size_t most);
    std::uint32_t whole_of(std::uint32_t unit) const { return unit < whole_ ? unit : tiles_[unit - whole_].whole; }
    // The index of an object among those with surfaces.
    std::uint32_t index_of(std::uint32_t unit) const;
    const TriangleGroups* groups_of(std::uint32_t index) const
    {
        return groups_of_.empty() ? nullptr : &groups_[groups_of_[index]];
    }
    const TriangleGroups::Group* group(std::uint32_t unit) const;

    static constexpr std::uint32_t k_block = 64;   // units

    DetailRegion region_;
    std::vector<scene::ObjectId> objects_;         // static ones with surfaces, ascending
    std::vector<std::uint32_t> groups_of_;         // by these: index in groups_; empty: triangles are not grouped
    std::vector<TriangleGroups> groups_;           // by mesh
    std::vector<std::uint32_t> first_unit_;        // by object with surfaces, and one more at the end
    std::vector<std::uint32_t> index_of_block_;    // of the objects: that of the first unit, for each block of units
    std::vector<std::uint32_t> place_of_object_;   // by object of the scene: its index among these, or none
    std::uint32_t whole_ = 0;                      // units that are no tiles; these come first
    std::vector<Tile> tiles_;                      // by whole unit, then by code
    std::vector<float> area_, weight_;             // by unit; only while patches are made
};

}   // namespace gnomon::patches
