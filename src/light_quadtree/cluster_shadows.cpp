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

glm::vec3 origin_of(const glm::vec3& at, const glm::vec3& facing)
{
    const glm::vec3 size = glm::abs(at);
    return at + k_lift * std::max({size.x, size.y, size.z}) * facing;
}

// The ray from a receiver to a cluster.
struct PathRay {
    glm::vec3 origin, direction;
    float end;   // of the direction
};
PathRay path_ray(const Clusters& clusters, std::size_t c, const glm::vec3& at, const glm::vec3& facing)
{
    const glm::vec3 origin = origin_of(at, facing);
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

ShadowCounters& ShadowCounters::operator+=(const ShadowCounters& more)
{
    pairs += more.pairs;
    rays += more.rays;
    rays_dynamic += more.rays_dynamic;
    left_out += more.left_out;
    return *this;
}

void PathModes::follow(const Clusters& clusters)
{
    ++version_;
    before_.assign(clusters.size(), scene::none);
    std::unordered_map<std::size_t, End> ends;
    ends.reserve(clusters.size());
    for (std::size_t c = 0; c < clusters.size(); ++c) {
        const End now{c, position_of(clusters, c), clusters.disk[c]};
        if (const auto last = ends_.find(clusters.node[c]);
            last != ends_.end() && last->second.position == now.position && last->second.disk == now.disk)
            before_[c] = static_cast<std::uint32_t>(last->second.place);
        ends.emplace(clusters.node[c], now);
    }
    ends_ = std::move(ends);
}

void PathModes::forget()
{
    for (Row& row : rows_) row.version_ = 0;
}

PathModes::Row* PathModes::of(std::size_t receiver, const glm::vec3& position, const glm::vec3& normal)
{
    Row& row = rows_[receiver];
    const bool same = row.is_of(position, normal);
    if (!same && row.asked_ == frame_) return nullptr;
    row.asked_ = frame_;
    if (same && row.version_ == version_) return &row;
    Row now;
    now.position_ = position, now.normal_ = normal, now.version_ = version_, now.asked_ = frame_;
    now.modes_.assign((before_.size() + 3) / 4, 0);
    if (same && row.version_ != 0 && row.version_ + 1 == version_)
        for (std::size_t c = 0; c < before_.size(); ++c)
            if (before_[c] != scene::none) now.set(c, row.get(before_[c]));
    row = std::move(now);
    return &row;
}

std::size_t PathModes::bytes() const
{
    std::size_t bytes = rows_.size() * sizeof(Row);
    for (const Row& row : rows_) bytes += row.modes_.size();
    return bytes;
}

namespace {

// The box of the origins of the rays of some receivers.
Box3 box_of_origins(const Receivers& receivers, std::size_t begin, std::size_t end)
{
    Box3 box;
    for (std::size_t i = begin; i < end; ++i)
        if (const glm::vec3 facing = normal_of(receivers, i); facing != glm::vec3(0))
            box.add(origin_of(position_of(receivers, i), facing));
    return box;
}

}   // namespace

void gather_with_shadows(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end,
                         const ray::RayScene& rays, const ShadowKnowledge& known, ShadowScratch& scratch)
{
    std::vector<glm::vec3> sum(end - begin, glm::vec3(0));
    scratch.queue.purpose = ray::RayClass::indirect;
    const auto row_of = [&](std::uint32_t i) { return known.rows.empty() ? nullptr : known.rows[i - begin]; };
    const auto queue = [&](std::uint32_t i, const PathRay& ray) {
        scratch.queue.push(ray.origin, 0, ray.direction, ray.end);
        scratch.receiver.push_back(i);
    };
    // Traces the rays in the queue, and calls act(receiver, occluded).
    const auto trace = [&](ray::Against against, const auto& act) {
        if (scratch.queue.empty()) return;
        scratch.occluded.resize(scratch.queue.size() + ray::k_packet_pad);
        rays.occluded(scratch.queue, 0, scratch.queue.size(), scratch.occluded.data(), against);
        for (std::size_t r = 0; r < scratch.queue.size(); ++r) act(scratch.receiver[r], scratch.occluded[r] != 0);
        scratch.queue.clear(), scratch.receiver.clear();
    };
    const Box3 origins = known.dynamic ? box_of_origins(receivers, begin, end) : Box3{};
    std::vector<std::uint32_t> free,
        everything;   // receivers: past static geometry, and of which nothing is remembered
    for (std::size_t c = 0; c < clusters.size(); ++c) {
        interruption_point();
        const auto lit = [&](std::uint32_t i) {
            add_light(clusters, c, position_of(receivers, i), normal_of(receivers, i), sum[i - begin]);
        };
        const auto ray_of = [&](std::uint32_t i) {
            return path_ray(clusters, c, position_of(receivers, i), normal_of(receivers, i));
        };

        // Sort the receivers that face the cluster by what is known of their paths.
        free.clear(), everything.clear();
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
            if (!face_each_other(clusters, c, position_of(receivers, i), normal_of(receivers, i))) continue;
            ++scratch.counters.pairs;
            const PathModes::Row* const row = row_of(i);
            const PathMode mode = row ? row->get(c) : PathMode::unknown;
            if (!row)
                everything.push_back(i);
            else if (mode == PathMode::full_shadow)
                ++scratch.counters.left_out;
            else if (mode == PathMode::non_shadow)
                free.push_back(i);
            else
                queue(i, ray_of(i));
        }

        // Remember what static geometry does to paths of which nothing is known.
        scratch.counters.rays += scratch.queue.size() + everything.size();
        const std::size_t proven = free.size();
        trace(ray::Against::static_only, [&](std::uint32_t i, bool occluded) {
            row_of(i)->set(c, occluded ? PathMode::full_shadow : PathMode::non_shadow);
            if (!occluded) free.push_back(i);
        });

        // Test those that are free against dynamic objects, where they meet the box of one.
        const bool all_near = known.dynamic == nullptr;
        if (!free.empty() && !all_near) known.dynamic->select(origins, position_of(clusters, c), false, scratch.boxes);
        for (std::size_t k = 0; k < free.size(); ++k) {
            const PathRay ray = ray_of(free[k]);
            if (all_near || std::any_of(scratch.boxes.begin(), scratch.boxes.end(), [&](const Box3& box) {
                    return visibility::segment_meets(box, ray.origin, ray.direction, ray.end);
                })) {
                queue(free[k], ray);
                continue;
            }
            scratch.counters.left_out += k < proven;
            lit(free[k]);
        }
        scratch.counters.rays_dynamic += scratch.queue.size();
        const auto add_if_free = [&](std::uint32_t i, bool occluded) {
            if (!occluded) lit(i);
        };
        trace(ray::Against::dynamic_only, add_if_free);
        for (const std::uint32_t i : everything) queue(i, ray_of(i));
        trace(ray::Against::everything, add_if_free);
    }
    for (std::size_t i = begin; i < end; ++i)
        receivers.r[i] = sum[i - begin].x, receivers.g[i] = sum[i - begin].y, receivers.b[i] = sum[i - begin].z;
}

}   // namespace gnomon::light_quadtree
