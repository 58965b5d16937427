// SPDX-License-Identifier: Apache-2.0
#pragma once
// Divides the static surfaces of a scene into patches of similar size, for light that bounces between them.
//
// Large triangles are divided into parts (base/micro_triangles.h); a small triangle is one part. Both sides of a part
// are told apart. Parts in the same cube of an octree (detail_cells.h) that face the same way form a cell. A few places
// represent each cell, and those that see each other just above the surface and are about as open form a patch: a wall
// that crosses a floor separates the floor's patches, the floor below a box is no part of the floor around it, and
// joints are no part of the tiles between them. So a patch is either in the light or out of it, light does not leak
// through walls, and surfaces that cannot be seen do not dilute the light of those that can. For the same reason the
// places of a patch represent its surface in proportion to how open they are.
//
// Patches depend on the static scene alone: neither on the lights, nor on the view or the time.
//
// What is divided are units (surface_units.h): triangles, groups of small ones, or tiles of a wide ground, whose
// patches are larger the farther they are from everything else (detail_region.h).
//
// Cost: a sort of all parts; up to three rays for each part, and some ten more for each place that is tested. Memory:
// nine bytes for each unit, four for each part, 36 for each place that is kept.

#include <functional>
#include <span>
#include <vector>

#include "base/tasks.h"
#include "patches/detail_cells.h"
#include "patches/surface_units.h"
#include "ray/ray_scene.h"

namespace gnomon::patches {

using PatchId = std::uint32_t;
inline constexpr PatchId k_no_patch = scene::none;

struct PatchOptions {
    std::size_t patches = 4096;   // aimed at, by one side of all surfaces
    std::size_t most = 32767;     // of both sides, at most, below 2^15; fewer are aimed at until they fit
    std::size_t most_cells = 16384;
    float parts = 3;               // parts along a patch, at least
    std::size_t places = 512;      // of a cell that are tested, at most
    std::size_t kept = 12;         // places of a patch, at most
    int separated = 12;            // groups of places of a cell that see each other, at most
    float lift = 0.1f;             // height at which places of a cell see each other, in widths of a cube
    float open_reach = 0.5f;       // how far places look for what is close to them, in widths of a cube
    float crossed_lift = 0.001f;   // the same for the places of a part
    float crossed_area = 0.003f;   // parts below this area, in squares of that width, are not tested for crossings
    UnitOptions units;
};

/// A point of a patch that represents some of its surface.
struct PatchPlace {
    glm::vec3 position{0};   // just above the surface
    glm::vec3 normal{0};     // unit, geometric
    float area = 0;          // of the surface that it represents, by how open it is
    std::uint32_t part = 0;
};

struct Patch {
    glm::vec3 position{0};   // mean over its surface
    glm::vec3 normal{0};     // mean; shorter than 1 if normals differ
    glm::vec3 sample{0};     // the place nearest to the mean, for which visibility is tested
    float area = 0;
    float weight = 1;                      // how much it matters, 0 to 1 (DetailRegion::weight)
    float radius = 0;                      // of a sphere around `position` that encloses it
    std::uint32_t first = 0, places = 0;   // its places
    PatchId cell = 0;                      // the first patch of the same cell
};

class SurfacePatches {
 public:
    SurfacePatches(const scene::SceneState& state, const ray::RayScene& rays, const PatchOptions& options,
                   Tasks& tasks);

    std::span<const Patch> patches() const { return patches_; }
    const DetailRegion& region() const { return units_.region(); }
    std::span<const PatchPlace> places(const Patch& patch) const
    {
        return std::span<const PatchPlace>(places_).subspan(patch.first, patch.places);
    }
    /// The patch at a point of a triangle; k_no_patch for dynamic objects, for surfaces that do not block light, and
    /// where none of the cell's places is visible from the point. Thread-safe. Cost: a look-up; where other geometry
    /// crosses the part, also a few rays.
    /// @param front  the side, by the world winding
    /// @param above  the point, just above the surface on that side
    PatchId patch_at(const ray::RayScene& rays, scene::ObjectId object, std::uint32_t triangle, float u, float v,
                     bool front, const glm::vec3& above) const;

    /// Mean albedo by patch (lighting::albedo), at most 0.98.
    std::vector<glm::vec3> albedo(const scene::Scene& scene, const ray::RayScene& rays, Tasks& tasks) const;

    std::size_t bytes() const;

 private:
    struct Part;
    struct Side;
    struct Made;
    std::uint8_t level_of(float area, float edge, float width) const;
    void divide(const ray::RayScene& rays, const std::function<float(std::uint32_t)>& width, Tasks& tasks,
                std::vector<Part>& parts);
    static void sort_sides(const DetailCells& cubes, Tasks& tasks, std::vector<Part>& parts, std::vector<Side>& sides);
    void choose_places(std::span<const Part> parts, std::span<const Side> sides, Made& made) const;
    static glm::vec3 above(std::span<const Part> parts, const Side& side, float lift);
    std::uint32_t group_places(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides,
                               Made& made) const;
    void find_openness(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides,
                       Made& made) const;
    static std::uint32_t split_by_openness(std::uint32_t groups, Made& made);
    void keep_places(std::span<const Part> parts, std::span<const Side> sides, std::uint32_t group, float patch_area,
                     Made& made) const;
    void make_cell(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides,
                   Made& made) const;
    std::vector<Made> make_cells(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides,
                                 std::span<const std::size_t> cells, Tasks& tasks) const;
    void number_patches(std::span<const Side> sides, std::span<const std::size_t> cells, std::vector<Made>& made);
    void mark_crossed(const ray::RayScene& rays, std::span<const Part> parts, std::span<const Side> sides);
    glm::dvec2 middle_of(std::uint32_t part, std::uint32_t unit) const;

    PatchOptions options_;
    SurfaceUnits units_;
    std::vector<std::uint32_t> first_part_;   // by unit, and one more
    std::vector<std::uint8_t> level_;         // by unit
    std::vector<std::uint16_t> patch_;        // by part and side; k_no_code: none; k_crossed may be set
    std::vector<Patch> patches_;
    std::vector<PatchPlace> places_;
};

}   // namespace gnomon::patches
