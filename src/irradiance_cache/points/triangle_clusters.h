// SPDX-License-Identifier: Apache-2.0
#pragma once
// Clusters of small triangles that share one cache point: leaves, rounded edges, balls.
//
// The triangles of a mesh are sorted into cubes in its own space, by centre and by the axis that they face most. The
// largest triangle of each cluster represents it. Clusters depend on the mesh and on the cubes' size, a power of two.
// Cost: O(triangles) for each mesh and size, at the first use.

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "scene/mesh.h"

namespace gnomon::irradiance_cache {

class TriangleClusters {
 public:
    /// @param level  cubes are 2^level units of the mesh's space wide
    /// @return  by triangle: the one that represents it. Thread-safe; valid as long as this object.
    const std::vector<std::uint32_t>& representatives(scene::MeshId id, const scene::Mesh& mesh, int level);
    std::size_t bytes() const;

 private:
    mutable std::mutex mutex_;
    std::map<std::pair<scene::MeshId, int>, std::unique_ptr<std::vector<std::uint32_t>>> made_;
};

}   // namespace gnomon::irradiance_cache
