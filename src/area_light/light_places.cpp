// SPDX-License-Identifier: Apache-2.0
#include "area_light/light_places.h"

#include <bit>
#include <cstring>
#include <limits>

#include "base/check.h"

namespace gnomon::area_light {

namespace {

// The first `bits` bits of a number in reverse, as a fraction: consecutive rows begin far apart [van der Corput 1935].
float reversed(std::uint32_t i, int bits)
{
    std::uint32_t r = 0;
    for (int b = 0; b < bits; ++b) r |= ((i >> b) & 1u) << (bits - 1 - b);
    return (static_cast<float>(r) + 0.5f) / static_cast<float>(1u << bits);
}

double cross(const glm::dvec2& a, const glm::dvec2& b)
{
    return a.x * b.y - a.y * b.x;
}

}   // namespace

float LightPlaces::row_start(int row)
{
    return (static_cast<float>(row - k_slant) + 0.5f) / k_square_rows;
}

float LightPlaces::row_shift(int row)
{
    return reversed(static_cast<std::uint32_t>(row), 6);
}

glm::vec2 LightPlaces::at(int row, int place) const
{
    const float t = (static_cast<float>(place) + row_shift(row)) / k_row_places;
    return {row_start(row) + slant * t, t};
}

bool same_bits(const LightPolygon& a, const LightPolygon& b)
{
    return a.corners == b.corners && std::memcmp(a.corner.data(), b.corner.data(), sizeof a.corner) == 0 &&
           std::memcmp(&a.normal, &b.normal, sizeof a.normal) == 0;
}

LightPlaces::LightPlaces(const FlatLight& light) : polygon_(light.outline)
{
    const LightPolygon& polygon = polygon_;
    GNOMON_CHECK(polygon.corners == 3 || polygon.corners == 4);
    // Choose the corner whose parallelogram encloses the polygon with the least area.
    const auto count = static_cast<std::size_t>(polygon.corners);
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < count; ++c) {
        const glm::dvec3 o(polygon.corner[c]), u = glm::dvec3(polygon.corner[(c + 1) % count]) - o,
                                               v = glm::dvec3(polygon.corner[(c + count - 1) % count]) - o;
        const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), area = uu * vv - uv * uv;
        if (!(area > 0)) continue;
        glm::dvec2 reach(1);
        for (std::size_t k = 0; k < count; ++k) {
            const glm::dvec3 d = glm::dvec3(polygon.corner[k]) - o;
            const double du = glm::dot(d, u), dv = glm::dot(d, v);
            reach = glm::max(reach, glm::dvec2(du * vv - dv * uv, dv * uu - du * uv) / area);
        }
        const double whole = std::sqrt(area) * reach.x * reach.y;
        if (!(whole < least)) continue;
        least = whole;
        origin_ = polygon.corner[c];
        side_s_ = glm::vec3(reach.x * u), side_t_ = glm::vec3(reach.y * v);
    }
    const glm::dvec3 u(side_s_), v(side_t_);
    const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), area = uu * vv - uv * uv;
    if (!(area > 0)) return;
    // s and t of a point are its products with the dual basis.
    const glm::dvec3 dual_s = (vv * u - uv * v) / area, dual_t = (uu * v - uv * u) / area;
    row_plane_ = {glm::vec3(glm::normalize(glm::cross(u, v))),
                  glm::vec3(static_cast<double>(k_square_rows) * (dual_s - static_cast<double>(slant) * dual_t))};
    if (light.faces.empty())
        mark_inside(polygon);
    else
        for (const LightPolygon& face : light.faces) mark_inside(face);
    count_ = count_places(inside_);
}

// Marks the places inside a polygon, in the coordinates of the parallelogram.
void LightPlaces::mark_inside(const LightPolygon& face)
{
    GNOMON_CHECK(face.corners == 3 || face.corners == 4);
    const auto count = static_cast<std::size_t>(face.corners);
    const glm::dvec3 u(side_s_), v(side_t_);
    const double uu = glm::dot(u, u), uv = glm::dot(u, v), vv = glm::dot(v, v), area = uu * vv - uv * uv;
    std::array<glm::dvec2, 4> corner{};
    for (std::size_t k = 0; k < count; ++k) {
        const glm::dvec3 d = glm::dvec3(face.corner[k]) - glm::dvec3(origin_);
        const double du = glm::dot(d, u), dv = glm::dot(d, v);
        corner[k] = glm::dvec2(du * vv - dv * uv, dv * uu - du * uv) / area;
    }
    double turn = 0;
    for (std::size_t k = 2; k < count; ++k) turn += cross(corner[k - 1] - corner[0], corner[k] - corner[0]);
    for (int row = 0; row < k_rows; ++row)
        for (int place = 0; place < k_row_places; ++place) {
            const glm::dvec2 q(at(row, place));
            bool inside = q.x >= 0 && q.x < 1;
            for (std::size_t k = 0; k < count && inside; ++k)
                inside = turn * cross(corner[(k + 1) % count] - corner[k], q - corner[k]) >= 0;
            if (inside) inside_[static_cast<std::size_t>(row)] |= std::uint64_t{1} << place;
        }
}

int count_places(const PlaceMask& mask)
{
    int count = 0;
    for (const std::uint64_t word : mask) count += std::popcount(word);
    return count;
}

}   // namespace gnomon::area_light
