// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light without size between two horizons: above the one that a point's vertex normals give, below that of its
// triangle.
//
// Shadow techniques decide for the point on the triangle, to which such light is behind. On a smooth mesh of few
// triangles it would end at their edges, in a jagged line. Here rays decide that start above the smooth surface
// [Hanika 2021]: at most one for a point and a light, and none on flat surfaces. What the techniques prove and remember
// is not touched: it is about the points on the triangles.

#include <span>
#include <vector>

#include "scene/light_reach.h"
#include "trace/point_batch.h"

namespace gnomon::trace {

class SmoothHorizon {
 public:
    explicit SmoothHorizon(const ray::RayScene& rays) : rays_(rays) { queue_.purpose = ray::RayClass::shadow; }

    /// Finds the points of a batch whose two horizons differ. The batch must last until the last call for it.
    void prepare(const PointBatch& batch);
    /// The indices of those points in the batch, ascending.
    std::span<const std::uint32_t> points() const { return points_; }
    /// Where rays between the horizons start, from one of those points.
    glm::vec3 origin(std::uint32_t point) const;

    /// Adds the points that a light reaches between the two horizons.
    /// @param lit  ascending, and stays so
    void add_lit(const scene::Light& light, const scene::LightState& at, std::vector<std::uint32_t>& lit);
    /// Where the light arrives at a point that add_lit() added; null: it did not.
    const glm::vec3* lit_origin(std::uint32_t point) const;
    /// Rays of all calls.
    std::uint64_t rays() const { return count_; }

 private:
    struct Added {
        std::uint32_t point;
        glm::vec3 origin;
    };

    const ray::RayScene& rays_;
    PointBatch batch_{};
    std::vector<std::uint32_t> points_, asked_;
    ray::RayQueue queue_;
    std::vector<std::uint8_t> occluded_;
    std::vector<Added> added_;   // by the last add_lit()
    std::vector<std::uint32_t> merged_;
    std::uint64_t count_ = 0;
};

}   // namespace gnomon::trace
