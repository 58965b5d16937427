// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_hints.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "irradiance_cache/near_field/near_light.h"
#include "ray/origin.h"

namespace gnomon::irradiance_cache {

namespace {

// A cell's name: triangle | place among its cells | side. A word of a table: name | state.
constexpr int k_state_bits = 2, k_front_bits = 1, k_place_bits = 14;
constexpr std::size_t k_least_slots = 64;

constexpr std::uint64_t word_of(NearHints::Cell cell, NearHints::State state)
{
    return (cell << k_state_bits) | static_cast<std::uint64_t>(state);
}

constexpr NearHints::State state_in(std::uint64_t word)
{
    return static_cast<NearHints::State>(word & ((1u << k_state_bits) - 1));
}

constexpr std::uint64_t mixed(NearHints::Cell cell)
{
    cell *= 0x9e3779b97f4a7c15ull;
    cell ^= cell >> 29;
    cell *= 0xbf58476d1ce4e5b9ull;
    return cell ^ (cell >> 32);
}

}   // namespace

NearHints::NearHints(const NearHintOptions& options) : options_(options), directions_(cosine_directions(options.rays))
{
    GNOMON_CHECK(options.most_cells >= 1 && options.most_cells * options.most_cells <= 1 << k_place_bits);
}

std::uint32_t NearHints::cells_along(const glm::vec3 (&p)[3]) const
{
    const float cell = options_.cell * options_.radius;
    const float longest = std::max({glm::length(p[1] - p[0]), glm::length(p[2] - p[1]), glm::length(p[0] - p[2])});
    if (!(longest > cell)) return 1;
    return static_cast<std::uint32_t>(std::min(std::ceil(longest / cell), static_cast<float>(options_.most_cells)));
}

NearHints::Cell NearHints::cell_at(std::uint32_t triangle, std::uint32_t side, float u, float v, bool front)
{
    const auto at = [&](float x) {
        return std::min(static_cast<std::uint32_t>(std::max(0.0f, x) * static_cast<float>(side)), side - 1);
    };
    const std::uint64_t place = at(u) * side + at(v);
    return (((Cell{triangle} << k_place_bits) | place) << k_front_bits) | (front ? 1u : 0u);
}

std::uint64_t* NearHints::Table::find(Cell cell)
{
    if (slots.empty()) return nullptr;
    const std::size_t mask = slots.size() - 1;
    for (std::size_t slot = mixed(cell) & mask; slots[slot] != 0; slot = (slot + 1) & mask)
        if (slots[slot] >> k_state_bits == cell) return &slots[slot];
    return nullptr;
}

void NearHints::Table::add(std::uint64_t word)
{
    const auto put = [](std::vector<std::uint64_t>& into, std::uint64_t w) {
        const std::size_t mask = into.size() - 1;
        std::size_t slot = mixed(w >> k_state_bits) & mask;
        while (into[slot] != 0) slot = (slot + 1) & mask;
        into[slot] = w;
    };
    if (2 * (taken + 1) > slots.size()) {
        std::vector<std::uint64_t> wider(std::max(2 * slots.size(), k_least_slots));
        for (const std::uint64_t w : slots)
            if (w != 0) put(wider, w);
        slots.swap(wider);
    }
    put(slots, word);
    ++taken;
}

NearHints::Shard& NearHints::shard_of(Cell cell)
{
    return shards_[mixed(cell) >> 58];
}

std::uint64_t* NearHints::find(Shard& shard, Cell cell)
{
    if (std::uint64_t* const word = shard.now.find(cell)) return word;
    const std::uint64_t* const old = shard.before.find(cell);
    if (!old) return nullptr;
    shard.now.add(*old);
    return shard.now.find(cell);
}

NearHints::State NearHints::state(Cell cell)
{
    Shard& shard = shard_of(cell);
    const std::lock_guard lock(shard.mutex);
    const std::uint64_t* const word = find(shard, cell);
    return word ? state_in(*word) : State::unknown;
}

NearHints::State NearHints::claim(Cell cell)
{
    Shard& shard = shard_of(cell);
    const std::lock_guard lock(shard.mutex);
    if (const std::uint64_t* const word = find(shard, cell)) return state_in(*word);
    shard.now.add(word_of(cell, State::claimed));
    return State::unknown;
}

void NearHints::answer(const ray::RayScene& rays, const std::vector<Claim>& claims, Scratch& scratch)
{
    // Spread the origins over the cell by a lattice of irrational steps, and give each a direction of its own.
    constexpr float k_step_u = 0.7548777f, k_step_v = 0.5698403f;
    const auto count = static_cast<std::size_t>(options_.rays);
    scratch.rays.clear();
    scratch.rays.purpose = ray::RayClass::indirect;
    for (const Claim& a : claims) {
        glm::vec3 p[3];
        rays.geometry(a.object).corners(a.triangle, p);
        glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float length = glm::length(normal);
        normal = length > 0 ? normal / (a.cell & 1 ? length : -length) : glm::vec3(0, 0, 1);
        glm::vec3 t, b;
        make_basis(normal, t, b);
        const float lift = ray::origin_lift(p);
        const auto place = static_cast<std::uint32_t>(a.cell >> k_front_bits) & ((1u << k_place_bits) - 1);
        const std::uint32_t row = place / a.side, column = place % a.side;
        const auto per_side = 1 / static_cast<float>(a.side);
        for (std::size_t i = 0; i < count; ++i) {
            const float x = static_cast<float>(i) * k_step_u, y = static_cast<float>(i) * k_step_v;
            float u = (static_cast<float>(row) + (x - std::floor(x))) * per_side;
            float v = (static_cast<float>(column) + (y - std::floor(y))) * per_side;
            if (u + v > 1) {
                // Mirror the origin into the triangle if the hypotenuse cuts the cell. Cells beyond it are never used.
                const float over = u + v - 1;
                u = std::max(u - over, 0.0f), v = std::max(v - over, 0.0f);
                if (u + v > 1) u = 1 - v;
            }
            const glm::vec3 from = (1 - u - v) * p[0] + u * p[1] + v * p[2] + lift * normal;
            const glm::vec3& d = directions_[i];
            scratch.rays.push(from, 0, d.x * t + d.y * b + d.z * normal, options_.reach * options_.radius);
        }
    }
    scratch.hits.resize(scratch.rays.size());
    rays.closest(scratch.rays, 0, scratch.rays.size(), scratch.hits, ray::Sides::both, ray::Against::static_only);
    scratch.cast += scratch.rays.size();
    // Store the answers, and wake those who wait for them.
    for (std::size_t k = 0; k < claims.size(); ++k) {
        const auto first = scratch.hits.object.begin() + static_cast<std::ptrdiff_t>(k * count);
        const bool any = std::any_of(first, first + static_cast<std::ptrdiff_t>(count),
                                     [](scene::ObjectId object) { return object != scene::none; });
        const Cell cell = claims[k].cell;
        Shard& shard = shard_of(cell);
        const std::lock_guard lock(shard.mutex);
        std::uint64_t* const word = shard.now.find(cell);
        GNOMON_CHECK(word);
        *word = word_of(cell, any ? State::near : State::none);
    }
    {
        const std::lock_guard lock(wait_mutex_);
    }   // whoever saw a claimed cell waits by now
    answered_.notify_all();
}

void NearHints::abandon() noexcept
{
    {
        const std::lock_guard lock(wait_mutex_);
        abandoned_ = true;
    }
    answered_.notify_all();
}

NearHints::State NearHints::wait(Cell cell)
{
    State now = state(cell);
    if (now != State::claimed) return now;
    std::unique_lock lock(wait_mutex_);
    answered_.wait(lock, [&] {
        now = state(cell);
        return now != State::claimed || abandoned_;
    });
    return now;
}

void NearHints::end_frame()
{
    if (bytes() <= options_.memory) return;
    for (Shard& shard : shards_) {
        shard.before = std::move(shard.now);
        shard.now = {};
    }
}

std::size_t NearHints::bytes() const
{
    std::size_t slots = 0;
    for (const Shard& shard : shards_) slots += shard.now.slots.size() + shard.before.slots.size();
    return slots * sizeof(std::uint64_t);
}

}   // namespace gnomon::irradiance_cache
