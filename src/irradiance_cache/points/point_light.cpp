// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/point_light.h"

#include <algorithm>
#include <cmath>

#include "irradiance_cache/near_field/near_light.h"
#include "irradiance_cache/points/point_device.h"

namespace gnomon::irradiance_cache {

namespace {

// Light below this fraction of the static light is what rounding leaves of light that was taken away.
constexpr float k_rounding = 1e-5f;

// Whether a point's near field is gathered by rays of its own (near_field/), so that nodes provide only the rest.
bool has_near_field(const CacheFrame& frame, const CachePoint& point)
{
    if (point.owner != k_no_owner) return false;
    return !is_lattice(point.key) || frame.near_field.applies_at(lattice_spacing(point.key));
}

// Whether a direction of the sky is above a point's surface.
bool above(const CachePoint& point, const glm::vec3& direction)
{
    return glm::dot(direction, point.horizon) > 0 && glm::dot(direction, point.normal) > 0;
}

}   // namespace

void OcclusionTester::test(const ray::RayQueue& queue, ray::Against against, std::vector<std::uint8_t>& occluded,
                           CacheCounters& counters) const
{
    const std::size_t count = queue.size();
    occluded.resize(count + ray::k_packet_pad);
    if (device)
        device->occluded(queue, occluded.data(), against);
    else
        rays->occluded(queue, 0, count, occluded.data(), against);
    counters.rays += count;
}

void StaticVisibility::clear()
{
    added_.clear();
    rays_.clear();
    nodes_.clear();
    weights_.clear();
}

void StaticVisibility::add(const CacheFrame& frame, CachePoint& point, std::span<const NodeId> cut,
                           std::span<const float> weight)
{
    // The sum is irradiance for the point's own normal. For other normals it must stay bounded at grazing angles.
    constexpr float k_least_cosine = 0.1f;
    const bool near_field = has_near_field(frame, point);
    const float radius = frame.near_field.light().options().radius;
    added_.push_back({&point, nodes_.size()});
    for (std::size_t k = 0; k < cut.size(); ++k) {
        const glm::vec3 to = frame.lights.samples().at(cut[k]) - point.origin();
        const float distance = glm::length(to);
        const float cosine = glm::dot(to, point.normal) / distance;
        if (!(glm::dot(to, point.horizon) > 0) || !(cosine > 0)) continue;
        // Near light is that of light maps.
        const bool of_patch = cut[k] >= frame.lights.first_patch();
        const float fraction = near_field && !of_patch ? far_fraction(distance, radius) : 1;
        if (!(fraction > 0)) continue;
        rays_.push(point.origin(), 0, to, frame.lights.ray_end());
        nodes_.push_back(cut[k]);
        weights_.push_back(fraction * weight[k] / std::max(cosine, k_least_cosine));
    }
}

void StaticVisibility::trace_sky(const CacheFrame& frame, const OcclusionTester& tester, CacheCounters& counters)
{
    const SkyLight& sky = frame.sky;
    if (!sky.any()) return;
    rays_.clear();
    for (const Added& added : added_)
        for (std::size_t i = 0; i < k_sky_directions; ++i)
            if (above(*added.point, sky.direction(i)))
                rays_.push(added.point->origin(), 0, sky.direction(i), k_infinity);
    tester.test(rays_, ray::Against::static_only, occluded_, counters);
    std::size_t r = 0;
    for (const Added& added : added_) {
        CachePoint& point = *added.point;
        point.sky = {};
        for (std::size_t i = 0; i < k_sky_directions; ++i) {
            if (!above(point, sky.direction(i)) || occluded_[r++]) continue;
            point.sky.set(i);
            for (int colour = 0; colour < 3; ++colour)
                point.static_light[colour] += sky.light(i)[colour] * sky.direction(i);
        }
    }
}

void PresentLight::clear()
{
    rays_.clear();
    contributions_.clear();
    bounce_rays_.clear();
    bounces_.clear();
}

void PresentLight::add_if_unoccluded(const CacheFrame& frame, CachePoint& point, NodeId node, const glm::vec3& flux,
                                     const glm::vec3& direction)
{
    rays_.push(point.origin(), 0, frame.lights.samples().at(node) - point.origin(), frame.options.light_tree.ray_end);
    contributions_.push_back({&point, flux, direction});
}

void PresentLight::correct_sky(const CacheFrame& frame, CachePoint& point)
{
    const SkyLight& sky = frame.sky;
    if (!sky.any()) return;
    SkyMask hidden;
    SkyMask near;
    frame.dynamic_bounds.any(
        [&](const Sphere& sphere) {
            near = sky.towards(sphere.centre - point.origin(), sphere.radius) & point.sky;
            return near.any();
        },
        [&](const Sphere&) {
            hidden |= near;
            return false;
        });
    hidden.for_each([&](std::size_t i) {
        point.add_light(-sky.light(i), sky.direction(i));
        rays_.push(point.origin(), 0, sky.direction(i), k_infinity);
        contributions_.push_back({&point, sky.light(i), sky.direction(i)});
    });
}

void PresentLight::add_dynamic_lights(const CacheFrame& frame, CachePoint& point)
{
    if (frame.lights.dynamic_lights().empty()) return;
    const float already = luminance(point.irradiance(point.normal));
    for (const DynamicVirtualLight& light : frame.lights.dynamic_lights()) {
        const glm::vec3 to = light.sample - point.origin();
        const float square = glm::dot(to, to), distance = std::sqrt(square);
        const float cosine = glm::dot(to, point.normal), facing = -glm::dot(to, light.normal);
        if (!(cosine > 0) || !(facing > 0) || !(glm::dot(to, point.horizon) > 0)) continue;
        if (light.owner == point.owner) continue;
        // The kernel of a disk, as for nodes of the tree (point_kernels.h).
        const float kernel = facing / distance / (static_cast<float>(k_pi) * square + light.area);
        const glm::vec3 direction = to * (kernel / distance);
        if (luminance(light.flux) * glm::dot(direction, point.normal) < frame.options.untested * already) {
            point.add_light(light.flux, direction);
            continue;
        }
        bounce_rays_.push(point.origin(), 0, to, frame.options.light_tree.ray_end);
        bounces_.push_back({&point, light.flux, direction});
    }
}

void PresentLight::finish(const OcclusionTester& tester, CacheCounters& counters)
{
    add_arriving(tester, rays_, contributions_, ray::Against::dynamic_only, counters);
    add_arriving(tester, bounce_rays_, bounces_, ray::Against::everything, counters);
}

void PresentLight::add_arriving(const OcclusionTester& tester, const ray::RayQueue& rays,
                                const std::vector<Contribution>& contributions, ray::Against against,
                                CacheCounters& counters)
{
    const std::size_t count = rays.size();
    if (count == 0) return;
    tester.test(rays, against, occluded_, counters);
    counters.rays_dynamic += count;
    for (std::size_t r = 0; r < count; ++r)
        if (!occluded_[r]) contributions[r].point->add_light(contributions[r].flux, contributions[r].direction);
}

void end_corrections(CachePoint& point)
{
    for (int colour = 0; colour < 3; ++colour) {
        glm::vec3& light = point.light[colour];
        const glm::vec3& all = point.static_light[colour];
        if (glm::dot(light, light) < k_rounding * k_rounding * glm::dot(all, all)) light = glm::vec3(0);
    }
}

}   // namespace gnomon::irradiance_cache
