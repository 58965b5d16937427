// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/points.h"

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

// A point is visible if the hit of a ray towards it is within this fraction of its distance.
constexpr float k_same_place = 1e-3f;
constexpr int k_rows_together = 16;

SeenPoint seen_point(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view, const ray::Hit& hit,
                     const glm::vec3& direction, const glm::vec2& place)
{
    SeenPoint seen;
    seen.place = place;
    if (hit.object == scene::none) return seen;
    shading::SurfacePoint s;
    shading::surface_at(scene, rays.geometry(hit.object), hit.triangle, hit.u, hit.v, hit.t, direction,
                        {view.pixel_width, view.pixel_spread}, s);
    seen.point = {s.position, s.geometric_normal, s.normal,   hit.object, hit.triangle, hit.u,
                  hit.v,      s.cone.width,       s.to_viewer};
    seen.diffuse = s.diffuse * s.coverage;
    seen.scatters = s.model != scene::ShadingModel::unlit && s.diffuse != glm::vec3(0);
    return seen;
}

// The normal of a triangle by its winding in world space, not normalised.
glm::vec3 winding_normal(const ray::RayScene& rays, scene::ObjectId object, std::uint32_t triangle)
{
    glm::vec3 p[3];
    rays.geometry(object).corners(triangle, p);
    return glm::cross(p[1] - p[0], p[2] - p[0]);
}

}   // namespace

void see_image(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view, int grid_step,
               Tasks& tasks, SeenImage& out)
{
    // Trace the primary rays in bands of rows.
    out.size = view.size;
    out.view = view;
    out.grid = {};
    if (grid_step > 0) out.grid = trace::cast_indirect_grid(state.scene(), rays, view, grid_step, tasks);
    out.points.assign(out.index(0, view.size.height), {});
    const int bands = (view.size.height + k_rows_together - 1) / k_rows_together;
    tasks.for_each(static_cast<std::size_t>(bands), [&](std::size_t band, int) {
        ray::RayQueue queue;
        ray::Hits hits;
        const int y0 = static_cast<int>(band) * k_rows_together;
        const int y1 = std::min(y0 + k_rows_together, view.size.height);
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < view.size.width; ++x) {
                glm::vec3 origin, direction;
                float tnear, tfar;
                view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
                queue.push(origin, tnear, direction, tfar);
            }
        hits.resize(queue.size());
        rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
        std::size_t i = 0;
        for (int y = y0; y < y1; ++y)
            for (int x = 0; x < view.size.width; ++x, ++i)
                out.points[out.index(x, y)] = seen_point(
                    state.scene(), rays, view, {hits.t[i], hits.u[i], hits.v[i], hits.object[i], hits.triangle[i]},
                    queue.direction(i), {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
    });

    // Collect the diffuse points of each tile.
    const int columns = (view.size.width + k_seen_tile - 1) / k_seen_tile;
    const int rows = (view.size.height + k_seen_tile - 1) / k_seen_tile;
    out.tiles.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    tasks.for_each(out.tiles.size(), [&](std::size_t t, int) {
        SeenTile& tile = out.tiles[t];
        tile.points.clear(), tile.pixels.clear();
        const int x0 = static_cast<int>(t) % columns * k_seen_tile, y0 = static_cast<int>(t) / columns * k_seen_tile;
        for (int y = y0; y < std::min(y0 + k_seen_tile, view.size.height); ++y)
            for (int x = x0; x < std::min(x0 + k_seen_tile, view.size.width); ++x) {
                const SeenPoint& seen = out.points[out.index(x, y)];
                if (!seen.scatters) continue;
                tile.pixels.push_back(out.index(x, y));
                tile.points.push_back(seen.point);
                tile.points.back().x = static_cast<std::int16_t>(x - x0);
                tile.points.back().y = static_cast<std::int16_t>(y - y0);
            }
    });
}

PointGrid grid_of(const SeenImage& image, const ray::RayScene& rays, int step)
{
    PointGrid grid;
    for (int y = step / 2; y < image.size.height; y += step)
        for (int x = step / 2; x < image.size.width; x += step) {
            const std::size_t pixel = image.index(x, y);
            const SeenPoint& seen = image.points[pixel];
            if (!seen.scatters) continue;
            const irradiance_cache::IndirectPoint& p = seen.point;
            const bool front = glm::dot(winding_normal(rays, p.object, p.triangle), p.geometric_normal) > 0;
            grid.points.push_back({p.object, p.triangle, p.u, p.v, front, pixel});
            grid.pixels.push_back(pixel);
        }
    return grid;
}

reference::IrradiancePoint place_of(const scene::Scene& scene, const ray::RayScene& rays, const FixedPoint& point)
{
    const glm::vec3 normal = glm::normalize(winding_normal(rays, point.object, point.triangle));
    return reference::irradiance_point(scene, rays, point.object, point.triangle, point.u, point.v,
                                       point.front ? normal : -normal, point.key);
}

std::vector<SeenPoint> find_again(const scene::Scene& scene, const ray::RayScene& rays, const scene::View& view,
                                  std::span<const FixedPoint> points, std::vector<std::size_t>& seen)
{
    std::vector<SeenPoint> result;
    seen.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const FixedPoint& point = points[i];
        glm::vec3 p[3];
        rays.geometry(point.object).corners(point.triangle, p);
        const glm::vec3 at = (1 - point.u - point.v) * p[0] + point.u * p[1] + point.v * p[2];
        const glm::vec3 side = (point.front ? 1.0f : -1.0f) * winding_normal(rays, point.object, point.triangle);

        // Project the point to the image.
        const float depth = glm::dot(at - view.eye, view.forward);
        if (!(depth > 0) && !view.orthographic) continue;
        const glm::vec3 from_axis = (at - view.eye) - depth * view.forward;
        const float scale = view.orthographic ? 1 : 1 / depth;
        const float px = scale * glm::dot(from_axis, view.right) / glm::dot(view.right, view.right);
        const float py = scale * glm::dot(from_axis, view.up) / glm::dot(view.up, view.up);
        if (!(std::abs(px) < 1) || !(std::abs(py) < 1)) continue;
        const glm::vec2 place(0.5f * (1 + px) * static_cast<float>(view.size.width),
                              0.5f * (1 - py) * static_cast<float>(view.size.height));
        if (!(place.x < static_cast<float>(view.size.width) && place.y < static_cast<float>(view.size.height)))
            continue;

        // Trace a ray there; it must hit the point, from the same side.
        glm::vec3 origin, direction;
        float tnear, tfar;
        view.ray(place.x, place.y, origin, direction, tnear, tfar);
        if (glm::dot(direction, side) >= 0) continue;
        ray::Hit hit = rays.closest_single(origin, tnear, direction, tfar, ray::Sides::front);
        if (hit.object == scene::none) continue;
        const float distance = glm::dot(at - origin, direction);
        if (std::abs(hit.t - distance) > k_same_place * distance) continue;

        // Use the exact position on the surface, which is free of the ray's rounding errors.
        hit.object = point.object, hit.triangle = point.triangle, hit.u = point.u, hit.v = point.v;
        hit.t = distance;
        result.push_back(seen_point(scene, rays, view, hit, direction, place));
        seen.push_back(i);
    }
    return result;
}

}   // namespace gnomon::bench
