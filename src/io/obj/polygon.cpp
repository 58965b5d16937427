// SPDX-License-Identifier: Apache-2.0
#include "io/obj/polygon.h"

#include "base/check.h"

namespace gnomon::io {

namespace {

// Twice the signed area: positive for a left turn.
double turn(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}   // namespace

glm::dvec3 newell_normal(std::span<const glm::vec3> points)
{
    glm::dvec3 sum(0);
    const glm::dvec3 origin(points[0]);
    for (std::size_t i = 1; i + 1 < points.size(); ++i)
        sum += glm::cross(glm::dvec3(points[i]) - origin, glm::dvec3(points[i + 1]) - origin);
    return sum;
}

const std::vector<glm::uvec3>& PolygonTriangulator::triangulate(std::span<const glm::vec3> points)
{
    GNOMON_CHECK_LE(3u, points.size());
    const auto n = static_cast<std::uint32_t>(points.size());
    triangles_.clear();
    if (n == 3) {
        triangles_.emplace_back(0, 1, 2);
        return triangles_;
    }

    // Project the polygon to a plane, seen from the side that its normal points to.
    const glm::dvec3 normal = newell_normal(points);
    const glm::dvec3 size = glm::abs(normal);
    const int drop = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    const int u = (drop + 1) % 3, v = (drop + 2) % 3;
    const double side = normal[drop] < 0 ? -1 : 1;
    flat_.clear();
    for (const glm::vec3& p : points)
        flat_.emplace_back(static_cast<double>(p[u]) - points[0][u], side * (static_cast<double>(p[v]) - points[0][v]));

    // A convex polygon becomes a fan. It has only left turns, and winds around once; a star winds more often.
    bool convex = true;
    int direction_changes = 0;
    for (std::uint32_t i = 0; i < n && convex; ++i) {
        const glm::dvec2 &a = flat_[i], &b = flat_[(i + 1) % n], &c = flat_[(i + 2) % n];
        convex = turn(a, b, c) >= 0;
        if ((b.x - a.x < 0) != (c.x - b.x < 0)) ++direction_changes;
    }
    // A fan that starts at a collinear corner has degenerate triangles. Clip ears instead.
    bool strict = convex && direction_changes <= 2;
    for (std::uint32_t i = 1; i + 1 < n && strict; ++i) strict = turn(flat_[0], flat_[i], flat_[i + 1]) > 0;
    if (strict || !(size[drop] > 0) || budget_ == 0) {
        for (std::uint32_t i = 1; i + 1 < n; ++i) triangles_.emplace_back(0, i, i + 1);
        return triangles_;
    }

    next_.resize(n), previous_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) next_[i] = (i + 1) % n, previous_[i] = (i + n - 1) % n;
    std::uint32_t at = 0, left = n, tried = 0, widest = 0;
    double widest_turn = -std::numeric_limits<double>::infinity();
    while (left > 3) {
        const std::uint32_t before = previous_[at], after = next_[at];
        const double here = turn(flat_[before], flat_[at], flat_[after]);
        if (here > widest_turn) widest_turn = here, widest = at;
        std::uint32_t clip = n;
        if (is_ear(before, at, after)) clip = at;
        if (clip == n && ++tried > left) clip = widest;   // no ear in a full round
        if (clip == n && budget_ == 0) clip = at;
        if (clip == n) {
            --budget_;   // searching for an ear is slow where most corners are none
            at = after;
            continue;
        }
        triangles_.emplace_back(previous_[clip], clip, next_[clip]);
        next_[previous_[clip]] = next_[clip];
        previous_[next_[clip]] = previous_[clip];
        // Continue one corner further: taking alternate ears makes better triangles than a fan.
        at = next_[next_[clip]];
        --left;
        tried = 0;
        widest_turn = -std::numeric_limits<double>::infinity();
    }
    triangles_.emplace_back(previous_[at], at, next_[at]);
    return triangles_;
}

bool PolygonTriangulator::is_ear(std::size_t previous, std::size_t corner, std::size_t next)
{
    const glm::dvec2 &a = flat_[previous], &b = flat_[corner], &c = flat_[next];
    if (!(turn(a, b, c) > 0)) return false;
    // Check that no other corner lies inside or on the border, except at the positions of the ear's own corners.
    for (std::size_t i = next_[next]; i != previous; i = next_[i]) {
        if (budget_ == 0) return false;
        --budget_;
        const glm::dvec2& p = flat_[i];
        if (p == a || p == b || p == c) continue;
        if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
}

}   // namespace gnomon::io
