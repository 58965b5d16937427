// SPDX-License-Identifier: Apache-2.0
// Lattice points in the visible scheme: which surface a new one lies on, and how far it is open along it.
#include <algorithm>
#include <cmath>

#include "irradiance_cache/irradiance_cache.h"
#include "ray/origin.h"

namespace gnomon::irradiance_cache {

namespace {

// Each ray in a packet of its own: where surfaces tie, what a ray meets may depend on its company, and which points are
// asked together is chance.
void closest_alone(const ray::RayScene& rays, const ray::RayQueue& queue, ray::Hits& hits, ray::Sides sides)
{
    for (std::size_t i = 0; i < queue.size(); ++i)
        rays.closest(queue, i, i + 1, hits, sides, ray::Against::static_only);
}

}   // namespace

// Finds the surfaces of new anchors.
void VisibleLight::place(Batch& batch)
{
    batch.searching.clear();
    batch.placed.clear();
    for (RememberedPoint* point : batch.claimed) {
        if (!is_lattice(point->key)) {
            // Again whenever it may have moved.
            if (point->version == 0 || point->dynamic_version != dynamic_version_) place_part(*point);
            continue;
        }
        if (point->version != 0) continue;
        batch.searching.push_back({point, 0, 1, 0});
        batch.placed.push_back(point);
    }
    // Follow every line through the surfaces it meets to the one nearest to its middle.
    constexpr int k_most_surfaces = 6;
    for (int surface = 0; surface < k_most_surfaces && !batch.searching.empty(); ++surface) {
        batch.rays.clear();
        for (const Batch::Search& search : batch.searching) {
            const LatticeLine line = lattice_line(search.point->key);
            batch.rays.push(line.from, search.from, line.direction, 1);
        }
        batch.hits.resize(batch.rays.size());
        closest_alone(*rays_, batch.rays, batch.hits, ray::Sides::front);
        std::size_t kept = 0;
        for (std::size_t s = 0; s < batch.searching.size(); ++s) {
            Batch::Search search = batch.searching[s];
            const ray::Hits& hits = batch.hits;
            if (hits.object[s] == scene::none) continue;
            const float from_middle = std::abs(hits.t[s] - 0.5f);
            if (from_middle >= search.best) continue;   // further surfaces lie further still
            // Of layers that a point may be interpolated across, the outermost is the one that is seen.
            if (search.point->exists && hits.t[s] - search.found < 0.5f * k_plane) {
                search.from = std::nextafter(hits.t[s], 2.0f) + 1e-5f;
                if (search.from < 1) batch.searching[kept++] = search;
                continue;
            }
            search.found = hits.t[s];
            const ray::ObjectGeometry& geometry = rays_->geometry(hits.object[s]);
            glm::vec3 p[3];
            geometry.corners(hits.triangle[s], p);
            const float u = hits.u[s], v = hits.v[s], w = std::max(0.0f, 1 - u - v);
            glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const float length = glm::length(normal);
            if (length > 0) {
                normal /= length;
                if (glm::dot(normal, batch.rays.direction(s)) > 0) normal = -normal;
                RememberedPoint& point = *search.point;
                point.exists = true;
                point.position = w * p[0] + u * p[1] + v * p[2];
                point.lift = ray::origin_lift(p);
                point.geometric_normal = point.normal = normal;
                if (geometry.normals) {
                    const glm::uvec3 index = geometry.mesh->triangles[hits.triangle[s]];
                    glm::vec3 n = w * geometry.normals[index[0]] + u * geometry.normals[index[1]] +
                                  v * geometry.normals[index[2]];
                    if (geometry.normal_to_world) n = *geometry.normal_to_world * n;
                    if (glm::dot(n, normal) < 0) n = -n;
                    if (glm::dot(n, n) > 0) point.normal = glm::normalize(n);
                }
                search.best = from_middle;
            }
            search.from = std::nextafter(hits.t[s], 2.0f) + 1e-5f;
            if (search.from < 1) batch.searching[kept++] = search;
        }
        batch.searching.resize(kept);
    }
    open_ways(batch);
}

// How far a new lattice point can be seen along the surface: beyond a wall, or from inside one, its light says nothing.
void VisibleLight::open_ways(Batch& batch)
{
    constexpr float k_height = 0.02f;   // above the surface, in spacings
    constexpr float k_reach = 1.5f;     // spacings
    batch.rays.clear();
    for (const RememberedPoint* point : batch.placed) {
        if (!point->exists) continue;
        const float h = lattice_spacing(point->key);
        const int axis = lattice_axis(point->key);
        const glm::vec3& n = point->geometric_normal;
        for (int way = 0; way < 4; ++way) {
            const int along = (axis + 1 + way / 2) % 3;
            glm::vec3 d(0);
            d[along] = way % 2 ? 1.0f : -1.0f;
            d[axis] = -d[along] * n[along] / n[axis];   // in the surface's plane
            batch.rays.push(point->origin() + k_height * h * n, 0, d * h, k_reach);
        }
    }
    batch.hits.resize(batch.rays.size());
    closest_alone(*rays_, batch.rays, batch.hits, ray::Sides::both);
    std::size_t r = 0;
    for (RememberedPoint* point : batch.placed) {
        if (!point->exists) continue;
        const float h = lattice_spacing(point->key);
        for (int way = 0; way < 4; ++way, ++r) {
            const bool open = batch.hits.object[r] == scene::none;
            point->free[way] = open ? k_reach * h : batch.hits.t[r] * h;
            point->set_slope(way, open ? 0 : slope_of_end(*point, way, batch.hits.object[r], batch.hits.triangle[r]));
        }
    }
}

// How much shorter a way is a unit further along the lattice's other axis: as the triangle stands that ends it.
float VisibleLight::slope_of_end(const RememberedPoint& point, int way, scene::ObjectId object,
                                 std::uint32_t triangle) const
{
    constexpr float k_steepest = RememberedPoint::k_steepest;   // what stands along the way ends it by chance
    glm::vec3 p[3];
    rays_->geometry(object).corners(triangle, p);
    const glm::vec3 wall = glm::cross(p[1] - p[0], p[2] - p[0]), &n = point.geometric_normal;
    const int axis = lattice_axis(point.key), along = (axis + 1 + way / 2) % 3, other = (axis + 2 - way / 2) % 3;
    // The plane's trace on the point's own.
    const float a = wall[along] - wall[axis] * n[along] / n[axis], b = wall[other] - wall[axis] * n[other] / n[axis];
    return std::abs(b) <= k_steepest * std::abs(a) && a != 0 ? b / a : 0.0f;
}

}   // namespace gnomon::irradiance_cache
