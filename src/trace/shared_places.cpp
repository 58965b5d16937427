// SPDX-License-Identifier: Apache-2.0
#include "trace/shared_places.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/hash.h"
#include "base/triangle_edges.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"

namespace gnomon::trace {

namespace {

constexpr float k_part_per_cone = 1;         // the longest edge of a part, in widths of the cone
constexpr float k_cube_per_cone = 0.5f;      // the edge of a cube whose triangles have one place, likewise
constexpr std::uint32_t k_most_level = 14;   // a triangle has 4^level parts
constexpr std::uint32_t k_nowhere = 0xffffffff;

}   // namespace

// Finds the part of its triangle in which a point lies.
// @return  whether it shares the part
bool SharedPlaces::divide(const TilePoint& point, const visibility::ShadowPoint& at, Divided& part)
{
    if (!(point.lobe.rays > 1 || point.parts > 1) || at.object == scene::none) return false;
    const float width = k_part_per_cone * point.surface.cone.width;
    if (!(width > 0)) return false;
    part = {.triangle = at.triangle};
    rays_.geometry(at.object).corners(at.triangle, part.corners);
    const float edge = longest_edge(part.corners);
    for (float rest = edge; rest > width; rest *= 0.5f)
        if (++part.level > k_most_level) return false;
    if (part.level == 0) {
        if (groups_) stand_in(at, width, edge, part);
        return true;
    }
    const float count = static_cast<float>(1u << part.level);
    const float u = std::clamp(at.u, 0.0f, 1.0f) * count, v = std::clamp(at.v, 0.0f, 1.0f) * count;
    const float column = std::min(std::floor(u), count - 1), row = std::min(std::floor(v), count - 1 - column);
    part.column = static_cast<std::uint32_t>(column), part.row = static_cast<std::uint32_t>(std::max(row, 0.0f));
    part.upper = (u - column) + (v - row) > 1 && column + row + 1 < count;
    return true;
}

// Replaces a triangle that is smaller than the cone by the one that stands in for those around it.
void SharedPlaces::stand_in(const visibility::ShadowPoint& at, float width, float edge, Divided& part)
{
    const ray::ObjectGeometry& geometry = rays_.geometry(at.object);
    if (geometry.mesh != mesh_) mesh_ = geometry.mesh, runs_ = &groups_->of(*mesh_);
    const glm::uvec3& index = mesh_->triangles[at.triangle];
    const glm::vec3 rest[3]{mesh_->positions[index[0]], mesh_->positions[index[1]], mesh_->positions[index[2]]};
    const float scale = edge / longest_edge(rest);
    if (!(scale > 0) || !std::isfinite(scale)) return;
    int level = -1;
    while (level + 1 < TriangleRuns::k_levels && runs_->cube(level + 1) * scale <= k_cube_per_cone * width) ++level;
    if (level < 0) return;
    part.triangle = runs_->middle(at.triangle, level);
    geometry.corners(part.triangle, part.corners);
}

// Finds the middle of a part, or adds it.
std::uint32_t SharedPlaces::place(const visibility::ShadowPoint& at, const Divided& part)
{
    const PlaceKey key{std::uint64_t{at.object} << 33 ^ std::uint64_t{at.front} << 32 ^ part.triangle,
                       std::uint64_t{part.level} << 40 | std::uint64_t{part.column} << 20 |
                           std::uint64_t{part.row} << 1 | static_cast<std::uint64_t>(part.upper)};
    const glm::vec3(&p)[3] = part.corners;
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = hash_bytes(&key, sizeof key) & mask;
    for (; table_[slot].place != k_nowhere; slot = (slot + 1) & mask)
        if (table_[slot].key == key) return table_[slot].place;
    table_[slot] = {key, static_cast<std::uint32_t>(places_.size())};
    shared_keys_.push_back(key);

    const float third = part.upper ? 2.0f / 3 : 1.0f / 3;
    visibility::ShadowPoint& middle = places_.emplace_back(at);
    if (part.triangle != at.triangle) {
        const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float double_area = glm::length(cross);
        if (double_area > 0) middle.normal = (at.front ? cross : -cross) / double_area;
        middle.triangle = part.triangle;
    }
    middle.u = std::ldexp(static_cast<float>(part.column) + third, -static_cast<int>(part.level));
    middle.v = std::ldexp(static_cast<float>(part.row) + third, -static_cast<int>(part.level));
    middle.origin =
        (1 - middle.u - middle.v) * p[0] + middle.u * p[1] + middle.v * p[2] + ray::origin_lift(p) * middle.normal;
    return table_[slot].place;
}

void SharedPlaces::find(const PointBatch& batch, std::span<const std::uint32_t> asked)
{
    places_.clear(), own_points_.clear(), shared_keys_.clear(), parts_.clear();
    mesh_ = nullptr;
    place_of_.assign(asked.size(), k_nowhere);
    // Keep the places of points that share none.
    Divided part;
    for (std::size_t k = 0; k < asked.size(); ++k) {
        if (divide(batch.points[asked[k]], batch.shadow_points[asked[k]], part)) {
            parts_.push_back(part);
            continue;
        }
        place_of_[k] = static_cast<std::uint32_t>(places_.size());
        places_.push_back(batch.shadow_points[asked[k]]);
        own_points_.push_back(asked[k]);
    }
    own_ = places_.size();
    if (own_ == asked.size()) return;

    // Find those of the others.
    table_.assign(std::bit_ceil(2 * (asked.size() - own_)), {});
    auto next = parts_.begin();
    for (std::size_t k = 0; k < asked.size(); ++k)
        if (place_of_[k] == k_nowhere) place_of_[k] = place(batch.shadow_points[asked[k]], *next++);
}

}   // namespace gnomon::trace
