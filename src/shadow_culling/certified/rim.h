// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rim of a receiving triangle: a strip along each edge, a few margins wide, in which no shadows are remembered.
//
// At a concave edge, the neighbouring triangle begins in the shaft of every part that touches the edge. Within the
// rounding margin a ray may or may not hit it, so nothing can be proven, and no part along such an edge would ever be
// NONE. Therefore parts divide the triangle inside the rim, a smaller triangle of the same shape. Shadow rays from
// points in the rim, which is some hundredths of a pixel wide, are traced.

#include <array>
#include <cmath>
#include <cstdint>

#include "base/math.h"

namespace gnomon::shadow_culling {

/// The widths of the three strips as fractions of the heights over their edges, one byte each: 2^(-code / 8).
struct RimCodes {
    std::array<std::uint8_t, 3> code{255, 255, 255};   // at u = 0, at v = 0, at u + v = 1
};

/// @param width  of the strips, scene units
RimCodes rim_of(const glm::vec3 (&corner)[3], float width);

/// A rim in the form that look-ups use.
struct Rim {
    float u = 0, v = 0;    // of the inner triangle's first corner
    float inner = 1;       // size of the inner triangle, as a fraction of the whole
    float per_inner = 1;   // the inverse

    explicit Rim(const RimCodes& codes);

    /// Whether a point lies in the inner triangle, and its coordinates there.
    bool inside(float at_u, float at_v, float& inner_u, float& inner_v) const
    {
        inner_u = (at_u - u) * per_inner;
        inner_v = (at_v - v) * per_inner;
        return inner_u >= 0 && inner_v >= 0 && inner_u + inner_v <= 1;
    }
    /// From coordinates in the inner triangle to those in the whole.
    glm::dvec2 outer(const glm::dvec2& in_inner) const
    {
        return glm::dvec2(u, v) + static_cast<double>(inner) * in_inner;
    }
};

}   // namespace gnomon::shadow_culling
