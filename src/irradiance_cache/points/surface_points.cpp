// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/surface_points.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

namespace {

constexpr std::size_t k_least_slots = 256;

std::size_t bytes_of(const RememberedPoint& p)
{
    return sizeof(RememberedPoint) + p.count * sizeof(SeenNode);
}

}   // namespace

SurfacePoints::SurfacePoints()
{
    for (Shard& shard : shards_) shard.slots.assign(k_least_slots, nullptr);
}

void SurfacePoints::insert(Shard& shard, RememberedPoint* point)
{
    const std::size_t mask = shard.slots.size() - 1;
    std::size_t slot = (mixed(point->key) >> 6) & mask;
    while (shard.slots[slot]) slot = (slot + 1) & mask;
    shard.slots[slot] = point;
}

RememberedPoint& SurfacePoints::at(AnchorKey key)
{
    const std::uint64_t hash = mixed(key);
    Shard& shard = shards_[hash % k_shards];
    const std::lock_guard lock(shard.mutex);
    const std::size_t mask = shard.slots.size() - 1;
    for (std::size_t slot = (hash >> 6) & mask; shard.slots[slot]; slot = (slot + 1) & mask)
        if (shard.slots[slot]->key == key) return *shard.slots[slot];

    shard.points.push_back(std::make_unique<RememberedPoint>());
    RememberedPoint* const point = shard.points.back().get();
    point->key = key;
    if (2 * shard.points.size() > shard.slots.size()) {
        shard.slots.assign(2 * shard.slots.size(), nullptr);
        for (const auto& p : shard.points) insert(shard, p.get());
    } else {
        insert(shard, point);
    }
    return *point;
}

void SurfacePoints::drop_unseen(std::uint32_t frame, std::size_t budget,
                                const std::function<void(const RememberedPoint&)>& dropped)
{
    const std::size_t all = bytes();
    if (all <= budget) return;
    // By age: which frames must go so that a quarter of the budget is free again.
    constexpr std::uint32_t k_ages = 256;
    std::array<std::size_t, k_ages> size{};
    const auto age_of = [&](const RememberedPoint& p) { return std::min(frame - p.ready.load(), k_ages - 1); };
    for (const Shard& shard : shards_)
        for (const auto& p : shard.points) size[age_of(*p)] += bytes_of(*p);
    // Large images need room for more than their own points, too.
    budget = std::max(budget, 2 * size[0]);
    if (all <= budget) return;
    std::uint32_t oldest = k_ages - 1;
    for (std::size_t left = all; oldest > 0; --oldest) {
        left -= size[oldest];
        if (left <= budget / 4 * 3) break;
    }
    oldest = std::max(oldest, 1u);   // what the last frame shows stays
    for (Shard& shard : shards_) {
        std::erase_if(shard.points, [&](const auto& p) {
            if (age_of(*p) < oldest) return false;
            resized(p->count, 0);
            dropped(*p);
            return true;
        });
        std::fill(shard.slots.begin(), shard.slots.end(), nullptr);
        for (const auto& p : shard.points) insert(shard, p.get());
    }
}

void SurfacePoints::clear(const std::function<void(const RememberedPoint&)>& dropped)
{
    for (Shard& shard : shards_) {
        for (const auto& p : shard.points) dropped(*p);
        shard.points.clear();
        shard.slots.assign(k_least_slots, nullptr);
    }
    seen_bytes_ = 0;
}

std::size_t SurfacePoints::size() const
{
    std::size_t sum = 0;
    for (const Shard& shard : shards_) sum += shard.points.size();
    return sum;
}

std::size_t SurfacePoints::bytes() const
{
    std::size_t sum = 0;
    for (const Shard& shard : shards_) {
        sum += (shard.slots.size() + shard.points.size()) * sizeof(void*);
        sum += shard.points.size() * sizeof(RememberedPoint);
    }
    return sum + seen_bytes_.load();
}

}   // namespace gnomon::irradiance_cache
