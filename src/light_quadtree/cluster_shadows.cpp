// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/cluster_shadows.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"
#include "ray/origin.h"

namespace gnomon::light_quadtree {

namespace {

// A ray ends this far before the cluster's mean position, in radii of its disk, because the mean of positions on
// several surfaces lies behind some of them; but it has at least this part of the way to go.
constexpr float k_radii = 1, k_least_way = 0.5f;

// A ray starts this far off the receiver, as a fraction of its largest coordinate: interpolated positions are off their
// triangles' planes by a few units in the last place.
constexpr float k_lift = 4 * ray::k_lift_per_coordinate;

glm::vec3 position_of(const Receivers& receivers, std::size_t i)
{
    return {receivers.x[i], receivers.y[i], receivers.z[i]};
}

glm::vec3 normal_of(const Receivers& receivers, std::size_t i)
{
    return {receivers.nx[i], receivers.ny[i], receivers.nz[i]};
}

glm::vec3 position_of(const Clusters& clusters, std::size_t c)
{
    return {clusters.x[c], clusters.y[c], clusters.z[c]};
}

// The ray from a receiver to a cluster.
struct PathRay {
    glm::vec3 origin, direction;
    float end;   // of the direction
};
PathRay path_ray(const Clusters& clusters, std::size_t c, const glm::vec3& at, const glm::vec3& facing)
{
    const glm::vec3 size = glm::abs(at);
    const glm::vec3 origin = at + k_lift * std::max({size.x, size.y, size.z}) * facing;
    const glm::vec3 way = position_of(clusters, c) - origin;
    const float before = k_radii * std::sqrt(clusters.disk[c] / std::max(glm::dot(way, way), 1e-30f));
    return {origin, way, std::max(k_least_way, 1 - before) * ray::k_shadow_ray_end};
}

bool face_each_other(const Clusters& clusters, std::size_t c, const glm::vec3& at, const glm::vec3& facing)
{
    const glm::vec3 normal(clusters.nx[c], clusters.ny[c], clusters.nz[c]), way = position_of(clusters, c) - at;
    return glm::dot(way, facing) > 0 && glm::dot(way, normal) < 0;
}

}   // namespace

bool cluster_visible(const Clusters& clusters, std::size_t c, const glm::vec3& position, const glm::vec3& normal,
                     const ray::RayScene& rays)
{
    if (!face_each_other(clusters, c, position, normal)) return false;
    const PathRay ray = path_ray(clusters, c, position, normal);
    return !rays.occluded_single(ray.origin, 0, ray.direction, ray.end);
}

void PathModes::follow(const Clusters& clusters, const Receivers& receivers)
{
    // Find the receivers and clusters that have not moved.
    const std::size_t count = receivers.x.size();
    std::vector<std::uint8_t> same(count, 0);
    if (position_.size() == count)
        for (std::size_t i = 0; i < count; ++i)
            same[i] = position_[i] == position_of(receivers, i) && normal_[i] == normal_of(receivers, i);
    std::vector<PathMode> modes(clusters.size() * count, PathMode::unknown);
    std::unordered_map<std::size_t, std::size_t> found;
    for (std::size_t c = 0; c < clusters.size(); ++c) {
        found.emplace(clusters.node[c], c);
        const auto before = found_.find(clusters.node[c]);
        if (before == found_.end() || position_.size() != count) continue;
        if (cluster_position_[before->second] != position_of(clusters, c)) continue;
        for (std::size_t i = 0; i < count; ++i)
            if (same[i]) modes[c * count + i] = modes_[before->second * receivers_ + i];
    }

    // Note them for the next time.
    modes_ = std::move(modes), found_ = std::move(found), receivers_ = count;
    position_.resize(count), normal_.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        position_[i] = position_of(receivers, i), normal_[i] = normal_of(receivers, i);
    cluster_position_.resize(clusters.size());
    for (std::size_t c = 0; c < clusters.size(); ++c) cluster_position_[c] = position_of(clusters, c);
}

void gather_with_shadows(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end,
                         const ray::RayScene& rays, PathModes* modes, ShadowScratch& scratch)
{
    std::vector<glm::vec3> sum(end - begin, glm::vec3(0));
    scratch.queue.purpose = ray::RayClass::indirect;
    // Traces the rays of one cluster, and calls act(receiver, occluded).
    const auto trace = [&](ray::Against against, const auto& act) {
        if (scratch.queue.empty()) return;
        scratch.occluded.resize(scratch.queue.size() + ray::k_packet_pad);
        rays.occluded(scratch.queue, 0, scratch.queue.size(), scratch.occluded.data(), against);
        for (std::size_t r = 0; r < scratch.queue.size(); ++r) act(scratch.receiver[r], scratch.occluded[r] != 0);
        scratch.queue.clear(), scratch.receiver.clear();
    };
    std::vector<std::uint32_t> dynamic;
    for (std::size_t c = 0; c < clusters.size(); ++c) {
        interruption_point();
        const auto lit = [&](std::uint32_t i) {
            add_light(clusters, c, position_of(receivers, i), normal_of(receivers, i), sum[i - begin]);
        };
        const auto queue = [&](std::uint32_t i) {
            const PathRay ray = path_ray(clusters, c, position_of(receivers, i), normal_of(receivers, i));
            scratch.queue.push(ray.origin, 0, ray.direction, ray.end);
            scratch.receiver.push_back(i);
        };

        // Sort the receivers that face the cluster by what is known of their paths.
        dynamic.clear();
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
            if (!face_each_other(clusters, c, position_of(receivers, i), normal_of(receivers, i))) continue;
            ++scratch.counters.rays;
            const PathMode known = modes ? modes->mode(c, i) : PathMode::unknown;
            if (known == PathMode::full_shadow)
                ++scratch.counters.rays_skipped;
            else if (known == PathMode::non_shadow)
                dynamic.push_back(i);
            else
                queue(i);
        }
        scratch.counters.rays_dynamic_only += dynamic.size();
        if (modes) {
            // Remember what static geometry does, and test the rest against dynamic objects.
            trace(ray::Against::static_only, [&](std::uint32_t i, bool occluded) {
                modes->mode(c, i) = occluded ? PathMode::full_shadow : PathMode::non_shadow;
                if (!occluded) dynamic.push_back(i);
            });
            for (const std::uint32_t i : dynamic) queue(i);
            trace(ray::Against::dynamic_only, [&](std::uint32_t i, bool occluded) {
                if (!occluded) lit(i);
            });
        } else {
            trace(ray::Against::everything, [&](std::uint32_t i, bool occluded) {
                if (!occluded) lit(i);
            });
        }
    }
    for (std::size_t i = begin; i < end; ++i)
        receivers.r[i] = sum[i - begin].x, receivers.g[i] = sum[i - begin].y, receivers.b[i] = sum[i - begin].z;
}

}   // namespace gnomon::light_quadtree
