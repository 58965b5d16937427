// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_of_points.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

bool includes_near_field(const CacheFrame& frame, const CachePoint& point)
{
    return point.owner == k_no_owner && is_lattice(point.key) && frame.near_field.light().options().radius > 0;
}

bool dynamic_may_occlude_near(const CacheFrame& frame, const CachePoint& point)
{
    if (frame.dynamic_bounds.empty()) return false;
    const glm::vec3* const light = point.static_light;
    if (light[0] == glm::vec3(0) && light[1] == glm::vec3(0) && light[2] == glm::vec3(0)) return false;
    const NearOptions& options = frame.near_field.light().options();
    const float radius = point.near_reach.empty() ? options.radius : farthest_reach(point.near_reach, options.radius);
    if (radius == 0) return false;
    const scene::Scene& scene = frame.state->scene();
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::LightState& at = frame.state->light(l);
        if (!at.visible || scene.lights[l].of_environment) continue;
        const LightWay way = way_to(scene.lights[l], at);
        if (frame.dynamic_bounds.any(
                [&](const Sphere& sphere) { return meets_near_field(sphere, point.origin(), way, radius); },
                [&](const Sphere&, const MovingBox& box) {
                    return meets_near_field(box, point.origin(), way, radius);
                }))
            return true;
    }
    return false;
}

void NearOfPoints::find_static(const CacheFrame& frame, std::span<CachePoint* const> points, CacheCounters& counters)
{
    points_.clear();
    for (CachePoint* point : points) {
        point->near_light = false, point->static_near = glm::vec3(0), point->near_factor = 0;
        if (includes_near_field(frame, *point)) points_.push_back(point);
    }
    gather(frame, Near::of_static, counters);
}

void NearOfPoints::find_now(const CacheFrame& frame, std::span<CachePoint* const> points, CacheCounters& counters)
{
    points_.assign(points.begin(), points.end());
    gather(frame, Near::now, counters);
}

void NearOfPoints::add_found() noexcept
{
    for (std::size_t k = 0; k < points_.size(); ++k) {
        CachePoint& point = *points_[k];
        if (point.owner == k_no_owner) point.near_factor = answers_[k].form_factor;
        for (int colour = 0; colour < 3; ++colour) {
            const glm::vec3& light = answers_[k].light[colour];
            point.static_light[colour] += light;
            if (point.owner != k_no_owner) continue;   // it is complete, and corrected by nothing
            point.static_near[colour] = glm::dot(light, point.normal);
            point.near_light = point.near_light || light != glm::vec3(0);
        }
    }
}

void NearOfPoints::correct(const CacheFrame& frame, std::span<CachePoint* const> points, CacheCounters& counters)
{
    points_.clear();
    for (CachePoint* point : points)
        if (point->near_light && dynamic_may_occlude_near(frame, *point)) points_.push_back(point);
    if (points_.empty()) return;
    gather(frame, Near::change, counters);
    for (std::size_t k = 0; k < points_.size(); ++k)
        for (int colour = 0; colour < 3; ++colour) {
            points_[k]->light[colour] += answers_[k].light[colour];
            points_[k]->near[colour] += glm::dot(answers_[k].light[colour], points_[k]->normal);
        }
}

// Gathers the near fields of points_, or what dynamic objects change of them, some at a time.
void NearOfPoints::gather(const CacheFrame& frame, Near what, CacheCounters& counters)
{
    constexpr std::size_t k_rays = 2048;
    const std::size_t most = std::max<std::size_t>(1, k_rays / static_cast<std::size_t>(frame.options.near_rays));
    answers_.resize(points_.size());
    const NearLight& light = frame.near_field.light();
    for (std::size_t next = 0; next < points_.size();) {
        const std::size_t count = std::min(most, points_.size() - next);
        receivers_.clear();
        for (std::size_t k = next; k < next + count; ++k)
            receivers_.push_back({points_[k]->origin(), points_[k]->normal, points_[k]->horizon});
        if (what == Near::change)
            light.find_change(*frame.state, *frame.rays, frame.dynamic_bounds, receivers_.data(), count, scratch_,
                              answers_.data() + next);
        else
            light.gather(*frame.state, *frame.rays, receivers_.data(), count,
                         what == Near::now ? ray::Against::everything : ray::Against::static_only, scratch_,
                         answers_.data() + next);
        next += count;
    }
    counters.rays += scratch_.cast;
    scratch_.cast = 0;
}

}   // namespace gnomon::irradiance_cache
