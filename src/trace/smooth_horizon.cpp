// SPDX-License-Identifier: Apache-2.0
#include "trace/smooth_horizon.h"

#include <algorithm>

#include "ray/origin.h"

namespace gnomon::trace {

void SmoothHorizon::prepare(const PointBatch& batch)
{
    points_.clear(), added_.clear();
    for (std::uint32_t p = 0; p < batch.points.size(); ++p) {
        const shading::SurfacePoint& s = batch.points[p].surface;
        if (s.smooth_normal != s.geometric_normal && s.model != scene::ShadingModel::unlit) points_.push_back(p);
    }
    batch_ = batch;
}

glm::vec3 SmoothHorizon::origin(std::uint32_t point) const
{
    const visibility::ShadowPoint& at = batch_.shadow_points[point];
    return shading::smooth_origin(rays_.geometry(at.object), at.triangle, at.u, at.v, batch_.points[point].surface);
}

void SmoothHorizon::add_lit(const scene::Light& light, const scene::LightState& at, std::vector<std::uint32_t>& lit)
{
    added_.clear();
    if (points_.empty()) return;
    const scene::LightReach reach(light, at);
    queue_.clear(), asked_.clear();
    for (const std::uint32_t p : points_) {
        const shading::SurfacePoint& s = batch_.points[p].surface;
        if (!shading::between_horizons(s, reach.from(s.position)) || reach.dark_at(s.position)) continue;
        const glm::vec3 from = origin(p);
        queue_.push(from, 0, reach.from(from), reach.directional() ? k_infinity : ray::k_shadow_ray_end);
        asked_.push_back(p);
    }
    const std::size_t rays = queue_.size();
    if (rays == 0) return;
    count_ += rays;
    occluded_.resize(rays + ray::k_packet_pad);
    rays_.occluded(queue_, 0, rays, occluded_.data());

    // Techniques answer in ascending order, and a point that faces the light with its triangle was not asked here.
    merged_.clear();
    std::size_t next = 0;
    for (std::size_t r = 0; r < rays; ++r) {
        if (occluded_[r]) continue;
        while (next < lit.size() && lit[next] < asked_[r]) merged_.push_back(lit[next++]);
        if (next < lit.size() && lit[next] == asked_[r]) continue;
        merged_.push_back(asked_[r]);
        added_.push_back({asked_[r], queue_.origin(r)});
    }
    merged_.insert(merged_.end(), lit.begin() + static_cast<std::ptrdiff_t>(next), lit.end());
    lit.swap(merged_);
}

const glm::vec3* SmoothHorizon::lit_origin(std::uint32_t point) const
{
    const auto at = std::ranges::lower_bound(added_, point, {}, &Added::point);
    return at != added_.end() && at->point == point ? &at->origin : nullptr;
}

}   // namespace gnomon::trace
