// SPDX-License-Identifier: Apache-2.0
#include "patches/open_places.h"

#include <algorithm>
#include <utility>

#include "base/interruption.h"

namespace gnomon::patches {

namespace {

constexpr std::size_t k_patches_at_once = 512;   // by a thread
constexpr float k_near = 1.0f;                   // what covers a place from outside, in radii of the patch

// Whether a ray ends on the inside of an object.
bool ends_inside(const ray::RayScene& rays, const ray::RayQueue& queue, const ray::Hits& hits, std::size_t r)
{
    const ray::ObjectGeometry& geometry = rays.geometry(hits.object[r]);
    glm::vec3 p[3];
    geometry.corners(hits.triangle[r], p);
    const glm::vec3 winding = glm::cross(p[1] - p[0], p[2] - p[0]);
    return glm::dot(geometry.mirrored ? -winding : winding, queue.direction(r)) > 0;
}

// The part of a patch that is open.
float open_part(const SurfacePatches& patches, const Patch& patch, const ray::RayScene& rays)
{
    float open = 0, all = 0;
    for (const PatchPlace& place : patches.places(patch)) {
        all += place.area;
        if (!is_covered(rays, place.position, place.normal, k_near * patch.radius)) open += place.area;
    }
    return all > 0 ? open / all : 1;
}

}   // namespace

bool is_covered(const ray::RayScene& rays, const glm::vec3& place, const glm::vec3& normal, float near)
{
    glm::vec3 x, y;
    make_basis(normal, x, y);
    ray::RayQueue queue;
    queue.purpose = ray::RayClass::indirect;
    for (const glm::vec3& aside : {glm::vec3(0), x, -x, y, -y})
        queue.push(place, 0, glm::normalize(normal + aside), k_infinity);
    ray::Hits hits;
    hits.resize(queue.size());
    // Most places are open along their normal.
    for (const auto& [begin, end] : {std::pair<std::size_t, std::size_t>{0, 1}, {1, queue.size()}}) {
        rays.closest(queue, begin, end, hits, ray::Sides::both, ray::Against::dynamic_only);
        for (std::size_t r = begin; r < end; ++r)
            if (hits.object[r] == scene::none || !(hits.t[r] < near || ends_inside(rays, queue, hits, r))) return false;
    }
    return true;
}

std::vector<float> open_parts(const SurfacePatches& patches, const ray::RayScene& rays,
                              std::span<const BoundingSphere> spheres, Tasks& tasks)
{
    const std::size_t count = patches.patches().size();
    std::vector<float> open(spheres.empty() ? 0 : count, 1.0f);
    tasks.for_each((open.size() + k_patches_at_once - 1) / k_patches_at_once, [&](std::size_t run, int) {
        interruption_point();
        const std::size_t last = std::min((run + 1) * k_patches_at_once, count);
        for (std::size_t p = run * k_patches_at_once; p < last; ++p) {
            const Patch& patch = patches.patches()[p];
            const auto meets = [&](const BoundingSphere& sphere) {
                const float within = sphere.radius + patch.radius;
                const glm::vec3 to = sphere.centre - patch.position;
                return glm::dot(to, to) < within * within;
            };
            if (std::ranges::any_of(spheres, meets)) open[p] = open_part(patches, patch, rays);
        }
    });
    if (std::ranges::all_of(open, [](float part) { return part == 1; })) open.clear();
    return open;
}

}   // namespace gnomon::patches
