// SPDX-License-Identifier: Apache-2.0
#include "light_quadtree/surface_points.h"

#include <algorithm>

namespace gnomon::light_quadtree {

SurfacePoints::SurfacePoints()
{
    for (Shard& shard : shards_) shard.slots.assign(256, nullptr);
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

void SurfacePoints::drop_unseen(std::uint32_t frame, std::size_t budget)
{
    if (bytes() <= budget) return;
    for (Shard& shard : shards_) {
        std::erase_if(shard.points, [&](const auto& p) { return p->ready.load() < frame; });
        std::fill(shard.slots.begin(), shard.slots.end(), nullptr);
        for (const auto& p : shard.points) insert(shard, p.get());
    }
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
        for (const auto& p : shard.points) sum += sizeof(RememberedPoint) + p->count * sizeof(SeenNode);
    }
    return sum;
}

}   // namespace gnomon::light_quadtree
