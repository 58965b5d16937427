// SPDX-License-Identifier: Apache-2.0
#include "trace/shared_places.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/hash.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"

namespace gnomon::trace {

namespace {

constexpr float k_part_per_cone = 1;         // the longest edge of a part, in widths of the cone
constexpr std::uint32_t k_most_level = 14;   // a triangle has 4^level parts
constexpr std::uint32_t k_nowhere = 0xffffffff;

}   // namespace

// Finds the part of its triangle in which a point lies, and the triangle's corners.
// @return  whether it shares the part
bool SharedPlaces::divide(const TilePoint& point, const visibility::ShadowPoint& at, Divided& part,
                          glm::vec3 (&p)[3]) const
{
    if (!(point.lobe.rays > 1 || point.parts > 1) || at.object == scene::none) return false;
    const float width = k_part_per_cone * point.surface.cone.width;
    if (!(width > 0)) return false;
    rays_.geometry(at.object).corners(at.triangle, p);
    const float edge = std::max({glm::distance(p[0], p[1]), glm::distance(p[1], p[2]), glm::distance(p[2], p[0])});
    part.level = 0;
    for (float rest = edge; rest > width; rest *= 0.5f)
        if (++part.level > k_most_level) return false;
    const float count = static_cast<float>(1u << part.level);
    const float u = std::clamp(at.u, 0.0f, 1.0f) * count, v = std::clamp(at.v, 0.0f, 1.0f) * count;
    const float column = std::min(std::floor(u), count - 1), row = std::min(std::floor(v), count - 1 - column);
    part.column = static_cast<std::uint32_t>(column), part.row = static_cast<std::uint32_t>(std::max(row, 0.0f));
    part.upper = (u - column) + (v - row) > 1 && column + row + 1 < count;
    return true;
}

// Finds the middle of a part, or adds it.
std::uint32_t SharedPlaces::place(const PlaceKey& key, const visibility::ShadowPoint& at, const Divided& part,
                                  const glm::vec3 (&p)[3])
{
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = hash_bytes(&key, sizeof key) & mask;
    for (; table_[slot].place != k_nowhere; slot = (slot + 1) & mask)
        if (table_[slot].key == key) return table_[slot].place;
    table_[slot] = {key, static_cast<std::uint32_t>(places_.size())};
    shared_keys_.push_back(key);

    const float third = part.upper ? 2.0f / 3 : 1.0f / 3;
    visibility::ShadowPoint& middle = places_.emplace_back(at);
    middle.u = std::ldexp(static_cast<float>(part.column) + third, -static_cast<int>(part.level));
    middle.v = std::ldexp(static_cast<float>(part.row) + third, -static_cast<int>(part.level));
    middle.origin =
        (1 - middle.u - middle.v) * p[0] + middle.u * p[1] + middle.v * p[2] + ray::origin_lift(p) * at.normal;
    return table_[slot].place;
}

void SharedPlaces::find(const PointBatch& batch, std::span<const std::uint32_t> asked)
{
    places_.clear(), own_points_.clear(), shared_keys_.clear();
    place_of_.assign(asked.size(), k_nowhere);
    // Keep the places of points that share none.
    Divided part;
    glm::vec3 p[3];
    for (std::size_t k = 0; k < asked.size(); ++k) {
        if (divide(batch.points[asked[k]], batch.shadow_points[asked[k]], part, p)) continue;
        place_of_[k] = static_cast<std::uint32_t>(places_.size());
        places_.push_back(batch.shadow_points[asked[k]]);
        own_points_.push_back(asked[k]);
    }
    own_ = places_.size();
    if (own_ == asked.size()) return;

    // Find those of the others.
    table_.assign(std::bit_ceil(2 * (asked.size() - own_)), {});
    for (std::size_t k = 0; k < asked.size(); ++k) {
        if (place_of_[k] != k_nowhere) continue;
        const visibility::ShadowPoint& at = batch.shadow_points[asked[k]];
        divide(batch.points[asked[k]], at, part, p);
        const PlaceKey key{std::uint64_t{at.object} << 33 ^ std::uint64_t{at.front} << 32 ^ at.triangle,
                           std::uint64_t{part.level} << 40 | std::uint64_t{part.column} << 20 |
                               std::uint64_t{part.row} << 1 | static_cast<std::uint64_t>(part.upper)};
        place_of_[k] = place(key, at, part, p);
    }
}

}   // namespace gnomon::trace
