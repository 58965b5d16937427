// SPDX-License-Identifier: Apache-2.0
#include "environment_light/mirrored_cells.h"

#include <algorithm>

#include "environment_light/folded_sphere.h"

namespace gnomon::environment_light {

namespace {

constexpr float k_raised = 0.1f;   // sine
constexpr int k_side = 48;         // of the table; cells of the least level are twice as wide as its entries

std::size_t entry_of(const glm::vec3& direction)
{
    const glm::vec2 p = (fold(direction) + 1.0f) * (0.5f * k_side);
    const int x = std::clamp(static_cast<int>(p.x), 0, k_side - 1),
              y = std::clamp(static_cast<int>(p.y), 0, k_side - 1);
    return static_cast<std::size_t>(y * k_side + x);
}

}   // namespace

MirroredCells::MirroredCells(const DirectionCells& cells) : cells_(cells)
{
    leaf_of_.resize(static_cast<std::size_t>(k_side) * k_side);
    for (int y = 0; y < k_side; ++y)
        for (int x = 0; x < k_side; ++x) {
            const glm::vec2 place = (glm::vec2(x, y) + 0.5f) * (2.0f / k_side) - 1.0f;
            const glm::vec3 direction = unfold(place);
            float most = -2;
            std::size_t nearest = 0;
            for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
                const float cosine = glm::dot(cells.direction(leaf), direction);
                if (cosine > most) most = cosine, nearest = leaf;
            }
            leaf_of_[static_cast<std::size_t>(y * k_side + x)] = static_cast<std::uint16_t>(nearest);
        }
}

std::size_t MirroredCells::leaf_near(const glm::vec3& direction) const
{
    return leaf_of_[entry_of(direction)];
}

void MirroredCells::add(const glm::vec3& geometric, const glm::vec3& smooth, std::span<std::uint64_t> seen) const
{
    for (std::size_t leaf = 0; leaf < cells_.leaves(); ++leaf) {
        const glm::vec3& mean = cells_.mean(leaf);
        const float below = glm::dot(geometric, mean);
        if (below > 0 || !(glm::dot(smooth, mean) > 0)) continue;
        // Look a little higher, so that the cell found there is above the triangle's horizon.
        const std::size_t mirror = leaf_near(mean + (k_raised - 2 * below) * geometric);
        if (seen[mirror / 64] >> (mirror % 64) & 1) seen[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
    }
}

}   // namespace gnomon::environment_light
