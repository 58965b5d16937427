// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 3 of the irradiance cache, interpolate: blends the irradiance of evaluated cache points at surface points.
//
// A level of the lattice contributes as far as its points lie near the surface point's plane, face the same way and are
// not separated from it by a wall, nor hidden from it where it lies below them, and as far as the surface is even
// between them and the sky's light of its points is similar; the rest of the weight goes to finer levels, and in the
// end to parts of triangles. Each level fades in and out over a fraction of its range, so irradiance changes
// continuously with the distance.

#include "irradiance_cache/points/collector.h"
#include "irradiance_cache/points/remembered_batch.h"

namespace gnomon::irradiance_cache {

/// What parts are asked for, in this order: those for light from afar, finer ones, those around the pixel itself, and
/// those closest to it, which are taken as they are.
enum class PartsAre : std::uint8_t { far, finer, own, closest };

/// Holds a thread's scratch memory.
class Interpolator {
 public:
    Interpolator() { rays_.purpose = ray::RayClass::indirect; }
    /// Adds the contribution of the collected cells, and leaves in `work` the requests for finer levels and parts.
    /// @param recorder  optional: takes note of the contributions
    void blend_level(const CacheFrame& frame, std::span<const IndirectPoint> points, BatchWork& work,
                     glm::vec3* irradiance, CacheCounters& counters, BatchRecorder* recorder = nullptr);
    /// Adds the contribution of the collected parts, and leaves in `work` requests for finer parts, or for parts around
    /// the pixel, where these do not represent it.
    void blend_parts(const CacheFrame& frame, std::span<const IndirectPoint> points, PartsAre are, BatchWork& work,
                     glm::vec3* irradiance, CacheCounters& counters);

 private:
    struct Doubted {   // a cache point that a surface point may not see
        std::size_t request;
        int anchor;
    };
    static void gather_anchors(BatchWork& work);
    void leave_out_hidden(const CacheFrame& frame, std::span<const IndirectPoint> points, const BatchWork& work,
                          CacheCounters& counters);
    void find_steep(const BatchWork& work);
    static bool any_deferred(const CollectedCell& cell);
    static void finish_deferred(const CacheFrame& frame, const IndirectPoint& point, const LatticeRequest& request,
                                BatchWork& work, glm::vec3* irradiance);
    static Arriving around_part(const CacheFrame& frame, const IndirectPoint& point, const PartRequest& request,
                                BatchWork& work);
    float lacks_below(const CollectedCell& cell, const IndirectPoint& point, const LatticePoints& at,
                      std::size_t k) const;
    static float difference(const CollectedCell& cell, const LatticeLight& light, std::size_t k);
    struct Unevenness {
        float fraction = 0;
        float curves = 0;   // evenly, so that finer levels show it
    };
    Unevenness unevenness(const CacheFrame& frame, const CollectedCell& cell, const IndirectPoint& point,
                          std::size_t k) const;
    static glm::vec3 mean_normal(const IndirectPoint& point, const BatchWork& work, std::size_t first);
    static glm::vec4 near_at(const CollectedCell& cell, const LatticeLight& light, std::size_t k);
    static Arriving without_near(const CollectedCell& cell, const LatticeLight& light, std::size_t k);
    Arriving fallback(const BatchWork& work, std::size_t request);

    LatticeLight light_, around_;
    void find_hidden(const CacheFrame& frame, std::span<const IndirectPoint> points, const BatchWork& work,
                     CacheCounters& counters);

    std::vector<float> steep_;   // by request: fraction of its light from steep points
    std::vector<PartRequest> replaced_;
    std::vector<Doubted> doubted_;
    ray::RayQueue rays_;
    std::vector<std::uint8_t> occluded_, hidden_;
};

}   // namespace gnomon::irradiance_cache
