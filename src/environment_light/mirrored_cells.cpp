// SPDX-License-Identifier: Apache-2.0
#include "environment_light/mirrored_cells.h"

#include <algorithm>

#include "base/folded_sphere.h"

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
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<float>& list = mean_[static_cast<std::size_t>(axis)];
        list.assign(64 * cells.words(), 0);   // a direction of 0 lies above no horizon
        for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) list[leaf] = cells.mean(leaf)[axis];
    }
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
    for (std::size_t w = 0; w < seen.size(); ++w) {
        // Find the cells between the horizons.
        const float *x = mean_[0].data() + 64 * w, *y = mean_[1].data() + 64 * w, *z = mean_[2].data() + 64 * w;
        std::array<std::uint8_t, 64> is_between;
        std::uint8_t any = 0;
        for (std::size_t i = 0; i < 64; ++i) {
            const bool above = geometric.x * x[i] + geometric.y * y[i] + geometric.z * z[i] > 0;
            const bool above_smooth = smooth.x * x[i] + smooth.y * y[i] + smooth.z * z[i] > 0;
            is_between[i] = static_cast<std::uint8_t>(!above && above_smooth);
            any = static_cast<std::uint8_t>(any | is_between[i]);
        }
        for (std::size_t i = 0; i < 64 && any != 0; ++i) {
            if (is_between[i] == 0) continue;
            // Look a little higher, so that the cell found there is above the triangle's horizon.
            const std::size_t leaf = 64 * w + i;
            const glm::vec3& mean = cells_.mean(leaf);
            const float below = glm::dot(geometric, mean);
            const std::size_t mirror = leaf_near(mean + (k_raised - 2 * below) * geometric);
            if (seen[mirror / 64] >> (mirror % 64) & 1) seen[leaf / 64] |= std::uint64_t{1} << (leaf % 64);
        }
    }
}

}   // namespace gnomon::environment_light
