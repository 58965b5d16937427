// SPDX-License-Identifier: Apache-2.0
#include "trace/place_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/hash.h"
#include "base/triangle_edges.h"
#include "ray/origin.h"
#include "ray/ray_scene.h"

namespace gnomon::trace {

namespace {

constexpr std::uint32_t k_most_level = 14;   // a triangle has 2^level steps along an edge
constexpr std::uint32_t k_nowhere = 0xffffffff;

}   // namespace

bool PlaceLattice::has_lattice(const PointBatch& batch, std::uint32_t point) const
{
    const TilePoint& of = batch.points[point];
    return !(of.lobe.rays > 1) && batch.shadow_points[point].object != scene::none && of.surface.cone.width > 0;
}

// Finds a place of the lattice, or adds it.
std::uint32_t PlaceLattice::place_at(const visibility::ShadowPoint& at, const glm::vec3 (&p)[3], std::uint32_t level,
                                     std::uint32_t column, std::uint32_t row)
{
    const Key key{std::uint64_t{at.object} << 33 ^ std::uint64_t{at.front} << 32 ^ at.triangle,
                  std::uint64_t{level} << 40 | std::uint64_t{column} << 20 | row};
    const std::size_t mask = table_.size() - 1;
    std::size_t slot = hash_bytes(&key, sizeof key) & mask;
    for (; table_[slot].place != k_nowhere; slot = (slot + 1) & mask)
        if (table_[slot].key == key) return table_[slot].place;
    table_[slot] = {key, static_cast<std::uint32_t>(places_.size())};

    constexpr float k_middle = 1 / 3.f;
    const auto inset = [&](std::uint32_t step) {
        const float whole = std::ldexp(static_cast<float>(step), -static_cast<int>(level));
        return k_middle + (1 - options_.inset) * (whole - k_middle);
    };
    visibility::ShadowPoint& place = places_.emplace_back(at);
    place.u = inset(column), place.v = inset(row);
    place.origin = (1 - place.u - place.v) * p[0] + place.u * p[1] + place.v * p[2] + ray::origin_lift(p) * at.normal;
    return table_[slot].place;
}

void PlaceLattice::find_around(const PointBatch& batch, std::uint32_t point, Around& around)
{
    // Choose the step.
    const visibility::ShadowPoint& at = batch.shadow_points[point];
    glm::vec3 p[3];
    rays_.geometry(at.object).corners(at.triangle, p);
    const float step = options_.step * batch.points[point].surface.cone.width;
    std::uint32_t level = 0;
    for (float rest = longest_edge(p); rest > step; rest *= 0.5f)
        if (++level > k_most_level) return;
    if (level < static_cast<std::uint32_t>(options_.least_level)) return;

    // Find the triangle of the lattice around the point; beyond the lattice's edge, the nearest one.
    constexpr float k_middle = 1 / 3.f;
    const auto outset = [&](float x) { return std::max(k_middle + (x - k_middle) / (1 - options_.inset), 0.0f); };
    float u = outset(at.u), v = outset(at.v);
    if (u + v > 1) {
        const float sum = u + v;
        u /= sum, v /= sum;
    }
    const auto count = static_cast<float>(1u << level);
    u *= count, v *= count;
    const float column = std::min(std::floor(u), count - 1), row = std::clamp(std::floor(v), 0.0f, count - 1 - column);
    const float beside = std::clamp(u - column, 0.0f, 1.0f), above = std::clamp(v - row, 0.0f, 1.0f);
    const auto x = static_cast<std::uint32_t>(column), y = static_cast<std::uint32_t>(row);
    const bool upper = beside + above > 1 && column + row + 1 < count;

    // Interpolate between its corners.
    if (upper) {
        around.place = {place_at(at, p, level, x + 1, y + 1), place_at(at, p, level, x, y + 1),
                        place_at(at, p, level, x + 1, y)};
        around.weight = {beside + above - 1, 1 - beside, 1 - above};
    } else {
        around.place = {place_at(at, p, level, x, y), place_at(at, p, level, x + 1, y),
                        place_at(at, p, level, x, y + 1)};
        around.weight = {std::max(1 - beside - above, 0.0f), beside, above};
    }
    const float sum = around.weight[0] + around.weight[1] + around.weight[2];
    for (float& weight : around.weight) weight /= sum;
}

// Leaves out points whose places serve few points, and places that are of no use then.
void PlaceLattice::leave_rare()
{
    uses_.assign(places_.size(), 0);
    for (const Around& around : around_)
        if (around.any())
            for (const std::uint32_t place : around.place) ++uses_[place];
    kept_.assign(places_.size(), k_nowhere);
    for (Around& around : around_) {
        if (!around.any()) continue;
        std::uint32_t uses = 0;
        for (const std::uint32_t place : around.place) uses += uses_[place];
        if (uses < options_.uses)
            around = {};
        else
            for (const std::uint32_t place : around.place) kept_[place] = 0;
    }
    std::uint32_t count = 0;
    for (std::size_t place = 0; place < places_.size(); ++place) {
        if (kept_[place] == k_nowhere) continue;
        places_[count] = places_[place];
        kept_[place] = count++;
    }
    places_.resize(count);
    for (Around& around : around_)
        if (around.any())
            for (std::uint32_t& place : around.place) place = kept_[place];
}

void PlaceLattice::find(const PointBatch& batch, std::span<const std::uint32_t> asked)
{
    places_.clear();
    around_.assign(asked.size(), {});
    if (batch.primary) return;
    const auto with = static_cast<std::size_t>(
        std::ranges::count_if(asked, [&](std::uint32_t point) { return has_lattice(batch, point); }));
    if (with == 0) return;
    table_.assign(std::bit_ceil(6 * with), {});
    for (std::size_t k = 0; k < asked.size(); ++k)
        if (has_lattice(batch, asked[k])) find_around(batch, asked[k], around_[k]);
    leave_rare();
}

}   // namespace gnomon::trace
