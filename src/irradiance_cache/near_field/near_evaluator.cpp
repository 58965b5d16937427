// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_evaluator.h"

#include <algorithm>

#include "base/interruption.h"

namespace gnomon::irradiance_cache {

namespace {

// Whether a dynamic object may come between the point and surfaces near it, or between those surfaces and a light.
bool dynamic_may_occlude(const CacheFrame& frame, const CachePoint& point)
{
    if (frame.dynamic_bounds.empty()) return false;
    const glm::vec3* const light = point.static_light;
    if (light[0] == glm::vec3(0) && light[1] == glm::vec3(0) && light[2] == glm::vec3(0)) return false;
    const float radius = frame.near_field.light().options().radius;
    const scene::Scene& scene = frame.state->scene();
    // Does a sphere meet the near field around the way from the point to `way` beyond it, or without an end?
    const auto meets = [&](const Sphere& sphere, const glm::vec3& way, bool endless) {
        const glm::vec3 at = sphere.centre - point.origin();
        const float square = glm::dot(way, way);
        float along = square > 0 ? std::max(glm::dot(at, way) / square, 0.0f) : 0.0f;
        if (!endless) along = std::min(along, 1.0f);
        const glm::vec3 off = at - along * way;
        const float reach = sphere.radius + radius;
        return glm::dot(off, off) <= reach * reach;
    };
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::LightState& at = frame.state->light(l);
        if (!at.visible || scene.lights[l].of_environment) continue;
        const bool endless = scene.lights[l].type == scene::LightType::directional;
        const glm::vec3 way = endless ? -at.direction : at.position - point.origin();
        if (frame.dynamic_bounds.any([&](const Sphere& sphere) { return meets(sphere, way, endless); },
                                     [](const Sphere&) { return true; }))
            return true;
    }
    return false;
}

}   // namespace

// Gathers the near field of those near-field points that are wanted, some at a time, and stores the answers.
template <class Wanted, class Store>
void NearEvaluator::gather(const CacheFrame& frame, std::span<CachePoint* const> claimed, ray::Against against,
                           const Wanted& wanted, const Store& store, CacheCounters& counters)
{
    constexpr std::size_t k_rays = 2048;
    const std::size_t most = std::max<std::size_t>(1, k_rays / static_cast<std::size_t>(frame.options.near_rays));
    std::size_t next = 0;
    while (next < claimed.size()) {
        interruption_point();   // every point is either complete or untouched here
        points_.clear();
        receivers_.clear();
        for (; next < claimed.size() && points_.size() < most; ++next) {
            CachePoint& point = *claimed[next];
            if (!point.exists || !is_near(point.key) || !wanted(point)) continue;
            points_.push_back(&point);
            receivers_.push_back({point.origin(), point.normal, point.horizon});
        }
        answers_.resize(points_.size());
        frame.near_field.light().gather(*frame.state, *frame.rays, receivers_.data(), receivers_.size(), against,
                                        scratch_, answers_.data());
        for (std::size_t k = 0; k < points_.size(); ++k) store(*points_[k], answers_[k]);
    }
    counters.rays += scratch_.cast;
    scratch_.cast = 0;
}

void NearEvaluator::evaluate(const CacheFrame& frame, std::span<CachePoint* const> claimed, CacheCounters& counters)
{
    if (!frame.near_field.hints()) return;
    const std::uint32_t version = frame.lights.geometry_version();
    // Gather the near field of static geometry for new points.
    gather(
        frame, claimed, ray::Against::static_only, [&](const CachePoint& point) { return point.version != version; },
        [&](CachePoint& point, const NearAnswer& answer) {
            std::copy(answer.light, answer.light + 3, point.static_light);
            point.free[0] = answer.nearest;
            point.version = version;
            point.dynamic_version = 0;
            ++counters.near_points;
        },
        counters);
    // Gather it again where a dynamic object may occlude it.
    gather(
        frame, claimed, ray::Against::everything,
        [&](CachePoint& point) {
            if (point.dynamic_version == frame.dynamic_version) return false;
            point.dynamic_version = frame.dynamic_version;
            std::copy(point.static_light, point.static_light + 3, point.light);
            return dynamic_may_occlude(frame, point);
        },
        [&](CachePoint& point, const NearAnswer& answer) { std::copy(answer.light, answer.light + 3, point.light); },
        counters);
}

}   // namespace gnomon::irradiance_cache
