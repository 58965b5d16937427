// SPDX-License-Identifier: Apache-2.0
#include "scene/flat_figures.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace gnomon::scene {

namespace {

constexpr double k_flat = 4e-6;                 // largest distance from the first face's plane, per largest coordinate
constexpr double k_parallel = 1e-4;             // largest sine between normals
constexpr double k_least_filled = 0.4;          // of the rectangle around a figure
constexpr std::size_t k_most_faces = 256;       // of a figure
constexpr std::size_t k_most_together = 4096;   // faces; of more, each is by itself

using Corner = std::tuple<ObjectId, float, float, float>;

Corner corner_of(const SizedFace& face, int k)
{
    const glm::vec3& p = face.corner[static_cast<std::size_t>(k)];
    return {face.object, p.x, p.y, p.z};
}

bool same_emission(const SizedFace& a, const SizedFace& b)
{
    return a.radiance == b.radiance && a.two_sided == b.two_sided && a.dynamic == b.dynamic && a.cone == b.cone;
}

// Whether a face lies in the plane of another, with the same front.
bool in_plane_of(const SizedFace& first, const SizedFace& face)
{
    const glm::dvec3 n(first.normal), m(face.normal);
    if (!(glm::dot(n, m) > 0) || !(glm::length(glm::cross(n, m)) <= k_parallel)) return false;
    for (int k = 0; k < face.corners; ++k) {
        const glm::dvec3 p(face.corner[static_cast<std::size_t>(k)]), q(first.corner[0]);
        const glm::dvec3 reach = glm::max(glm::abs(p), glm::abs(q));
        if (!(std::abs(glm::dot(n, p - q)) <= k_flat * std::max({reach.x, reach.y, reach.z}))) return false;
    }
    return true;
}

// The rectangle of least area around some points of a plane that has a side along one of the given edges.
SizedFace rectangle_around(const std::vector<SourceFace>& faces, const std::vector<std::size_t>& figure)
{
    SizedFace outline = faces[figure.front()].face;
    const glm::dvec3 normal(outline.normal);
    double least = 0;
    for (const std::size_t f : figure) {
        const SizedFace& face = faces[f].face;
        for (int k = 0; k < face.corners; ++k) {
            const glm::dvec3 from(face.corner[static_cast<std::size_t>(k)]);
            glm::dvec3 u = glm::dvec3(face.corner[static_cast<std::size_t>((k + 1) % face.corners)]) - from;
            u -= glm::dot(u, normal) * normal;
            if (!(glm::length(u) > 0)) continue;
            u = glm::normalize(u);
            const glm::dvec3 v = glm::cross(normal, u);
            glm::dvec2 low(0), high(0);
            for (const std::size_t g : figure)
                for (int j = 0; j < faces[g].face.corners; ++j) {
                    const glm::dvec3 d = glm::dvec3(faces[g].face.corner[static_cast<std::size_t>(j)]) - from;
                    const glm::dvec2 at(glm::dot(d, u), glm::dot(d, v));
                    low = glm::min(low, at), high = glm::max(high, at);
                }
            const double area = (high.x - low.x) * (high.y - low.y);
            if (least > 0 && !(area < least)) continue;
            least = area;
            const auto at = [&](double x, double y) { return glm::vec3(from + x * u + y * v); };
            outline.corner = {at(low.x, low.y), at(high.x, low.y), at(high.x, high.y), at(low.x, high.y)};
        }
    }
    outline.corners = 4;
    outline.area = static_cast<float>(least);
    return outline;
}

}   // namespace

std::vector<FlatFigure> flat_figures(const std::vector<SourceFace>& faces)
{
    std::map<Corner, std::vector<std::size_t>> touching;
    const bool joins = faces.size() <= k_most_together;
    for (std::size_t f = 0; f < faces.size() && joins; ++f)
        for (int k = 0; k < faces[f].face.corners; ++k) touching[corner_of(faces[f].face, k)].push_back(f);

    std::vector<FlatFigure> figures;
    std::vector<char> taken(faces.size(), 0);
    for (std::size_t first = 0; first < faces.size(); ++first) {
        if (taken[first]) continue;
        taken[first] = 1;
        // Grow the figure over everything that touches it.
        std::vector<std::size_t> figure = {first};
        if (joins && !faces[first].emission->varies())
            for (std::size_t at = 0; at < figure.size(); ++at)
                for (int k = 0; k < faces[figure[at]].face.corners; ++k)
                    for (const std::size_t next : touching[corner_of(faces[figure[at]].face, k)]) {
                        if (taken[next] || faces[next].emission->varies() || figure.size() == k_most_faces ||
                            !same_emission(faces[first].face, faces[next].face) ||
                            !in_plane_of(faces[first].face, faces[next].face))
                            continue;
                        taken[next] = 1;
                        figure.push_back(next);
                    }
        std::sort(figure.begin(), figure.end());
        if (figure.size() > 1) {
            SizedFace outline = rectangle_around(faces, figure);
            double area = 0;
            for (const std::size_t f : figure) area += static_cast<double>(faces[f].face.area);
            if (area >= k_least_filled * static_cast<double>(outline.area)) {
                figures.push_back({std::move(figure), outline});
                continue;
            }
        }
        for (const std::size_t f : figure) figures.push_back({{f}, faces[f].face});
    }
    std::sort(figures.begin(), figures.end(),
              [](const FlatFigure& a, const FlatFigure& b) { return a.faces.front() < b.faces.front(); });
    return figures;
}

}   // namespace gnomon::scene
