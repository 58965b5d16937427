// SPDX-License-Identifier: Apache-2.0
#include "area_light/area_shadows.h"

#include <algorithm>
#include <span>

namespace gnomon::area_light {

namespace {

using visibility::StaticTriangle;
using visibility::StaticTriangles;
using visibility::TriangleId;

double diameter_of(const LightPolygon& light)
{
    double most = 0;
    for (int a = 0; a < light.corners; ++a)
        for (int b = 0; b < a; ++b)
            most = std::max(most, static_cast<double>(glm::length(light.corner[static_cast<std::size_t>(a)] -
                                                                  light.corner[static_cast<std::size_t>(b)])));
    return most;
}

// A point in the middle of what of a part lies before the light. A segment that began behind the light would tell
// nothing about those from before it.
glm::dvec3 centre_before(const AreaShaft& shaft, const glm::dvec3 (&corner)[3])
{
    glm::dvec3 sum(0);
    int count = 0;
    for (int c = 0; c < 3; ++c) {
        const glm::dvec3 &a = corner[c], &b = corner[(c + 1) % 3];
        const double at_a = shaft.light_height(a), at_b = shaft.light_height(b);
        if (at_a > 0) sum += a, ++count;
        if ((at_a > 0) != (at_b > 0)) sum += a + at_a / (at_a - at_b) * (b - a), ++count;
    }
    return sum / static_cast<double>(std::max(count, 1));
}

}   // namespace

AreaShadows::AreaShadows(const StaticTriangles& triangles, const FlatLight& light, const AreaOptions& options)
    : PartTree(triangles, options.most_levels), places_(light), options_(options), diameter_(diameter_of(light.outline))
{
}

// Judges one part.
// @param from  triangles that contain all that meet its shaft; null: all static triangles
AreaShadows::Verdict AreaShadows::judge(TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                                        const std::vector<TriangleId>* from) const
{
    Verdict verdict;
    const Piece piece(triangles_[triangle], front, part, level);
    if (!piece.has_area()) return verdict;

    // What lies behind needs no proof. Near the horizon, within rounding, rays decide.
    const LightPolygon& light = places_.polygon();
    const ClippedLight above = clip_light(light, piece.normal, piece.distance);
    if (above.count == 0) {
        verdict.state = PartState::unlit;
        return verdict;
    }
    const AreaShaft shaft(piece.corner, piece.normal, above, glm::dvec3(light.normal), piece.lift, options_.shaft);
    if (!shaft.faces_light()) {
        verdict.state = PartState::unlit;
        return verdict;
    }

    // Find what may meet the shaft.
    const auto take = [&](TriangleId id) {
        const StaticTriangles::Role role = triangles_.role(id);
        if (id == triangle || role == StaticTriangles::Role::transparent) return;
        if (shaft.may_meet(triangles_[id])) verdict.list.push_back(id);
    };
    if (from)
        for (const TriangleId id : *from) take(id);
    else
        triangles_.visit([&](const glm::vec3& low, const glm::vec3& high) { return shaft.may_meet(low, high); }, take);

    // Among very many triangles, nothing is proven for a part that could be smaller.
    const auto divides = [&] {
        const bool many = verdict.list.size() > options_.short_list;
        return static_cast<int>(level) < options_.most_levels &&
               piece.size > (many ? options_.fine : options_.coarse) * diameter_;
    };
    if (verdict.list.size() > options_.hopeless && divides()) {
        verdict.divides = true;
        return verdict;
    }
    const auto outside = [&](TriangleId id) {
        ClippedTriangle inside;
        return !shaft.clip(triangles_[id], inside);
    };
    // One triangle inside is enough to know that it is not lit. Few others are outside. Most often, one of the first
    // has a corner inside.
    const bool smaller = divides();
    const auto some = std::span(verdict.list).first(std::min<std::size_t>(verdict.list.size(), 8));
    const bool met = std::ranges::any_of(some, [&](TriangleId id) { return shaft.has_corner_inside(triangles_[id]); });
    if (!met && std::all_of(verdict.list.begin(), verdict.list.end(), outside)) verdict.list.clear();
    if (verdict.list.empty()) {
        verdict.state = PartState::lit;
        return verdict;
    }
    std::sort(verdict.list.begin(), verdict.list.end());

    // Try to prove that all of it is hidden.
    glm::dvec3 centre = centre_before(shaft, piece.corner) + piece.lift * piece.normal, target(0);
    for (int k = 0; k < above.count; ++k) target += above.corner[static_cast<std::size_t>(k)] / double(above.count);
    target = centre + static_cast<double>(ray::k_shadow_ray_end) * (target - centre);
    int tried = 0;
    for (const TriangleId id : verdict.list) {
        if (visibility::crossing(triangles_[id], centre, target) == 0) continue;
        if (proves_dark(triangles_, shaft, id, centre, target, options_.dark)) {
            verdict.state = PartState::dark;
            verdict.list.clear();
            return verdict;
        }
        constexpr int k_tries = 2;
        if (++tried == k_tries) break;
    }

    // Divide it if smaller parts may know more.
    if (smaller) {
        verdict.divides = true;
        return verdict;
    }
    verdict.state = verdict.list.size() > options_.longest_list ? PartState::open : PartState::listed;
    if (verdict.state == PartState::open) verdict.list.clear();
    return verdict;
}

}   // namespace gnomon::area_light
