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
    queue_.clear(), weight_.clear(), leaves_.clear();
    for (std::size_t w = 0; w < seen.size(); ++w)
        for (std::uint64_t word = seen[w]; word != 0; word &= word - 1) {
            const std::size_t leaf = 64 * w + static_cast<std::size_t>(std::countr_zero(word));
            if (glm::dot(cells.direction(leaf), normal) > 0) leaves_.push_back(static_cast<std::uint32_t>(leaf));
        }
    const auto weight_of = [&](std::uint32_t leaf) {
        return luminance(cells.flux(leaf)) * glm::dot(cells.direction(leaf), normal);
    };
    const auto push = [&](std::uint32_t leaf, float weight) {
        queue_.push(origin, 0, cells.direction(leaf), k_infinity);
        weight_.push_back(weight);
    };
    if (!cells.families().empty() && most == k_rays) {
        // The same few cells stand in for the others at each point, so that neighbouring points agree.
        by_stand_in_.assign(cells.leaves(), 0);
        for (const std::uint32_t leaf : leaves_) {
            const std::size_t stand_in = cells.stand_in_of(leaf);
            by_stand_in_[glm::dot(cells.direction(stand_in), normal) > 0 ? stand_in : leaf] += weight_of(leaf);
        }
        for (std::uint32_t leaf = 0; leaf < by_stand_in_.size(); ++leaf)
            if (by_stand_in_[leaf] > 0) push(leaf, by_stand_in_[leaf]);
        return mean();
    }
    const std::size_t step = std::max<std::size_t>(1, (leaves_.size() + most - 1) / most);
    for (std::size_t i = step / 2; i < leaves_.size(); i += step) push(leaves_[i], weight_of(leaves_[i]));
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
