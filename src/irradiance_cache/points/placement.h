// SPDX-License-Identifier: Apache-2.0
#pragma once
// Places new cache points on surfaces: where a lattice line meets static geometry and how far the surface around is
// free, and the centre of a part of a triangle.
//
// Cost: a new lattice point: 1 to 6 rays along its line, four along the surface, and five that find whether geometry
// covers it. A new part of a static object: these five. One more where the smooth surface is above the triangle. Parts
// of dynamic objects are placed again whenever one moved.

#include <span>
#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/cache_point.h"

namespace gnomon::irradiance_cache {

/// Holds a thread's scratch memory.
class PointPlacer {
 public:
    PointPlacer() { rays_.purpose = ray::RayClass::indirect; }
    /// Places those of the claimed points that are new or may have moved. Points without a surface need no evaluation
    /// and are marked as evaluated.
    void place(const CacheFrame& frame, std::span<CachePoint* const> claimed);

 private:
    struct Search {
        CachePoint* point;
        float from, best, found;   // along the line: where to go on, distance to its middle so far, last surface
    };
    void follow_lines(const CacheFrame& frame);
    bool accept_hit(const CacheFrame& frame, Search& search, std::size_t ray) const;
    void stay_before_surfaces(const CacheFrame& frame);
    void find_free_distances(const CacheFrame& frame);
    void find_covered(const CacheFrame& frame);

    std::vector<Search> searching_;
    struct Covering {
        CachePoint* point;
        float reach;
    };
    std::vector<CachePoint*> placed_;   // new lattice points
    std::vector<CachePoint*> raised_;   // to the smooth surface
    std::vector<Covering> covering_;    // new points on static objects
    ray::RayQueue rays_;
    ray::Hits hits_;
    std::vector<std::uint8_t> occluded_;
};

}   // namespace gnomon::irradiance_cache
