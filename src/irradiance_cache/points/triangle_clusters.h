// SPDX-License-Identifier: Apache-2.0
#pragma once
// Clusters of small triangles that share one cache point: leaves, rounded edges, balls.
//
// The triangles of a mesh are sorted into cubes in its own space, by centre and by the axis that they face most. The
// largest triangle of each cluster represents it. Clusters depend on the mesh and on the cubes' size, a power of two.
//
// On smooth meshes that move, each vertex blends the representatives around it, so that light has no facets.
// Cost: O(triangles) for each mesh and size, at the first use. Blends: 33 bytes a vertex, and a look into 27 cubes for
// each vertex that is seen.

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "scene/mesh.h"

namespace gnomon::irradiance_cache {

/// Representatives around the vertices of a mesh with vertex normals. Vertices are blended when they are first asked
/// for. Thread-safe.
class ClusterBlends {
 public:
    /// Up to four triangles with their weights, which sum to 1; all 0: there is none.
    struct Blend {
        std::uint32_t triangle[4] = {};
        float weight[4] = {};
    };
    /// @param level            cubes are 2^level units of the mesh's space wide
    /// @param representatives  TriangleClusters::representatives() of that level
    ClusterBlends(const scene::Mesh& mesh, int level, const std::vector<std::uint32_t>& representatives);
    ~ClusterBlends();
    ClusterBlends(const ClusterBlends&) = delete;
    ClusterBlends& operator=(const ClusterBlends&) = delete;

    /// @param mesh  the one that it was made of
    Blend of_vertex(const scene::Mesh& mesh, std::uint32_t vertex) const;
    /// Whether a triangle's winding faces away from its vertex normals, unlike that of most.
    bool apart(std::uint32_t triangle) const { return apart_[triangle]; }
    std::size_t bytes() const;

 private:
    class Cubes;
    enum State : std::uint8_t { unknown, being_made, made };
    std::unique_ptr<const Cubes> cubes_;
    std::vector<bool> apart_;   // by triangle
    // By vertex.
    mutable std::vector<Blend> blends_;
    mutable std::vector<std::atomic<std::uint8_t>> states_;
};

class TriangleClusters {
 public:
    /// @param level  cubes are 2^level units of the mesh's space wide
    /// @return  by triangle: the one that represents it. Thread-safe; valid as long as this object.
    const std::vector<std::uint32_t>& representatives(scene::MeshId id, const scene::Mesh& mesh, int level);
    /// The same, blended at each vertex: those within 1.5 cubes that face as the vertex does and lie near its plane.
    /// @pre the mesh has normals
    const ClusterBlends& blends(scene::MeshId id, const scene::Mesh& mesh, int level);
    std::size_t bytes() const;

 private:
    const std::vector<std::uint32_t>& representatives_locked(scene::MeshId id, const scene::Mesh& mesh, int level);

    mutable std::mutex mutex_;
    std::map<std::pair<scene::MeshId, int>, std::unique_ptr<std::vector<std::uint32_t>>> made_;
    std::map<std::pair<scene::MeshId, int>, std::unique_ptr<ClusterBlends>> blends_;
};

}   // namespace gnomon::irradiance_cache
