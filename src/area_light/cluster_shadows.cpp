// SPDX-License-Identifier: Apache-2.0
#include "area_light/cluster_shadows.h"

#include <algorithm>

#include "visibility/closed_patch.h"

namespace gnomon::area_light {

namespace {

using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

// How far around the cluster its own solid may reach, in diagonals of its box.
constexpr float k_around = 2;

Box3 box_of(const Cluster& cluster)
{
    Box3 box;
    for (const LightPolygon& face : cluster.faces)
        for (int k = 0; k < face.corners; ++k) box.add(face.corner[static_cast<std::size_t>(k)]);
    return box;
}

// The plane of a face in double precision: its normal in single precision is not that of its corners.
visibility::Plane plane_of(const LightPolygon& face)
{
    const glm::dvec3 a(face.corner[0]), b(face.corner[1]), c(face.corner[2]);
    glm::dvec3 n = glm::cross(b - a, c - a);
    const double length = glm::length(n);
    n = length > 0 ? n / length : glm::dvec3(face.normal);
    return {n, -glm::dot(n, a)};
}

}   // namespace

ClusterShadows::ClusterShadows(const StaticTriangles& triangles, const Cluster& cluster, const AreaOptions& options,
                               ClusterCheck left_out)
    : PartTree(triangles, options.most_levels), options_(options), left_out_(left_out), box_(box_of(cluster))
{
    bounds_ = {glm::dvec3(box_.low), glm::dvec3(box_.high)};
    if (!cluster.two_sided) find_behind(cluster);
}

// Finds the triangles around the cluster that no segment to a facing place can cross: those that do not rise above the
// plane of any face.
void ClusterShadows::find_behind(const Cluster& cluster)
{
    std::vector<visibility::Plane> planes;
    for (const LightPolygon& face : cluster.faces) planes.push_back(plane_of(face));
    const glm::vec3 around(k_around * box_.diagonal());
    // Corners of faces may be rounded otherwise than those of the triangles that rays meet. What rises by so little
    // hides places that are seen edge-on at most.
    constexpr double k_rounding = 3e-7;
    const glm::dvec3 reach = glm::max(glm::abs(bounds_.low), glm::abs(bounds_.high));
    const double rounding = k_rounding * std::max({reach.x, reach.y, reach.z});
    const auto behind = [&](const StaticTriangle& t, const visibility::Plane& plane) {
        return std::ranges::all_of(t.p, [&](const glm::vec3& p) { return plane.at(glm::dvec3(p)) <= rounding; });
    };
    triangles_.visit(
        [&](const glm::vec3& low, const glm::vec3& high) {
            return glm::all(glm::lessThanEqual(low, box_.high + around)) &&
                   glm::all(glm::greaterThanEqual(high, box_.low - around));
        },
        [&](TriangleId id) {
            const auto is_behind = [&](const visibility::Plane& plane) { return behind(triangles_[id], plane); };
            if (makes(ClusterCheck::behind_all) ? std::ranges::all_of(planes, is_behind)
                                                : std::ranges::any_of(planes, is_behind))
                behind_.push_back(id);
        });
    std::ranges::sort(behind_);
}

// Judges one part.
// @param from  triangles that contain all that meet its shaft; null: all static triangles
ClusterShadows::Verdict ClusterShadows::judge(TriangleId triangle, bool front, const MicroTriangle& part,
                                              std::uint32_t level, const std::vector<TriangleId>* from) const
{
    Verdict verdict;
    const Piece piece(triangles_[triangle], front, part, level);
    if (!piece.has_area()) return verdict;
    const ClusterShaft shaft(piece.corner, piece.normal, bounds_, piece.lift, options_.shaft);
    if (!shaft.rises()) {
        verdict.state = PartState::unlit;
        return verdict;
    }
    const double least = options_.least_part * static_cast<double>(triangles_.bounds().diagonal());
    if (piece.size < least) return verdict;

    // Find what may meet the shaft.
    const auto take = [&](TriangleId id) {
        if (id == triangle || triangles_.role(id) == StaticTriangles::Role::transparent) return;
        if (shaft.may_meet(triangles_[id]) && !std::ranges::binary_search(behind_, id)) verdict.list.push_back(id);
    };
    if (from)
        for (const TriangleId id : *from) take(id);
    else
        triangles_.visit([&](const glm::vec3& low, const glm::vec3& high) { return shaft.may_meet(low, high); }, take);

    // Among very many triangles, nothing is proven for a part that could be smaller.
    const bool divides = static_cast<int>(level) < options_.most_levels && piece.size >= 2 * least &&
                         piece.size > options_.coarse * bounds_.diagonal();
    if (verdict.list.size() > options_.hopeless && divides) {
        verdict.divides = true;
        return verdict;
    }
    const auto outside = [&](TriangleId id) {
        ClippedTriangle inside;
        return !shaft.clip(triangles_[id], inside);
    };
    if (std::ranges::all_of(verdict.list, outside)) {
        verdict.list.clear();
        verdict.state = PartState::lit;
        return verdict;
    }
    std::ranges::sort(verdict.list);
    if (is_dark(piece, shaft, verdict.list)) {
        verdict.list.clear();
        verdict.state = PartState::dark;
        return verdict;
    }
    verdict.divides = divides;
    if (!divides) verdict.list.clear();
    return verdict;
}

// Tries to prove that all of the cluster is hidden (visibility/closed_patch.h). Segments to places above the receiver's
// plane are a convex set, as those of a polygon are.
bool ClusterShadows::is_dark(const Piece& piece, const ClusterShaft& shaft, std::span<const TriangleId> list) const
{
    const glm::dvec3 from = piece.centre() + piece.lift * piece.normal;
    const glm::dvec3 to = from + static_cast<double>(ray::k_shadow_ray_end) * (shaft.place_above() - from);
    const auto is_clear = [&](const StaticTriangle& t, double coordinate) {
        ClippedTriangle inside;
        if (!shaft.clip(t, inside)) return true;
        const double clear = options_.dark.clearance * shaft.lift_for(coordinate);
        for (int c = 0; c < inside.count && makes(ClusterCheck::clear_of_part); ++c)
            if (shaft.height(inside.corner[static_cast<std::size_t>(c)]) < clear) return false;
        if (!makes(ClusterCheck::clear_of_cluster)) return true;
        const glm::dvec3 a(t.p[0]), normal = glm::cross(glm::dvec3(t.p[1]) - a, glm::dvec3(t.p[2]) - a);
        const double length = glm::length(normal);
        return length > 0 && shaft.keeps_clear(inside, normal / length, shaft.most_end_gap() + clear);
    };
    int tried = 0;
    for (const TriangleId id : list) {
        if (visibility::crossing(triangles_[id], from, to) == 0) continue;
        if (visibility::closes(triangles_, shaft, is_clear, id, from, to,
                               {.most_triangles = options_.dark.most_triangles,
                                .no_open_edge = makes(ClusterCheck::no_open_edge),
                                .crosses = makes(ClusterCheck::crosses)}))
            return true;
        constexpr int k_tries = 2;
        if (++tried == k_tries) break;
    }
    return false;
}

}   // namespace gnomon::area_light
