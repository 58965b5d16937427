// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rim of a receiving triangle: a strip along each edge, a few margins wide, of which nothing is remembered.
//
// Where a surface bends inward, the neighbour across the edge begins in the very shaft of every part that touches the
// edge: within the margin that rounding asks for, a ray may or may not meet it, so nothing can be proven there. Without
// the strip no part along such an edge would ever be proven NONE. So parts divide the triangle inside the rim, which is
// a smaller triangle of the same shape; points in the rim, some hundredths of a pixel wide, are traced.

#include <array>
#include <cmath>
#include <cstdint>

#include "base/math.h"

namespace gnomon::shadow_culling {

/// Widths of the three strips, as fractions of the heights over their edges, in a byte each: 2^(-code / 8).
struct RimCodes {
    std::array<std::uint8_t, 3> code{255, 255, 255};   // at u = 0, at v = 0, at u + v = 1
};

/// @param width  of the strips, scene units
RimCodes rim_of(const glm::vec3 (&corner)[3], float width);

/// A rim as look-ups use it.
struct Rim {
    float u = 0, v = 0;    // where the inner triangle begins
    float inner = 1;       // its size, as a fraction of the whole
    float per_inner = 1;   // the inverse

    explicit Rim(const RimCodes& codes);

    /// Whether a point lies inside, and where in the inner triangle.
    bool inside(float at_u, float at_v, float& inner_u, float& inner_v) const
    {
        inner_u = (at_u - u) * per_inner;
        inner_v = (at_v - v) * per_inner;
        return inner_u >= 0 && inner_v >= 0 && inner_u + inner_v <= 1;
    }
    /// The way back.
    glm::dvec2 outer(const glm::dvec2& in_inner) const
    {
        return glm::dvec2(u, v) + static_cast<double>(inner) * in_inner;
    }
};

}   // namespace gnomon::shadow_culling
