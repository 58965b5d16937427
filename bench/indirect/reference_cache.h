// SPDX-License-Identifier: Apache-2.0
#pragma once
// Caches the references of bench indirect in files, because one takes minutes to compute.
//
// The name of a file is a hash of everything that its values depend on: the scene, the time, the points, the lights and
// the number of paths. Files that are incomplete or of another kind are ignored.

#include <filesystem>
#include <span>

#include "bench/indirect/points.h"
#include "gnomon/types.h"

namespace gnomon::bench {

class ReferenceCache {
 public:
    /// @param folder  created if necessary; empty: nothing is kept
    /// @throws MissingError  if the folder cannot be created
    ReferenceCache(const std::filesystem::path& folder, const scene::Scene& scene);

    /// Indirect irradiance at points, and its estimated error.
    /// @throws InterruptedError  if progress returned false
    std::vector<reference::IrradianceEstimate> irradiance(const scene::SceneState& state, const ray::RayScene& rays,
                                                          std::span<const FixedPoint> points,
                                                          const reference::ReferenceOptions& options, Tasks& tasks,
                                                          const Progress& progress);
    int computed() const { return computed_; }
    int found() const { return found_; }

 private:
    std::filesystem::path folder_;
    std::uint64_t scene_hash_ = 0;
    int computed_ = 0, found_ = 0;
};

}   // namespace gnomon::bench
