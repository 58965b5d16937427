// SPDX-License-Identifier: Apache-2.0
#pragma once
// Small triangles that share one remembered point: leaves, rounded edges, balls.
//
// A mesh's triangles are sorted into cubes of its own space and by the axis they face most; the largest of each set
// stands for all. That depends on the mesh and the size of the cubes (a power of two), never on what was seen. Cost:
// O(triangles) for each mesh and size, when first asked.

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
    /// @return by triangle: the one that stands for it. Thread-safe; valid as long as this object.
    const std::vector<std::uint32_t>& representatives(scene::MeshId id, const scene::Mesh& mesh, int level);
    std::size_t bytes() const;

 private:
    mutable std::mutex mutex_;
    std::map<std::pair<scene::MeshId, int>, std::unique_ptr<std::vector<std::uint32_t>>> made_;
};

}   // namespace gnomon::irradiance_cache
