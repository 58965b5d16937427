// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/point_table.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

namespace {

constexpr std::size_t k_least_slots = 256;

std::size_t bytes_of(const CachePoint& p)
{
    return sizeof(CachePoint) + (p.count + p.divided_sky.size()) * sizeof(SeenNode) + p.near_reach.size();
}

}   // namespace

PointTable::PointTable()
{
    for (Shard& shard : shards_) shard.slots.assign(k_least_slots, nullptr);
}

void PointTable::insert(Shard& shard, CachePoint* point)
{
    const std::size_t mask = shard.slots.size() - 1;
    std::size_t slot = (mixed(point->key) >> 6) & mask;
    while (shard.slots[slot]) slot = (slot + 1) & mask;
    shard.slots[slot] = point;
}

CachePoint& PointTable::find_or_create(AnchorKey key)
{
    const std::uint64_t hash = mixed(key);
    Shard& shard = shards_[hash % k_shards];
    const std::lock_guard lock(shard.mutex);
    const std::size_t mask = shard.slots.size() - 1;
    for (std::size_t slot = (hash >> 6) & mask; shard.slots[slot]; slot = (slot + 1) & mask)
        if (shard.slots[slot]->key == key) return *shard.slots[slot];

    shard.points.push_back(std::make_unique<CachePoint>());
    CachePoint* const point = shard.points.back().get();
    point->key = key;
    if (2 * shard.points.size() > shard.slots.size()) {
        shard.slots.assign(2 * shard.slots.size(), nullptr);
        for (const auto& p : shard.points) insert(shard, p.get());
    } else {
        insert(shard, point);
    }
    return *point;
}

void PointTable::drop_unseen(std::uint32_t frame, const Memory& memory,
                             const std::function<void(const CachePoint&)>& dropped)
{
    const std::size_t all = bytes();
    if (all <= memory.bytes) return;
    // Sum the points' bytes by age.
    constexpr std::uint32_t k_ages = 256;
    std::array<std::size_t, k_ages> size{};
    const auto age_of = [&](const CachePoint& p) { return std::min(frame - p.ready.load(), k_ages - 1); };
    for (const Shard& shard : shards_)
        for (const auto& p : shard.points) size[age_of(*p)] += bytes_of(*p);
    // Raise the budget for large images.
    const std::size_t budget = std::max({memory.bytes, 2 * size[0], std::min(4 * size[0], memory.ample)});
    if (all <= budget) return;
    // Find the age from which points are dropped, so that a quarter of the budget is free again.
    std::uint32_t oldest = k_ages - 1;
    for (std::size_t left = all; oldest > 0; --oldest) {
        left -= size[oldest];
        if (left <= budget / 4 * 3) break;
    }
    oldest = std::max(oldest, 1u);   // points of the last frame stay
    for (Shard& shard : shards_) {
        std::erase_if(shard.points, [&](const auto& p) {
            if (age_of(*p) < oldest) return false;
            resized(p->count + p->divided_sky.size(), 0);
            grew(-static_cast<std::ptrdiff_t>(p->near_reach.size()));
            dropped(*p);
            return true;
        });
        std::fill(shard.slots.begin(), shard.slots.end(), nullptr);
        for (const auto& p : shard.points) insert(shard, p.get());
    }
}

void PointTable::clear(const std::function<void(const CachePoint&)>& dropped)
{
    for (Shard& shard : shards_) {
        for (const auto& p : shard.points) dropped(*p);
        shard.points.clear();
        shard.slots.assign(k_least_slots, nullptr);
    }
    seen_bytes_ = 0;
}

std::size_t PointTable::size() const
{
    std::size_t sum = 0;
    for (const Shard& shard : shards_) sum += shard.points.size();
    return sum;
}

std::size_t PointTable::bytes() const
{
    std::size_t sum = 0;
    for (const Shard& shard : shards_) {
        sum += (shard.slots.size() + shard.points.size()) * sizeof(void*);
        sum += shard.points.size() * sizeof(CachePoint);
    }
    return sum + seen_bytes_.load();
}

}   // namespace gnomon::irradiance_cache
