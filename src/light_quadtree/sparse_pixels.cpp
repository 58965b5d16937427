// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/sparse_pixels.h"

#include <algorithm>
#include <cmath>

namespace gnomon::light_quadtree {

namespace {

// What is one plane: normals this close, and no further from it than this share of a pixel.
constexpr float k_same_normal = 0.9999f, k_off_plane = 0.25f;

bool in_plane(const IndirectPoint& a, const IndirectPoint& b)
{
    return glm::dot(a.geometric_normal, b.geometric_normal) > k_same_normal &&
           glm::dot(a.normal, b.normal) > k_same_normal &&
           std::abs(glm::dot(b.position - a.position, a.geometric_normal)) < k_off_plane * a.width;
}

}   // namespace

void SparsePixels::choose(std::span<const IndirectPoint> points, const std::vector<std::uint8_t>& exempt)
{
    blocks_.clear();
    reckoned_.clear();
    at_.assign(k_side * k_side, -1);
    direct_.assign(points.size(), 0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const IndirectPoint& p = points[i];
        const bool inside = p.x >= 0 && p.y >= 0 && p.x < k_side && p.y < k_side;
        std::int32_t* const at = inside ? &at_[static_cast<std::size_t>(p.y * k_side + p.x)] : nullptr;
        if (!at || *at >= 0)
            direct_[i] = 1;
        else
            *at = static_cast<std::int32_t>(i);
    }
    for (int y0 = 0; y0 < k_side - 1; y0 += k_step)
        for (int x0 = 0; x0 < k_side - 1; x0 += k_step) {
            const Block block{x0, y0, std::min(x0 + k_step, k_side - 1), std::min(y0 + k_step, k_side - 1)};
            const std::int32_t first = at_[static_cast<std::size_t>(y0 * k_side + x0)];
            bool flat = first >= 0;
            for (int y = y0; flat && y <= block.y1; ++y)
                for (int x = x0; flat && x <= block.x1; ++x) {
                    const std::int32_t i = at_[static_cast<std::size_t>(y * k_side + x)];
                    flat = i >= 0 && !exempt[static_cast<std::size_t>(i)] &&
                           in_plane(points[static_cast<std::size_t>(first)], points[static_cast<std::size_t>(i)]);
                }
            if (flat) {
                blocks_.push_back(block);
                for (const int y : {y0, block.y1})
                    for (const int x : {x0, block.x1})
                        direct_[static_cast<std::size_t>(at_[static_cast<std::size_t>(y * k_side + x)])] = 1;
                continue;
            }
            // The far rows and columns are the next blocks' as well, but of the last ones.
            for (int y = y0; y <= block.y1; ++y)
                for (int x = x0; x <= block.x1; ++x) {
                    if ((y == block.y1 && y < k_side - 1) || (x == block.x1 && x < k_side - 1)) continue;
                    const std::int32_t i = at_[static_cast<std::size_t>(y * k_side + x)];
                    if (i >= 0) direct_[static_cast<std::size_t>(i)] = 1;
                }
        }
    for (std::uint32_t i = 0; i < direct_.size(); ++i)
        if (direct_[i]) reckoned_.push_back(i);
}

void SparsePixels::fill(glm::vec3* irradiance) const
{
    const auto point = [&](int x, int y) {
        return static_cast<std::size_t>(at_[static_cast<std::size_t>(y * k_side + x)]);
    };
    for (const Block& b : blocks_) {
        const glm::vec3 low0 = irradiance[point(b.x0, b.y0)], low1 = irradiance[point(b.x1, b.y0)],
                        high0 = irradiance[point(b.x0, b.y1)], high1 = irradiance[point(b.x1, b.y1)];
        const float per_x = 1 / static_cast<float>(b.x1 - b.x0), per_y = 1 / static_cast<float>(b.y1 - b.y0);
        for (int y = b.y0; y <= b.y1; ++y) {
            const float v = static_cast<float>(y - b.y0) * per_y;
            const glm::vec3 left = low0 + v * (high0 - low0), right = low1 + v * (high1 - low1);
            for (int x = b.x0; x <= b.x1; ++x) {
                const std::size_t i = point(x, y);
                if (direct_[i]) continue;
                irradiance[i] = left + static_cast<float>(x - b.x0) * per_x * (right - left);
            }
        }
    }
}

}   // namespace gnomon::light_quadtree
