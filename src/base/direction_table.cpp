// SPDX-License-Identifier: Apache-2.0
#include "base/direction_table.h"

#include <algorithm>

#include "base/folded_sphere.h"

namespace gnomon {

DirectionTable::DirectionTable(int side)
    : side_(side), values_(static_cast<std::size_t>(side + 1) * static_cast<std::size_t>(side + 1), glm::vec3(0))
{
}

glm::vec3 DirectionTable::direction(std::size_t entry) const
{
    const auto row = static_cast<std::size_t>(side_ + 1);
    const float scale = 2 / static_cast<float>(side_);
    return unfold(glm::vec2(static_cast<float>(entry % row), static_cast<float>(entry / row)) * scale - 1.0f);
}

glm::vec3 DirectionTable::at(const glm::vec3& direction) const
{
    const glm::vec2 p = (fold(direction) + 1.0f) * (0.5f * static_cast<float>(side_));
    const int x = std::clamp(static_cast<int>(p.x), 0, side_ - 1), y = std::clamp(static_cast<int>(p.y), 0, side_ - 1);
    const float fx = p.x - static_cast<float>(x), fy = p.y - static_cast<float>(y);
    const auto row = static_cast<std::size_t>(side_ + 1);
    const glm::vec3* v = values_.data() + static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x);
    return glm::mix(glm::mix(v[0], v[1], fx), glm::mix(v[row], v[row + 1], fx), fy);
}

}   // namespace gnomon
