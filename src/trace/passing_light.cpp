// SPDX-License-Identifier: Apache-2.0
#include "trace/passing_light.h"

#include <algorithm>
#include <bit>

#include "ray/origin.h"

namespace gnomon::trace {

glm::vec3 PassingLight::from_light(const shading::SurfacePoint& s, const glm::vec3& origin,
                                   const scene::SizedLight& light)
{
    if (!any_) return glm::vec3(1);
    queue_.clear(), weight_.clear();
    const std::size_t step = std::max<std::size_t>(1, (light.places.size() + k_rays - 1) / k_rays);
    for (std::size_t i = step / 2; i < light.places.size(); i += step) {
        const scene::SizedPlace& place = light.places[i];
        const glm::vec3 way = place.position - origin;
        const float square = glm::dot(way, way), cosine = glm::dot(way, s.normal);
        if (!(square > 0) || cosine <= 0 || glm::dot(way, s.smooth_normal) <= 0) continue;
        queue_.push(origin, 0, way, ray::k_shadow_ray_end);
        weight_.push_back(place.area * luminance(place.radiance) * cosine / (square * square));
    }
    return mean();
}

glm::vec3 PassingLight::from_cells(const glm::vec3& normal, const glm::vec3& origin,
                                   const environment_light::DirectionCells& cells, std::span<const std::uint64_t> seen,
                                   std::size_t most)
{
    if (!any_) return glm::vec3(1);
    queue_.clear(), weight_.clear();
    const auto push = [&](std::size_t leaf, float weight) {
        queue_.push(origin, 0, cells.direction(leaf), k_infinity);
        weight_.push_back(weight);
    };
    const auto cosine_of = [&](std::size_t leaf) { return glm::dot(cells.direction(leaf), normal); };
    if (!cells.families().empty() && most == k_rays) {
        // Let the same few cells stand in for the others at each point, so that neighbouring points agree.
        by_stand_in_.assign(cells.leaves(), 0);
        for (std::size_t w = 0; w < seen.size(); ++w)
            for (std::uint64_t word = seen[w]; word != 0; word &= word - 1) {
                const std::size_t leaf = 64 * w + static_cast<std::size_t>(std::countr_zero(word));
                const float cosine = cosine_of(leaf);
                if (!(cosine > 0)) continue;
                const std::size_t stand_in = cells.stand_in_of(leaf);
                by_stand_in_[cosine_of(stand_in) > 0 ? stand_in : leaf] += luminance(cells.flux(leaf)) * cosine;
            }
        for (std::size_t leaf = 0; leaf < by_stand_in_.size(); ++leaf)
            if (by_stand_in_[leaf] > 0) push(leaf, by_stand_in_[leaf]);
        return mean();
    }
    // Ask every so many of the cells; half of them lie above the surface.
    const std::size_t step = std::max<std::size_t>(1, cells.leaves() / (2 * most));
    for (std::size_t leaf = step / 2; leaf < cells.leaves(); leaf += step) {
        if ((seen[leaf / 64] >> (leaf % 64) & 1) == 0) continue;
        if (const float cosine = cosine_of(leaf); cosine > 0) push(leaf, luminance(cells.flux(leaf)) * cosine);
    }
    return mean();
}

glm::vec3 PassingLight::mean()
{
    passes_.resize(weight_.size());
    rays_.let_through(queue_, 0, queue_.size(), passes_.data());
    glm::dvec3 sum(0);
    double all = 0;
    for (std::size_t i = 0; i < weight_.size(); ++i) {
        sum += static_cast<double>(weight_[i]) * glm::dvec3(passes_[i]);
        all += static_cast<double>(weight_[i]);
    }
    return all > 0 ? glm::vec3(sum / all) : glm::vec3(1);
}

}   // namespace gnomon::trace
