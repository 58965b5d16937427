// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/rough_light.h"

#include <algorithm>
#include <cmath>

namespace gnomon::irradiance_cache {

namespace {

constexpr float k_cells[] = {96, 24};      // along the diagonal of the scene, from fine to coarse
constexpr std::size_t k_most = 1u << 17;   // cells
constexpr float k_follows = 0.5f;          // of the difference to what was known, in each frame

}   // namespace

RoughLight::RoughLight(const Box3& bounds)
{
    const float diagonal = bounds.empty() ? 1 : std::max(bounds.diagonal(), 1e-30f);
    for (int grid = 0; grid < k_grids; ++grid) inverse_width_[grid] = k_cells[grid] / diagonal;
}

RoughLight::Key RoughLight::key(const glm::ivec3& cell, int axis, bool negative, int grid)
{
    Key key = static_cast<Key>(grid);
    for (int i = 0; i < 3; ++i) key = key << 19 | (static_cast<Key>(cell[i]) & 0x7ffff);
    return key << 3 | static_cast<Key>(2 * axis + (negative ? 1 : 0));
}

// A place in cells of a grid.
glm::vec3 RoughLight::place(const glm::vec3& position, int grid) const
{
    constexpr float k_bound = 1 << 17;
    return glm::clamp(position * inverse_width_[grid], glm::vec3(-k_bound), glm::vec3(k_bound));
}

glm::vec3 RoughLight::at(const glm::vec3& position, const glm::vec3& normal) const
{
    // Interpolate between the middles of eight cells, and between the axes that the surface faces by the squares of its
    // normal's components; leave to the next grid what too few known ones cannot bring.
    constexpr float k_least_part = 0.02f;   // of a normal's square
    constexpr float k_enough = 0.25f;       // of the weight: beside a surface half of the cells are empty
    glm::vec3 light(0);
    float left = 1;
    for (int grid = 0; grid < k_grids; ++grid) {
        const glm::vec3 at = place(position, grid) - 0.5f;
        const glm::vec3 low = glm::floor(at), part = at - low;
        glm::vec3 sum(0);
        float weights = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 side(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
            float weight = 1;
            for (int axis = 0; axis < 3; ++axis) weight *= side[axis] ? part[axis] : 1 - part[axis];
            for (int axis = 0; axis < 3; ++axis) {
                const float faces = normal[axis] * normal[axis];
                if (!(faces > k_least_part)) continue;
                const auto found = means_.find(key(glm::ivec3(low) + side, axis, normal[axis] < 0, grid));
                if (found == means_.end()) continue;
                sum += weight * faces * found->second.before, weights += weight * faces;
            }
        }
        if (!(weights > 0)) continue;
        const float share = std::min(weights / k_enough, 1.0f);
        light += left * share / weights * sum;
        left *= 1 - share;
        if (!(left > 0)) return light;
    }
    return light + left * everywhere_.before;
}

void RoughLight::note(const std::vector<Sample>& samples)
{
    if (means_.size() > k_most) means_.clear();
    changed_.clear();
    if (!samples.empty()) changed_.push_back(&everywhere_);
    for (const Sample& sample : samples) {
        everywhere_.sum += sample.weight * sample.irradiance, everywhere_.weight += sample.weight;
        const glm::vec3 size = glm::abs(sample.normal);
        const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
        for (int grid = 0; grid < k_grids; ++grid) {
            const glm::ivec3 cell(glm::floor(place(sample.position, grid)));
            Mean& mean = means_[key(cell, axis, sample.normal[axis] < 0, grid)];
            if (mean.weight == 0) changed_.push_back(&mean);
            mean.sum += sample.weight * sample.irradiance, mean.weight += sample.weight;
        }
    }
    for (Mean* const mean : changed_) {
        const glm::vec3 now = mean->sum / mean->weight;
        mean->before = mean->known ? glm::mix(mean->before, now, k_follows) : now;
        mean->known = true, mean->sum = glm::vec3(0), mean->weight = 0;
    }
}

std::size_t RoughLight::bytes() const
{
    return means_.size() * (sizeof(Key) + sizeof(Mean) + 2 * sizeof(void*));
}

}   // namespace gnomon::irradiance_cache
