// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sphere of directions folded to a square: an octahedron, whose lower half is turned outwards [Cigolle et al.
// 2014].

#include "base/math.h"

namespace gnomon {

/// The point of the square, each coordinate from -1 to 1. @param d  of any length but 0
inline glm::vec2 fold(const glm::vec3& d)
{
    const float sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    const glm::vec2 p(d.x / sum, d.y / sum);
    if (d.z >= 0) return p;
    return {(1 - std::abs(p.y)) * (p.x >= 0 ? 1.0f : -1.0f), (1 - std::abs(p.x)) * (p.y >= 0 ? 1.0f : -1.0f)};
}

/// The unit direction of a point of the square.
inline glm::vec3 unfold(const glm::vec2& p)
{
    glm::vec3 d(p.x, p.y, 1 - std::abs(p.x) - std::abs(p.y));
    if (d.z < 0) {
        const glm::vec2 q((1 - std::abs(p.y)) * (p.x >= 0 ? 1.0f : -1.0f),
                          (1 - std::abs(p.x)) * (p.y >= 0 ? 1.0f : -1.0f));
        d.x = q.x, d.y = q.y;
    }
    return glm::normalize(d);
}

}   // namespace gnomon
