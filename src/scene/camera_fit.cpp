// SPDX-License-Identifier: Apache-2.0
#include "scene/camera_fit.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace gnomon::scene {

namespace {

constexpr std::size_t k_pending = 4096;   // points that are collected before the hulls are reduced

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Keeps the corners of the convex hull [Andrew 1979].
void reduce(std::vector<glm::dvec2>& points)
{
    std::sort(points.begin(), points.end(),
              [](const glm::dvec2& a, const glm::dvec2& b) { return std::tie(a.x, a.y) < std::tie(b.x, b.y); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    if (points.size() < 3) return;
    std::vector<glm::dvec2> hull;
    for (int side = 0; side < 2; ++side) {
        const std::size_t first = hull.size();
        for (const glm::dvec2& p : points) {
            while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();   // it begins the other side
        std::reverse(points.begin(), points.end());
    }
    points = std::move(hull);
}

}   // namespace

void CameraFit::add(const glm::dvec3& p)
{
    nearest_ = empty() ? p.z : std::max(nearest_, p.z);
    hulls_[0].emplace_back(p.z, p.x);
    hulls_[1].emplace_back(p.z, p.y);
    if (hulls_[0].size() < std::max(k_pending, 2 * reduced_)) return;
    for (auto& hull : hulls_) reduce(hull);
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
    for (int axis = 0; axis < 2; ++axis) {
        double high = -std::numeric_limits<double>::max(), low = high;
        for (const glm::dvec2& p : hulls_[axis]) {
            high = std::max(high, p.y + tangents[axis] * p.x);
            low = std::max(low, -p.y + tangents[axis] * p.x);
        }
        result[axis] = 0.5 * (high - low);
        result.z = std::max(result.z, (high + low) / (2 * tangents[axis]));
    }
    return result;
}

}   // namespace gnomon::scene
