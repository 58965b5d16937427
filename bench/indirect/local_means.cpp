// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/local_means.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace gnomon::bench {

namespace {

struct Block {
    double light = 0, reference = 0, square = 0;   // sums over points and channels; of squares of errors
    int points = 0;
};

double sum_of(const glm::vec3& v)
{
    return static_cast<double>(v.x) + static_cast<double>(v.y) + static_cast<double>(v.z);
}

}   // namespace

LocalMeans compare_blocks(std::span<const ComparedPoint> points, int width)
{
    // Sum up the points of each block.
    std::map<std::size_t, Block> blocks;
    const auto columns = static_cast<std::size_t>(width), side = static_cast<std::size_t>(LocalMeans::k_block);
    double all = 0;
    for (const ComparedPoint& point : points) {
        const std::size_t x = point.pixel % columns / side, y = point.pixel / columns / side;
        Block& block = blocks[y * columns + x];
        block.light += sum_of(point.light), block.reference += sum_of(point.reference);
        // The channels of a path err together.
        const double error = sum_of(point.error);
        block.square += error * error, ++block.points;
        all += sum_of(point.reference);
    }

    // Compare the blocks that are not dark.
    LocalMeans result;
    const double mean = points.empty() ? 0 : all / static_cast<double>(points.size());
    for (const auto& [place, block] : blocks) {
        if (!(block.reference > LocalMeans::k_dark * mean * block.points)) continue;
        const double ratio = block.light / block.reference, noise = std::sqrt(block.square) / block.reference;
        ++result.blocks;
        result.off += std::abs(ratio - 1) > LocalMeans::k_bound;
        result.surely_off += std::abs(ratio - 1) > LocalMeans::k_bound + 2 * noise;
        result.least = std::min(result.least, ratio), result.greatest = std::max(result.greatest, ratio);
    }
    return result;
}

LocalMeans& operator+=(LocalMeans& all, const LocalMeans& frame)
{
    all.blocks += frame.blocks, all.off += frame.off, all.surely_off += frame.surely_off;
    all.least = std::min(all.least, frame.least), all.greatest = std::max(all.greatest, frame.greatest);
    return all;
}

}   // namespace gnomon::bench
