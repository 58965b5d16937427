// SPDX-License-Identifier: Apache-2.0
#include "trace/few_places.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "ray/origin.h"

namespace gnomon::trace {

FewPlaces::FewPlaces(const scene::SizedLights& lights, const ray::RayScene& rays) : lights_(lights), rays_(rays)
{
    queue_.purpose = ray::RayClass::shadow;
    subsets_.resize(lights.lights().size());
    for (std::size_t l = 0; l < subsets_.size(); ++l) {
        // Neighbours in the list are neighbours on the light: take the middle one of each run.
        const std::vector<scene::SizedPlace>& all = lights.lights()[l].places;
        for (std::size_t count = 1; count <= all.size(); count *= 2) {
            const std::size_t run = all.size() / count;
            std::vector<scene::SizedPlace>& some = subsets_[l].emplace_back();
            for (std::size_t i = 0; i < count; ++i) {
                some.push_back(all[i * run + run / 2]);
                some.back().area *= static_cast<float>(run);
            }
        }
    }
}

std::size_t FewPlaces::count(std::uint32_t light, const TilePoint& point, float arrives, float image, float share) const
{
    if (!(image > 0)) return 0;
    const float mirrored = std::clamp(k_most_mirrored * share, k_least_mirrored, 1.0f);
    const float steps = (point.lobe.rays > 1 ? k_lobe_steps : k_steps * mirrored) * arrives / image;
    const std::size_t most = std::min(k_most, lights_.lights()[light].places.size());
    if (!(steps <= static_cast<float>(most))) return 0;
    const std::size_t count = std::bit_ceil(static_cast<std::size_t>(std::max(std::ceil(steps), 1.0f)));
    return count <= most ? count : 0;
}

void FewPlaces::clear()
{
    asked_.clear(), seen_.clear(), queue_.clear(), targets_.clear();
}

void FewPlaces::push(std::uint32_t light_index, std::size_t count, std::uint32_t point, const PointBatch& batch)
{
    const scene::SizedLight& light = lights_.lights()[light_index];
    const std::vector<scene::SizedPlace>& places = subsets_[light_index][std::bit_width(count) - 1];
    const std::size_t first = seen_.size();
    asked_.push_back({places, first});
    seen_.resize(first + places.size(), 0);
    const shadow_culling::ShadowPoint& here = batch.shadow_points[point];
    const shading::SurfacePoint& s = batch.points[point].surface;
    const glm::vec3 above = s.smooth_normal == s.geometric_normal
                                ? here.origin
                                : shading::smooth_origin(rays_.geometry(here.object), here.triangle, here.u, here.v, s);
    for (std::size_t i = 0; i < places.size(); ++i) {
        // Skip places that do not face the point, or that it does not face: they have no weight.
        const scene::SizedFace& face = light.faces[places[i].face];
        const glm::vec3& origin = shading::between_horizons(s, places[i].position - s.position) ? above : here.origin;
        const glm::vec3 way = places[i].position - origin;
        if (!(glm::dot(way, s.smooth_normal) > 0) || !(glm::dot(way, s.normal) > 0)) continue;
        if (!face.two_sided && !(glm::dot(way, face.normal) < 0)) continue;
        queue_.push(origin, 0, way, ray::k_shadow_ray_end);
        targets_.push_back(first + i);
    }
}

void FewPlaces::trace()
{
    const std::size_t count = queue_.size();
    if (count == 0) return;
    traced_ += count;
    occluded_.resize(count + ray::k_packet_pad);
    rays_.occluded(queue_, 0, count, occluded_.data());
    for (std::size_t r = 0; r < count; ++r)
        if (!occluded_[r]) seen_[targets_[r]] = 1;
}

}   // namespace gnomon::trace
