// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/placement.h"

#include <algorithm>
#include <cmath>

#include "base/micro_triangles.h"
#include "irradiance_cache/points/slices.h"
#include "ray/directions_above.h"
#include "ray/origin.h"
#include "ray/smooth_surface.h"

namespace gnomon::irradiance_cache {

namespace {

// Geometry covers a point if it lies this near in every direction: in sizes of a part, and in spacings of the lattice.
constexpr float k_covered_part = 1, k_covered_lattice = 0.5f;

// Traces each ray in a packet of its own. Where surfaces coincide, a hit may depend on the other rays of the packet,
// and which points are placed together depends on the threads.
void closest_alone(const ray::RayScene& rays, const ray::RayQueue& queue, ray::Hits& hits, ray::Sides sides)
{
    hits.resize(queue.size());
    for (std::size_t i = 0; i < queue.size(); ++i)
        rays.closest(queue, i, i + 1, hits, sides, ray::Against::static_only);
}

// How much shorter a free distance gets per unit along the lattice's other axis, from the plane of the triangle that
// ends it.
float slope_of_end(const CacheFrame& frame, const CachePoint& point, int way, scene::ObjectId object,
                   std::uint32_t triangle)
{
    constexpr float k_steepest = CachePoint::k_steepest;   // a triangle along the way ends it at an arbitrary place
    glm::vec3 p[3];
    frame.rays->geometry(object).corners(triangle, p);
    const glm::vec3 wall = glm::cross(p[1] - p[0], p[2] - p[0]), &n = point.geometric_normal;
    const int axis = lattice_axis(point.key), along = (axis + 1 + way / 2) % 3, other = (axis + 2 - way / 2) % 3;
    // Intersect the triangle's plane with the point's own.
    const float a = wall[along] - wall[axis] * n[along] / n[axis], b = wall[other] - wall[axis] * n[other] / n[axis];
    return std::abs(b) <= k_steepest * std::abs(a) && a != 0 ? b / a : 0.0f;
}

// Puts a point at the centre of its part, or at a corner.
// @return  the part's size
float place_part(const CacheFrame& frame, CachePoint& point)
{
    const Part part = part_of(point.key);
    const scene::ObjectId object = frame.triangles.object_of(part.triangle);
    const std::uint32_t triangle = part.triangle - frame.triangles.first(object);
    const ray::ObjectGeometry& geometry = frame.rays->geometry(object);
    glm::vec3 p[3];
    geometry.corners(triangle, p);
    glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(normal);
    point.exists = length > 0;
    if (frame.state->is_dynamic(object)) {
        point.version = 0;   // its visible nodes change as it moves
        point.owner = frame.lights.owner_of(object);
    }
    if (!point.exists) {   // as it deforms, it may exist again
        std::fill(std::begin(point.light), std::end(point.light), glm::vec3(0));
        point.facing = glm::vec3(0);
        return 0;
    }
    glm::vec2 uv, at_normal;
    float size;
    if (part.slice) {
        const SliceMiddle middle = middle_of_slice(slender_triangle(p), part);
        uv = at_normal = {middle.weight[1], middle.weight[2]}, size = middle.size;
    } else {
        if (part.corner) {
            uv = place_of_corner(part, k_corner_inset), at_normal = place_of_corner(part, 0);
        } else {
            glm::dvec2 corner[3];
            corners_of(micro_at(part.index, part.level), part.level, corner);
            uv = at_normal = (corner[0] + corner[1] + corner[2]) / 3.0;
        }
        size = std::sqrt(0.5f * length) / std::exp2(static_cast<float>(part.level));
    }
    const float w = 1 - uv.x - uv.y;
    normal /= part.front ? length : -length;
    point.position = w * p[0] + uv.x * p[1] + uv.y * p[2];
    point.lift = ray::origin_lift(p);
    point.geometric_normal = normal;
    point.normal =
        ray::smooth_normal(geometry, triangle, 1 - at_normal.x - at_normal.y, at_normal.x, at_normal.y, normal);
    point.horizon = ray::smooth_horizon(normal, point.normal);
    point.smooth_lift = ray::smooth_lift(geometry, triangle, uv.x, uv.y, normal);
    return size;
}

}   // namespace

void PointPlacer::place(const CacheFrame& frame, std::span<CachePoint* const> claimed)
{
    searching_.clear();
    placed_.clear();
    raised_.clear();
    covering_.clear();
    for (CachePoint* point : claimed) {
        if (!is_lattice(point->key)) {
            const bool is_new = point->version == 0;
            const bool may_move = point->owner != k_no_owner && point->dynamic_version != frame.dynamic_version;
            if (!is_new && !may_move) continue;
            const float size = place_part(frame, *point);
            raised_.push_back(point);
            if (is_new && point->owner == k_no_owner && !is_near(point->key) && size > 0)
                covering_.push_back({point, k_covered_part * size});
        } else if (point->version == 0) {
            point->exists = false;   // a frame that failed may have placed it half
            searching_.push_back({point, 0, 1, 0});
            placed_.push_back(point);
        }
    }
    follow_lines(frame);
    raised_.insert(raised_.end(), placed_.begin(), placed_.end());
    stay_before_surfaces(frame);
    find_free_distances(frame);
    find_covered(frame);
    for (CachePoint* point : claimed)
        if (!point->exists) point->version = frame.lights.geometry_version();
}

// Follows every line through the surfaces that it meets to the one nearest to its middle.
void PointPlacer::follow_lines(const CacheFrame& frame)
{
    constexpr int k_most_surfaces = 6;
    for (int surface = 0; surface < k_most_surfaces && !searching_.empty(); ++surface) {
        rays_.clear();
        for (const Search& search : searching_) {
            const LatticeLine line = lattice_line(search.point->key);
            rays_.push(line.from, search.from, line.direction, 1);
        }
        closest_alone(*frame.rays, rays_, hits_, ray::Sides::front);
        std::size_t kept = 0;
        for (std::size_t s = 0; s < searching_.size(); ++s) {
            Search search = searching_[s];
            if (!accept_hit(frame, search, s)) continue;
            search.from = std::nextafter(hits_.t[s], 2.0f) + 1e-5f;
            if (search.from < 1) searching_[kept++] = search;
        }
        searching_.resize(kept);
    }
}

// Puts the point at a hit if that is the best so far.
// @return  whether the search goes on behind it
bool PointPlacer::accept_hit(const CacheFrame& frame, Search& search, std::size_t ray) const
{
    if (hits_.object[ray] == scene::none) return false;
    const float t = hits_.t[ray], from_middle = std::abs(t - 0.5f);
    if (from_middle >= search.best) return false;   // all further surfaces are further from the middle
    CachePoint& point = *search.point;
    // Among layers so close that points are interpolated across them, keep the outermost, which is the visible one.
    if (point.exists && t - search.found < 0.5f * k_plane_distance) return true;
    search.found = t;
    const ray::ObjectGeometry& geometry = frame.rays->geometry(hits_.object[ray]);
    const std::uint32_t triangle = hits_.triangle[ray];
    glm::vec3 p[3];
    geometry.corners(triangle, p);
    const float u = hits_.u[ray], v = hits_.v[ray], w = std::max(0.0f, 1 - u - v);
    glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(normal);
    if (!(length > 0)) return true;
    normal /= length;
    if (glm::dot(normal, rays_.direction(ray)) > 0) normal = -normal;
    point.exists = true;
    point.position = w * p[0] + u * p[1] + v * p[2];
    point.lift = ray::origin_lift(p);
    point.geometric_normal = normal;
    point.normal = ray::smooth_normal(geometry, triangle, w, u, v, normal);
    point.horizon = ray::smooth_horizon(normal, point.normal);
    point.smooth_lift = ray::smooth_lift(geometry, triangle, u, v, normal);
    search.best = from_middle;
    return true;
}

// Where static geometry stands before the smooth surface, as the ground at the foot of a box with rounded normals does,
// the point lies half-way to it: behind it, its rays would see nothing.
void PointPlacer::stay_before_surfaces(const CacheFrame& frame)
{
    std::erase_if(raised_, [](const CachePoint* p) { return !p->exists || p->smooth_lift == glm::vec3(0); });
    rays_.clear();
    for (const CachePoint* p : raised_) rays_.push(p->position + p->lift * p->geometric_normal, 0, p->smooth_lift, 1);
    closest_alone(*frame.rays, rays_, hits_, ray::Sides::both);
    for (std::size_t i = 0; i < raised_.size(); ++i)
        if (hits_.object[i] != scene::none) raised_[i]->smooth_lift *= 0.5f * hits_.t[i];
}

// Finds how far the surface around a new lattice point is free. Beyond a wall, or from inside one, its irradiance does
// not apply.
void PointPlacer::find_free_distances(const CacheFrame& frame)
{
    constexpr float k_height = 0.02f;   // above the surface, in spacings
    constexpr float k_reach = 1.5f;     // spacings
    rays_.clear();
    for (const CachePoint* point : placed_) {
        if (!point->exists) continue;
        const float h = lattice_spacing(point->key);
        const int axis = lattice_axis(point->key);
        const glm::vec3& n = point->geometric_normal;
        for (int way = 0; way < 4; ++way) {
            const int along = (axis + 1 + way / 2) % 3;
            glm::vec3 d(0);
            d[along] = way % 2 ? 1.0f : -1.0f;
            d[axis] = -d[along] * n[along] / n[axis];   // in the surface's plane
            rays_.push(point->position + (point->lift + k_height * h) * n, 0, d * h, k_reach);
        }
    }
    closest_alone(*frame.rays, rays_, hits_, ray::Sides::both);
    std::size_t r = 0;
    for (CachePoint* point : placed_) {
        if (!point->exists) continue;
        const float h = lattice_spacing(point->key);
        for (int way = 0; way < 4; ++way, ++r) {
            const bool open = hits_.object[r] == scene::none;
            point->free[way] = open ? k_reach * h : hits_.t[r] * h;
            point->set_slope(way, open ? 0 : slope_of_end(frame, *point, way, hits_.object[r], hits_.triangle[r]));
        }
    }
}

// Finds points that other geometry covers, as one tile does the next: what arrives there is not what arrives at the
// surface around. Lattice points do not exist there.
void PointPlacer::find_covered(const CacheFrame& frame)
{
    constexpr std::size_t k_directions = std::tuple_size_v<decltype(ray::directions_above({}))>;
    for (CachePoint* point : placed_)
        if (point->exists) covering_.push_back({point, k_covered_lattice * lattice_spacing(point->key)});
    rays_.clear();
    for (const Covering& c : covering_) {
        const glm::vec3 &n = c.point->geometric_normal, from = c.point->position + c.point->lift * n;
        for (const glm::vec3& d : ray::directions_above(n)) rays_.push(from, 0, d, c.reach);
    }
    occluded_.resize(rays_.size() + ray::k_packet_pad);
    frame.rays->occluded(rays_, 0, rays_.size(), occluded_.data(), ray::Against::static_only);
    for (std::size_t i = 0; i < covering_.size(); ++i) {
        const std::uint8_t* const first = occluded_.data() + i * k_directions;
        const bool covered = std::all_of(first, first + k_directions, [](std::uint8_t o) { return o != 0; });
        CachePoint& point = *covering_[i].point;
        point.covered = covered;
        if (covered && is_lattice(point.key)) point.exists = false;
    }
}

}   // namespace gnomon::irradiance_cache
