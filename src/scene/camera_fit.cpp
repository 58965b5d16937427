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

// The corners that bound a position sideways, for a tangent: max(u + t b) and max(t b - u).
struct Bounds {
    glm::dvec2 high{0}, low{0};   // (back, sideways)
    double highest = -std::numeric_limits<double>::max(), lowest = highest;
};

Bounds bounds_of(const std::vector<glm::dvec2>& hull, double tangent)
{
    Bounds bounds;
    for (const glm::dvec2& p : hull) {
        if (const double high = p.y + tangent * p.x; high > bounds.highest) bounds.highest = high, bounds.high = p;
        if (const double low = -p.y + tangent * p.x; low > bounds.lowest) bounds.lowest = low, bounds.low = p;
    }
    return bounds;
}

// Where a camera at a distance sees the points in the middle: half-way between the bounds of the smallest tangent that
// holds them. What is missing for a tangent, max(u + t b) + max(t b - u) - 2 t d, is convex in t; Newton's method
// from t = 0 reaches its zero after as many steps as corners change.
double middle(const std::vector<glm::dvec2>& hull, double distance)
{
    constexpr int k_most_steps = 64;
    double tangent = 0;
    Bounds bounds = bounds_of(hull, 0);
    for (int step = 0; step < k_most_steps; ++step) {
        const double missing = bounds.highest + bounds.lowest - 2 * tangent * distance;
        const double falls = 2 * distance - bounds.high.x - bounds.low.x;
        if (!(missing > 0) || !(falls > 0)) break;
        const double next = tangent + missing / falls;
        if (!(next > tangent)) break;
        tangent = next;
        bounds = bounds_of(hull, tangent);
    }
    return 0.5 * (bounds.highest - bounds.lowest);
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
        const Bounds bounds = bounds_of(hulls_[axis], tangents[axis]);
        result.z = std::max(result.z, (bounds.highest + bounds.lowest) / (2 * tangents[axis]));
    }
    // The points fill the image in one direction; put them in the middle of the other one as well.
    for (int axis = 0; axis < 2; ++axis) result[axis] = middle(hulls_[axis], result.z);
    return result;
}

}   // namespace gnomon::scene
