// SPDX-License-Identifier: Apache-2.0
#include "scene/camera_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/convex_hull.h"

namespace gnomon::scene {

namespace {

constexpr std::size_t k_pending = 4096;   // points that are collected before the hulls are reduced

// How far the points of a hull lie to either side, seen along a line of this tangent.
struct Extent {
    double high = -std::numeric_limits<double>::max(), low = high;
    Extent(const std::vector<glm::dvec2>& hull, double tangent)
    {
        for (const glm::dvec2& p : hull) {
            high = std::max(high, p.y + tangent * p.x);
            low = std::max(low, -p.y + tangent * p.x);
        }
    }
    double middle() const { return 0.5 * (high - low); }
};

// From farther away than the tangent asks for, the points are in the middle where a smaller one is just wide enough.
double middle_from(const std::vector<glm::dvec2>& hull, double tangent, double distance)
{
    constexpr double k_least = 1e-6;   // of the tangent
    constexpr int k_steps = 60;
    // The distance that 1 / s asks for rises with s. It bounds s from above.
    const auto needs = [&](double s) {
        const Extent extent(hull, 1 / s);
        return 0.5 * s * (extent.high + extent.low);
    };
    double near = 1 / tangent, far = near / k_least;
    if (needs(far) <= distance) return Extent(hull, 1 / far).middle();
    for (int step = 0; step < k_steps; ++step) {
        const double s = std::sqrt(near * far);
        (needs(s) <= distance ? near : far) = s;
    }
    return Extent(hull, 1 / near).middle();
}

}   // namespace

void CameraFit::add(const glm::dvec3& p)
{
    nearest_ = empty() ? p.z : std::max(nearest_, p.z);
    hulls_[0].emplace_back(p.z, p.x);
    hulls_[1].emplace_back(p.z, p.y);
    if (hulls_[0].size() < std::max(k_pending, 2 * reduced_)) return;
    for (auto& hull : hulls_) reduce_to_hull(hull);
    reduced_ = std::max(hulls_[0].size(), hulls_[1].size());
    // Both have the same length, so that either one says when to reduce.
    for (auto& hull : hulls_) hull.resize(reduced_, hull.back());
}

glm::dvec3 CameraFit::eye(double aspect) const
{
    if (empty()) return glm::dvec3(0);
    const double upright = std::tan(lens_.vertical_fov / 2) / lens_.margin;
    const double tangents[2] = {upright * aspect, upright};
    glm::dvec3 result(0, 0, nearest_ + lens_.least_distance);
    double needed[2];
    for (int axis = 0; axis < 2; ++axis) {
        const Extent extent(hulls_[axis], tangents[axis]);
        result[axis] = extent.middle();
        needed[axis] = (extent.high + extent.low) / (2 * tangents[axis]);
        result.z = std::max(result.z, needed[axis]);
    }
    // Move the points to the middle of the axis in which there is room.
    for (int axis = 0; axis < 2; ++axis)
        if (needed[axis] < result.z) result[axis] = middle_from(hulls_[axis], tangents[axis], result.z);
    return result;
}

}   // namespace gnomon::scene
