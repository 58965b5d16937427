// SPDX-License-Identifier: Apache-2.0
#include "scene/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace gnomon::scene {

namespace {

constexpr std::size_t k_corners = 16;
constexpr double k_beyond = 1e-6;   // of the hull's size

double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}   // namespace

void reduce_to_hull(std::vector<glm::dvec2>& points)
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

InnerPolygon::InnerPolygon(const std::vector<glm::dvec2>& hull)
{
    if (hull.size() < 3) return;
    glm::dvec2 low = hull[0], high = hull[0];
    for (const glm::dvec2& p : hull) low = glm::min(low, p), high = glm::max(high, p);
    const double beyond = k_beyond * glm::length(high - low);

    // Begin with the first corner. Insert the corner that is farthest outside, again and again.
    std::vector<std::size_t> corners{0};
    while (corners.size() < k_corners) {
        double most = 0.5 * beyond;
        std::size_t before = 0, best = hull.size();
        for (std::size_t side = 0; side < corners.size(); ++side) {
            const std::size_t to = side + 1 < corners.size() ? corners[side + 1] : hull.size();
            const glm::dvec2 &a = hull[corners[side]], &b = hull[to % hull.size()];
            const double length = glm::length(b - a);
            for (std::size_t i = corners[side] + 1; i < to; ++i) {
                const double outside = length > 0 ? -turn(a, b, hull[i]) / length : glm::length(hull[i] - a);
                if (outside > most) most = outside, best = i, before = side + 1;
            }
        }
        if (best == hull.size()) break;
        corners.insert(corners.begin() + static_cast<std::ptrdiff_t>(before), best);
    }
    if (corners.size() < 3) return;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec2 &a = hull[corners[i]], &b = hull[corners[(i + 1) % corners.size()]];
        const glm::dvec2 out = glm::normalize(glm::dvec2(b.y - a.y, a.x - b.x));
        sides_.emplace_back(out, glm::dot(out, a) + beyond);
    }
}

}   // namespace gnomon::scene
