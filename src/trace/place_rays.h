// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shadow rays from points of a batch to the sample places of a light with size.
//
// Cost: a ray per point and place that face each other.

#include <span>
#include <utility>
#include <vector>

#include "trace/sized_visibility.h"

namespace gnomon::trace {

/// One per thread.
class PlaceRays {
 public:
    explicit PlaceRays(const ray::RayScene& rays) : rays_(rays) { queue_.purpose = ray::RayClass::shadow; }

    /// Answers for asked points: dark, or partial with the places that no ray found occluded.
    /// @param points  all asked points, indices in the batch
    /// @param of      those to answer, indices in `points`
    void trace(const PointBatch& batch, const scene::SizedLight& light, std::span<const std::uint32_t> points,
               std::span<const std::uint32_t> of, ray::Against against, SizedVisible& result);

    std::uint64_t traced() const { return traced_; }
    std::uint64_t traced_dynamic_only() const { return traced_dynamic_only_; }

 private:
    void flush(ray::Against against, SizedVisible& result);

    const ray::RayScene& rays_;
    ray::RayQueue queue_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> targets_;   // by ray: asked point, place
    std::vector<std::uint8_t> occluded_;
    std::uint64_t traced_ = 0, traced_dynamic_only_ = 0;
};

}   // namespace gnomon::trace
