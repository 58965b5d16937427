// SPDX-License-Identifier: Apache-2.0
#pragma once
// The near field of lattice points, which is a part of their own light. Where they are near each other, near-field
// points between them take its place (near_blend.h). Points on dynamic objects hold theirs with static surfaces near
// by.

#include <span>
#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/cache_point.h"

namespace gnomon::irradiance_cache {

/// Whether a point's light includes its near field.
bool includes_near_field(const CacheFrame& frame, const CachePoint& point);

/// Whether a dynamic object may come between a point and surfaces near it, or between those surfaces and a light.
bool dynamic_may_occlude_near(const CacheFrame& frame, const CachePoint& point);

/// Holds a thread's scratch memory.
class NearOfPoints {
 public:
    /// Finds the near field of those points that include it, past static geometry.
    void find_static(const CacheFrame& frame, std::span<CachePoint* const> points, CacheCounters& counters);
    /// Finds the present near field of points on dynamic objects, past everything.
    void find_now(const CacheFrame& frame, std::span<CachePoint* const> points, CacheCounters& counters);
    /// Adds what was found to the points' static light. Nothing fails.
    void add_found() noexcept;
    /// Corrects the present light of points whose near field dynamic objects may occlude. Cost: for others, a test
    /// against the bounds of dynamic objects.
    void correct(const CacheFrame& frame, std::span<CachePoint* const> points, CacheCounters& counters);

 private:
    enum class Near : std::uint8_t { of_static, now, change };
    void gather(const CacheFrame& frame, Near what, CacheCounters& counters);

    std::vector<CachePoint*> points_;
    std::vector<NearReceiver> receivers_;
    std::vector<NearAnswer> answers_;
    NearLight::Scratch scratch_;
};

}   // namespace gnomon::irradiance_cache
