// SPDX-License-Identifier: Apache-2.0
#pragma once
// Groups of neighbouring triangles of a mesh, one of which stands in for all: for places that many points share
// (shared_places.h), where triangles are smaller than the cones of the rays that meet them.
//
// The triangles of a mesh are sorted by the direction that they face, and along a Morton curve of their middles. Those
// that face one way in one cube of an octree then follow each other, at every level of the tree. The one in the middle
// of such a run stands in for the others; it is a function of mesh, triangle and level.
//
// Cost: a sort of the triangles of a mesh when the first of them is asked for; then two binary searches. Memory: 12
// bytes for each triangle of such a mesh.

#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "scene/scene.h"

namespace gnomon::trace {

/// The triangles of one mesh, in the space of its vertices at rest.
class TriangleRuns {
 public:
    explicit TriangleRuns(const scene::Mesh& mesh);

    static constexpr int k_levels = 10;
    /// The edge of the cubes of a level, from 0 to k_levels - 1.
    float cube(int level) const { return std::ldexp(least_cube_, level); }
    /// The triangle that stands in for the one given, and for all others that face its way in its cube. One without an
    /// area stands for itself, and so do a few together, because little is gained by what they have in common.
    std::uint32_t middle(std::uint32_t triangle, int level) const;
    std::size_t bytes() const;

 private:
    float least_cube_ = 0;
    std::vector<std::uint32_t> codes_, triangles_;   // in their order
    std::vector<std::uint32_t> place_of_;            // by triangle; none: it has no area
};

/// The triangles of all meshes that were asked for.
class PlaceGroups {
 public:
    /// Forgets all if the scene is another one. Call between frames. @param scene  kept
    void begin_frame(const std::shared_ptr<const scene::Scene>& scene);
    /// Thread-safe. @param mesh  of the scene; kept by reference
    const TriangleRuns& of(const scene::Mesh& mesh);
    std::size_t bytes() const;

 private:
    struct Entry {
        std::once_flag made;
        std::unique_ptr<const TriangleRuns> runs;
    };
    mutable std::mutex mutex_;
    std::unordered_map<const scene::Mesh*, std::unique_ptr<Entry>> of_;
    std::shared_ptr<const scene::Scene> scene_;   // so that no other mesh takes the address of one
};

}   // namespace gnomon::trace
