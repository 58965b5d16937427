// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/dynamic_mask/light_space.h"

namespace gnomon::shadow_culling {

LightSpace::LightSpace(const visibility::LightPoint& light, const Box3& bounds) : light_(light)
{
    single_.to = glm::vec3(light.place);
    if (!light.directional) return;
    make_basis(single_.to, single_.s, single_.t);
    float low[2] = {k_infinity, k_infinity}, high[2] = {-k_infinity, -k_infinity};
    for (int corner = 0; corner < 8 && !bounds.empty(); ++corner) {
        const glm::vec3 p(corner & 1 ? bounds.high.x : bounds.low.x, corner & 2 ? bounds.high.y : bounds.low.y,
                          corner & 4 ? bounds.high.z : bounds.low.z);
        const float at[2] = {glm::dot(p, single_.s), glm::dot(p, single_.t)};
        for (int i = 0; i < 2; ++i) low[i] = std::min(low[i], at[i]), high[i] = std::max(high[i], at[i]);
    }
    constexpr float k_border = 1e-3f;   // of the width, on each side
    float width = std::max(high[0] - low[0], high[1] - low[1]);
    if (!(width > 0)) width = 1, low[0] = low[1] = 0;
    single_.low_x = low[0] - k_border * width, single_.low_y = low[1] - k_border * width;
    single_.scale = 1 / ((1 + 2 * k_border) * width);
}

glm::dvec3 LightSpace::in_face(std::uint32_t face, const glm::dvec3& p) const
{
    if (light_.directional)
        return {glm::dot(p, glm::dvec3(single_.s)) - static_cast<double>(single_.low_x),
                glm::dot(p, glm::dvec3(single_.t)) - static_cast<double>(single_.low_y),
                -glm::dot(p, glm::dvec3(single_.to))};
    const glm::dvec3 q = p - glm::dvec3(single_.to);
    const int axis = static_cast<int>(face / 2);
    return {q[axis == 2 ? 0 : axis + 1], q[axis == 0 ? 2 : axis - 1], face & 1 ? -q[axis] : q[axis]};
}

visibility::Plane LightSpace::side(int axis, double at, double sign, double margin) const
{
    visibility::Plane plane;
    plane.normal[axis] = sign;
    if (light_.directional) {
        plane.distance = -sign * at / static_cast<double>(single_.scale) + margin;
        return plane;
    }
    plane.normal.z = -sign * (2 * at - 1);
    plane.normal /= glm::length(plane.normal);
    plane.distance = margin;
    return plane;
}

visibility::Plane LightSpace::in_world(std::uint32_t face, const visibility::Plane& plane) const
{
    // in_face is an isometry: its columns are the images of the axes.
    const glm::dvec3 origin = in_face(face, glm::dvec3(0));
    visibility::Plane world;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 unit(0);
        unit[axis] = 1;
        world.normal[axis] = glm::dot(plane.normal, in_face(face, unit) - origin);
    }
    world.distance = plane.at(origin);
    return world;
}

}   // namespace gnomon::shadow_culling
