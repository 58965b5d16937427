// SPDX-License-Identifier: Apache-2.0
#include "trace/place_rays.h"

#include <algorithm>

#include "ray/origin.h"

namespace gnomon::trace {

namespace {

constexpr std::size_t k_rays_at_once = 1 << 14;

}   // namespace

void PlaceRays::trace(const PointBatch& batch, const scene::SizedLight& light, std::span<const std::uint32_t> points,
                      std::span<const std::uint32_t> of, ray::Against against, SizedVisible& result)
{
    queue_.clear(), targets_.clear();
    for (const std::uint32_t asked : of) {
        result.add_partial(asked, light.places);
        const shadow_culling::ShadowPoint& here = batch.shadow_points[points[asked]];
        const glm::vec3& normal = batch.normals[points[asked]];
        for (std::uint32_t i = 0; i < light.places.size(); ++i) {
            // Skip places that do not face the point, or that it does not face: they have no weight.
            const scene::SizedPlace& place = light.places[i];
            const scene::SizedFace& face = light.faces[place.face];
            const glm::vec3 to_place = place.position - here.origin;
            if (!(glm::dot(to_place, here.normal) > 0) || !(glm::dot(to_place, normal) > 0)) continue;
            if (!face.two_sided && !(glm::dot(to_place, face.normal) < 0)) continue;
            queue_.push(here.origin, 0, to_place, ray::k_shadow_ray_end);
            targets_.emplace_back(asked, i);
        }
        if (queue_.size() >= k_rays_at_once) flush(against, result);
    }
    flush(against, result);
    for (const std::uint32_t asked : of)
        if (std::ranges::all_of(result.seen_by(asked), [](std::uint8_t seen) { return seen == 0; }))
            result.answer[asked] = SizedVisible::Answer::dark;
}

void PlaceRays::flush(ray::Against against, SizedVisible& result)
{
    const std::size_t count = queue_.size();
    if (count == 0) return;
    traced_ += count;
    if (against == ray::Against::dynamic_only) traced_dynamic_only_ += count;
    occluded_.resize(count + ray::k_packet_pad);
    rays_.occluded(queue_, 0, count, occluded_.data(), against);
    for (std::size_t r = 0; r < count; ++r) {
        if (occluded_[r]) continue;
        const auto [asked, place] = targets_[r];
        result.seen[result.first[asked] + place] = SizedVisible::k_whole;
    }
    queue_.clear(), targets_.clear();
}

}   // namespace gnomon::trace
