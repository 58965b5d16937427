// SPDX-License-Identifier: Apache-2.0
#pragma once
// Clusters of small triangles that share one cache point: leaves, rounded edges, balls.
//
// The triangles of a mesh are sorted into cubes in its own space, by centre and by the axis that they face most. The
// largest triangle of each cluster represents it. Clusters depend on the mesh and on the cubes' size, a power of two.
//
// On smooth meshes that move, each vertex blends the representatives around it, so that light has no facets.
// Cost: O(triangles) for each mesh and size, at the first use; of blends also O(vertices), 32 bytes each.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "scene/mesh.h"

namespace gnomon::irradiance_cache {

/// Representatives around the vertices of a mesh with vertex normals.
struct ClusterBlends {
    /// Up to four triangles with their weights, which sum to 1; all 0: there is none.
    struct Blend {
        std::uint32_t triangle[4] = {};
        float weight[4] = {};
    };
    std::vector<Blend> of_vertex;
    std::vector<bool> apart;   // by triangle: its winding faces away from its vertex normals, unlike most
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
