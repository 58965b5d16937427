// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_blend.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

namespace {

// How much more of what is around a surface point may be near than at the lattice points, as a fraction of what is
// there: a small part of it tells little of the rest.
constexpr float k_most_more = 1;
// What left the light from beyond has at least this fraction of the exitance of what is near lattice points.
constexpr float k_least_like = 0.5f;

}   // namespace

void NearBlend::begin(std::size_t points)
{
    for (const std::uint32_t p : points_) sums_[p] = {};
    points_.clear();
    if (sums_.size() < points) sums_.resize(points);
}

void NearBlend::add(std::uint32_t point, float weight, float known, const CachePoint& near, const glm::vec3& normal)
{
    Sum& sum = sums_[point];
    if (!sum.any) points_.push_back(point);
    sum.any = true;
    sum.light += weight * near.irradiance(normal);
    sum.factor += weight * near.near_factor;
    sum.known_factor += known * near.near_factor;
    sum.known += known;
}

void NearBlend::finish(const glm::vec4* known, const float* share, glm::vec3* irradiance)
{
    for (const std::uint32_t p : points_) {
        const Sum& sum = sums_[p];
        glm::vec3& all = irradiance[p];
        if (sum.known > 0 && known[p].w > 0) {
            const glm::vec3 before(known[p]), around = before / known[p].w;
            const glm::vec3 here = sum.factor > 0 ? sum.light / sum.factor : glm::vec3(0);
            const float factor = sum.known * known[p].w;
            const float more = std::min(sum.known_factor * share[p] - factor, k_most_more * factor);
            const glm::vec3 gone = glm::min(around, glm::max(here, k_least_like * around));
            all -= sum.known * before + more * (more > 0 ? gone : around);
        }
        all = glm::max(all, glm::vec3(0)) + sum.light;
    }
}

}   // namespace gnomon::irradiance_cache
