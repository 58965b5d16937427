// SPDX-License-Identifier: Apache-2.0
#pragma once
// The edges of a triangle.

#include <algorithm>

#include "base/math.h"

namespace gnomon {

inline float longest_edge(const glm::vec3 (&p)[3])
{
    return std::max({glm::length(p[1] - p[0]), glm::length(p[2] - p[1]), glm::length(p[0] - p[2])});
}

}   // namespace gnomon
