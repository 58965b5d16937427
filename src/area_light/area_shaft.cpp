// SPDX-License-Identifier: Apache-2.0
#include "area_light/area_shaft.h"

#include <algorithm>
#include <limits>

namespace gnomon::area_light {

ClippedLight clip_light(const LightPolygon& polygon, const glm::dvec3& normal, double distance)
{
    ClippedLight out;
    const auto count = static_cast<std::size_t>(polygon.corners);
    for (std::size_t c = 0; c < count; ++c) {
        const glm::dvec3 a(polygon.corner[c]), b(polygon.corner[(c + 1) % count]);
        const double at_a = glm::dot(normal, a) + distance, at_b = glm::dot(normal, b) + distance;
        if (at_a >= 0) out.corner[static_cast<std::size_t>(out.count++)] = a;
        if ((at_a < 0) != (at_b < 0))
            out.corner[static_cast<std::size_t>(out.count++)] = a + at_a / (at_a - at_b) * (b - a);
    }
    if (out.count < 3) out.count = 0;
    return out;
}

AreaShaft::AreaShaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const ClippedLight& light,
                     const glm::dvec3& front, double lift, const ShaftRules& rules)
    : HullShaft(corner, normal, {light.corner.data(), static_cast<std::size_t>(light.count)}, lift, rules)
{
    const std::span<const glm::dvec3> piece = this->piece(), emitter = this->light();

    // The top: segments end at a fraction of their way, so below the light by that of their height.
    light_plane_ = {front, -lowest(front, emitter)};
    double least_height = std::numeric_limits<double>::infinity();
    for (const glm::dvec3& p : piece) {
        least_height = std::min(least_height, light_plane_.at(p));
        most_height_ = std::max(most_height_, light_plane_.at(p));
    }
    const double end_gap = (1 - static_cast<double>(ray::k_shadow_ray_end)) * std::max(least_height, 0.0);
    add_plane({front, light_plane_.distance - end_gap});

    for (std::size_t e = 0; e < piece.size(); ++e) add_side(piece[e], piece[(e + 1) % piece.size()], emitter);
    for (std::size_t e = 0; e < emitter.size(); ++e) add_side(emitter[e], emitter[(e + 1) % emitter.size()], piece);
    finish();
}

}   // namespace gnomon::area_light
