// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified/rim.h"

#include <algorithm>

namespace gnomon::shadow_culling {

namespace {

constexpr float k_steps_per_octave = 8;
// Strips are at most 2^-5 of the triangle's height wide.
constexpr float k_widest_code = 5 * k_steps_per_octave;

const std::array<float, 256>& fractions()
{
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (std::size_t c = 0; c < t.size(); ++c) t[c] = std::exp2(-static_cast<float>(c) / k_steps_per_octave);
        t[255] = 0;
        return t;
    }();
    return table;
}

}   // namespace

RimCodes rim_of(const glm::vec3 (&corner)[3], float width)
{
    RimCodes result;
    const float double_area = glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
    const glm::vec3 edge[3] = {corner[2] - corner[0], corner[1] - corner[0], corner[2] - corner[1]};
    for (std::size_t e = 0; e < 3; ++e) {
        const float fraction = width * glm::length(edge[e]) / double_area;   // of the height over the edge
        const float code = std::floor(-k_steps_per_octave * std::log2(fraction));
        // The comparison gives the widest strip to a triangle without area.
        result.code[e] = static_cast<std::uint8_t>(code > k_widest_code ? std::min(code, 254.0f) : k_widest_code);
    }
    return result;
}

Rim::Rim(const RimCodes& codes)
{
    const std::array<float, 256>& fraction = fractions();
    u = fraction[codes.code[0]];
    v = fraction[codes.code[1]];
    inner = 1 - u - v - fraction[codes.code[2]];
    per_inner = 1 / inner;
}

}   // namespace gnomon::shadow_culling
