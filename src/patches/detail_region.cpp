// SPDX-License-Identifier: Apache-2.0
#include "patches/detail_region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace gnomon::patches {

namespace {

constexpr double k_ground = 0.5;            // of the area, from which on a plane is the ground
constexpr double k_normal_steps = 1024;     // of a normal's coordinates, within which two are the same
constexpr double k_offset_steps = 4096;     // of the extent, likewise for planes
constexpr double k_least_piece = 0x1p-16;   // of the area; smaller ones are not counted as parts of a plane

// A plane, whichever way it faces.
using Plane = std::array<std::int64_t, 4>;

std::optional<Plane> plane_of(const FlatPiece& piece, double extent)
{
    const glm::dvec3 a(piece.corners[0]), b(piece.corners[1]), c(piece.corners[2]);
    glm::dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
    normal /= length;
    const glm::dvec3 size = glm::abs(normal);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    if (normal[axis] < 0) normal = -normal;
    const double offset = glm::dot(normal, a) / extent;
    return Plane{std::llround(k_normal_steps * normal.x), std::llround(k_normal_steps * normal.y),
                 std::llround(k_normal_steps * normal.z), std::llround(k_offset_steps * offset)};
}

// Where dynamic objects are when the clip begins; of skinned ones, where their joints are.
Box3 box_of_dynamic_objects(const scene::SceneState& state)
{
    Box3 box;
    if (state.dynamic_objects().empty()) return box;
    const scene::Scene& scene = state.scene();
    const std::vector<glm::dmat4> world = scene.world_matrices(scene.timeline.start);
    std::map<scene::MeshId, Box3> bounds;
    for (const scene::ObjectId o : state.dynamic_objects()) {
        const scene::Object& object = scene.objects[o];
        if (object.by_default || object.removed) continue;
        if (object.skin != scene::none) {
            for (const scene::NodeId joint : scene.skins[object.skin].joints) box.add(glm::vec3(world[joint][3]));
            continue;
        }
        const auto [at, is_new] = bounds.try_emplace(object.mesh);
        if (is_new) at->second = scene.meshes[object.mesh].bounds();
        const Box3& of = at->second;
        if (of.empty()) continue;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p((corner & 1) ? of.high.x : of.low.x, (corner & 2) ? of.high.y : of.low.y,
                               (corner & 4) ? of.high.z : of.low.z);
            box.add(glm::vec3(transform_point(world[object.node], p)));
        }
    }
    return box;
}

}   // namespace

DetailRegion::DetailRegion(const scene::SceneState& state, std::size_t count,
                           const std::function<FlatPiece(std::size_t)>& piece)
{
    const auto visit = [&](auto&& visitor) {
        for (std::size_t i = 0; i < count; ++i)
            if (const FlatPiece p = piece(i); p.area > 0 && !p.added) visitor(p);
    };
    const Box3 moving = box_of_dynamic_objects(state);
    Box3 own = moving;
    double left = 0;
    visit([&](const FlatPiece& p) {
        for (const glm::vec3& corner : p.corners) own.add(corner);
        left += static_cast<double>(p.area);
    });
    const glm::vec3 size = own.size();
    const auto extent = static_cast<double>(std::max({size.x, size.y, size.z}));
    if (!(extent > 0) || !std::isfinite(extent)) return;

    // Leave out the ground, then what is the ground of the rest.
    std::map<Plane, double> area;
    const double least = k_least_piece * left;
    visit([&](const FlatPiece& p) {
        if (static_cast<double>(p.area) < least) return;
        if (const std::optional<Plane> plane = plane_of(p, extent)) area[*plane] += static_cast<double>(p.area);
    });
    std::vector<Plane> grounds;
    box_ = own;
    while (!area.empty()) {
        const auto largest = std::max_element(area.begin(), area.end(),
                                              [](const auto& a, const auto& b) { return a.second < b.second; });
        if (!(largest->second > k_ground * left)) break;
        left -= largest->second;
        grounds.push_back(largest->first);
        area.erase(largest);
        Box3 rest = moving;
        visit([&](const FlatPiece& p) {
            const std::optional<Plane> plane = plane_of(p, extent);
            if (plane && std::ranges::find(grounds, *plane) != grounds.end()) return;
            for (const glm::vec3& corner : p.corners) rest.add(corner);
        });
        if (rest.empty()) break;
        box_ = rest;
    }
    const float half = 0.5f * box_.diagonal();
    if (half > 0 && std::isfinite(half)) size_ = half;
}

float DetailRegion::distance(const glm::vec3& point) const
{
    if (!(size_ < k_infinity)) return 0;
    const glm::vec3 beyond = glm::max(glm::max(box_.low - point, point - box_.high), glm::vec3(0));
    return glm::length(beyond);
}

float DetailRegion::weight(const glm::vec3& point) const
{
    const float far = distance(point);
    if (!(far > size_)) return 1;
    const float ratio = size_ / far;
    return ratio * ratio * ratio;
}

bool DetailRegion::holds(const glm::vec3 (&corners)[3]) const
{
    return std::ranges::all_of(corners, [&](const glm::vec3& corner) { return !(distance(corner) > size_); });
}

}   // namespace gnomon::patches
