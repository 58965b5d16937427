// SPDX-License-Identifier: Apache-2.0
#include "area_light/cluster_shaft.h"

#include <algorithm>

namespace gnomon::area_light {

namespace {

std::array<glm::dvec3, 8> corners_of(const ClusterBox& box)
{
    std::array<glm::dvec3, 8> corner;
    for (std::size_t k = 0; k < corner.size(); ++k) corner[k] = box.corner(k);
    return corner;
}

}   // namespace

ClusterShaft::ClusterShaft(const glm::dvec3 (&corner)[3], const glm::dvec3& normal, const ClusterBox& box, double lift,
                           const ShaftRules& rules)
    : HullShaft(corner, normal, corners_of(box), lift, rules), box_(box)
{
    double longest = 0;
    int above = 0;
    for (const glm::dvec3& b : light()) {
        if (height(b) > 0) place_above_ += b, ++above;
        for (const glm::dvec3& p : piece()) longest = std::max(longest, glm::length(b - p));
    }
    rises_ = above > 0;
    if (rises_) place_above_ /= static_cast<double>(above);
    end_gap_ = (1 - static_cast<double>(ray::k_shadow_ray_end)) * longest;

    // Of the box's edges, those of its outline as seen from the piece have a plane that leaves all on one side; of its
    // faces, those that do not look at the piece.
    const double thin = 1e-9 * longest;
    for (std::size_t e = 0; e < 3; ++e) add_side(piece()[e], piece()[(e + 1) % 3], light());
    for (std::size_t k = 0; k < 8; ++k)
        for (const std::size_t axis : {1u, 2u, 4u})
            if ((k & axis) == 0) add_side(light()[k], light()[k | axis], piece(), thin);
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            glm::dvec3 inward(0);
            inward[axis] = sign;
            const double face = lowest(inward, light());
            if (lowest(inward, piece()) >= face) add_plane({inward, -face});
        }
    finish();
}

bool ClusterShaft::keeps_clear(const ClippedTriangle& polygon, const glm::dvec3& normal, double clear) const
{
    const std::span<const glm::dvec3> corners(polygon.corner.data(), static_cast<std::size_t>(polygon.count));
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 along(0);
        along[axis] = 1;
        if (lowest(along, corners) >= box_.high[axis] + clear || -lowest(-along, corners) <= box_.low[axis] - clear)
            return true;
    }
    return lowest(normal, light()) >= -lowest(-normal, corners) + clear ||
           -lowest(-normal, light()) <= lowest(normal, corners) - clear;
}

}   // namespace gnomon::area_light
