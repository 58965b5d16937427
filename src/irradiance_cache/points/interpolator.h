// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 3 of the irradiance cache, interpolate: blends the irradiance of evaluated cache points at surface points.
//
// A level of the lattice contributes as far as its points lie near the surface point's plane, face the same way and are
// not separated from it by a wall; the rest of the weight goes to finer levels, and in the end to parts of triangles.
// Each level fades in and out over a fraction of its range, so irradiance changes continuously with the distance.

#include "irradiance_cache/points/collector.h"

namespace gnomon::irradiance_cache {

/// Holds a thread's scratch memory.
class Interpolator {
 public:
    /// Adds the contribution of the collected cells, and leaves in `work` the requests for finer levels and parts.
    void blend_level(const CacheFrame& frame, std::span<const IndirectPoint> points, BatchWork& work,
                     glm::vec3* irradiance);
    /// Adds the contribution of the collected parts, and leaves in `work` requests for parts around the pixel where all
    /// is dark.
    /// @param last  whether dark parts are to be taken as they are
    void blend_parts(const CacheFrame& frame, std::span<const IndirectPoint> points, bool last, BatchWork& work,
                     glm::vec3* irradiance);

 private:
    static void gather_anchors(BatchWork& work);
    glm::vec3 fallback(const BatchWork& work, std::size_t request);

    LatticeLight light_, around_;
    std::vector<PartRequest> dark_;
};

}   // namespace gnomon::irradiance_cache
