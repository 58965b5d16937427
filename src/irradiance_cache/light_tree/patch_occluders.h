// SPDX-License-Identifier: Apache-2.0
#pragma once
// Static triangles that hide dynamic objects from patches (patches/surface_patches.h).
//
// Most rays from patches to lit dynamic objects start inside closed bodies or behind walls, where next to no light
// arrives, so that all of it counts; and most of them end at the triangle at which they ended in the frame before. So
// each patch remembers one static triangle for each owner: the part of space that the triangle hides from the patch's
// sample. What lies in there, with a margin, is occluded whatever else moves, and needs no ray. What does not is tested
// as before, so that no result depends on what is remembered.
//
// Cost: four scalar products per patch and owner. Memory: 56 bytes for each triangle that is remembered, and 2 bytes
// per patch and owner.

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "irradiance_cache/light_tree/moving_spheres.h"
#include "ray/ray_scene.h"

namespace gnomon::irradiance_cache {

/// What a triangle hides from a point: the part of space behind it, bounded by four planes.
class TriangleShadow {
 public:
    /// @param corners  in the world
    /// @return  none if the triangle is degenerate, or is seen edge-on
    static std::optional<TriangleShadow> behind(const glm::vec3 (&corners)[3], const glm::vec3& from);

    /// Whether a sphere lies in it. Conservative: a ray from the point to any place in the sphere meets the triangle,
    /// well inside of its edges, and before it ends.
    /// @param centre  relative to the point
    bool hides(const glm::vec3& centre, float radius) const;

 private:
    // Unit normals that point inside: of the planes through the point and an edge, and of the triangle's own.
    float x_[4], y_[4], z_[4];
    float distance_;   // of the triangle's plane
    float margin_;     // by which a place must lie inside, of its distance
};

/// Holds one for each patch and owner.
class PatchOccluders {
 public:
    static constexpr std::size_t k_run = 512;   // patches that one thread uses at a time
    static constexpr std::size_t k_most_owners = 256;

    /// What static triangles hide of one owner.
    class OfOwner {
     public:
        /// Null: nothing is remembered.
        const TriangleShadow* find(std::size_t patch) const;
        /// Thread-safe for patches of different runs.
        void remember(std::size_t patch, const TriangleShadow& shadow);

     private:
        friend class PatchOccluders;
        struct Run {
            std::vector<std::uint16_t> places;   // by patch: one more than its number among the shadows; 0: none
            std::vector<TriangleShadow> shadows;
        };
        std::vector<Run> runs_;
    };

    /// Forgets everything. Call if the static scene changed.
    void forget() { owners_.clear(); }
    /// Forgets everything if there are more owners than a few frames have. Call before of().
    void limit()
    {
        if (owners_.size() > k_most_owners) forget();
    }
    /// Not thread-safe. Valid until any of the functions above is called.
    OfOwner& of(std::uint32_t owner, std::size_t patches);
    std::size_t bytes() const;

 private:
    std::unordered_map<std::uint32_t, OfOwner> owners_;
};

}   // namespace gnomon::irradiance_cache
