// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which of a few hundred places is the nearest to a point: looked at eight at once.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/math.h"

namespace gnomon::patches {

class NearestPlace {
 public:
    void clear()
    {
        for (std::vector<float>& axis : at_) axis.clear();
        count_ = 0;
    }
    void push(const glm::vec3& place)
    {
        // Places beyond the last are nowhere near.
        if (count_ % k_lanes == 0)
            for (std::vector<float>& axis : at_) axis.resize(count_ + k_lanes, std::numeric_limits<float>::infinity());
        for (int axis = 0; axis < 3; ++axis) at_[static_cast<std::size_t>(axis)][count_] = place[axis];
        ++count_;
    }
    /// The number of the nearest place, the first of equally near ones; 0 if there is none.
    std::uint32_t of(const glm::vec3& p) const
    {
        std::array<float, k_lanes> least;
        std::array<std::uint32_t, k_lanes> nearest{};
        least.fill(std::numeric_limits<float>::infinity());
        const float *x = at_[0].data(), *y = at_[1].data(), *z = at_[2].data();
        for (std::uint32_t first = 0; first < count_; first += k_lanes)
            for (std::uint32_t lane = 0; lane < k_lanes; ++lane) {
                const float dx = x[first + lane] - p.x, dy = y[first + lane] - p.y, dz = z[first + lane] - p.z;
                const float square = dx * dx + dy * dy + dz * dz;
                const bool nearer = square < least[lane];
                least[lane] = nearer ? square : least[lane];
                nearest[lane] = nearer ? first + lane : nearest[lane];
            }
        std::uint32_t best = 0;
        for (std::uint32_t lane = 1; lane < k_lanes; ++lane)
            if (least[lane] < least[best] || (least[lane] == least[best] && nearest[lane] < nearest[best])) best = lane;
        return nearest[best];
    }

 private:
    static constexpr std::uint32_t k_lanes = 8;
    std::array<std::vector<float>, 3> at_;   // by axis
    std::uint32_t count_ = 0;
};

}   // namespace gnomon::patches
