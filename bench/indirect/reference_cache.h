// SPDX-License-Identifier: Apache-2.0
#pragma once
// References of bench indirect, kept in files: what took minutes is computed once.
//
// A file's name is a hash of all that its numbers depend on: the scene, the time, the points, the lights, the paths.
// A file that is not whole, or not of this kind, is as good as none.

#include <filesystem>
#include <span>

#include "bench/indirect/points.h"
#include "gnomon/types.h"

namespace gnomon::bench {

class ReferenceCache {
 public:
    /// @param folder  made if need be; empty: nothing is kept
    /// @throws MissingError  it cannot be made
    ReferenceCache(const std::filesystem::path& folder, const scene::Scene& scene);

    /// Bounced irradiance at points, and its error.
    /// @throws InterruptedError  progress returned false
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
