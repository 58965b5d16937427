// SPDX-License-Identifier: Apache-2.0
#include "trace/place_memory.h"

#include "base/hash.h"

namespace gnomon::trace {

namespace {

constexpr std::size_t k_first_slots = 256;

std::size_t hash_of(const PlaceKey& key)
{
    return hash_bytes(&key, sizeof key);
}

}   // namespace

void PlaceMemory::begin_frame()
{
    if (some_abandoned_ || size() > k_most) forget();
}

void PlaceMemory::forget()
{
    for (Shard& shard : shards_) {
        shard.table.clear();
        shard.places.clear();
    }
    some_abandoned_ = false;
}

void PlaceMemory::grow(Shard& shard)
{
    shard.table.assign(std::max(k_first_slots, 2 * shard.table.size()), nullptr);
    const std::size_t mask = shard.table.size() - 1;
    for (Place& place : shard.places) {
        std::size_t slot = hash_of(place.key_) / k_shards & mask;
        while (shard.table[slot]) slot = (slot + 1) & mask;
        shard.table[slot] = &place;
    }
}

PlaceMemory::Place& PlaceMemory::find(const PlaceKey& key, bool& is_own)
{
    const std::size_t hash = hash_of(key);
    Shard& shard = shards_[hash % k_shards];
    const std::lock_guard lock(shard.mutex);
    if (2 * (shard.places.size() + 1) > shard.table.size()) grow(shard);
    const std::size_t mask = shard.table.size() - 1;
    std::size_t slot = hash / k_shards & mask;
    is_own = false;
    for (; shard.table[slot]; slot = (slot + 1) & mask)
        if (shard.table[slot]->key_ == key) return *shard.table[slot];
    is_own = true;
    Place& place = shard.places.emplace_back();
    place.key_ = key;
    shard.table[slot] = &place;
    return place;
}

void PlaceMemory::publish(Place& place, std::span<const std::uint64_t> seen,
                          const environment_light::FromCells& from_cells)
{
    place.seen_.assign(seen.begin(), seen.end());
    place.from_cells_ = from_cells;
    place.stage_ = Place::Stage::published;
    place.stage_.notify_all();
}

void PlaceMemory::abandon(Place& place) noexcept
{
    some_abandoned_ = true;
    place.stage_ = Place::Stage::abandoned;
    place.stage_.notify_all();
}

bool PlaceMemory::wait(const Place& place)
{
    place.stage_.wait(Place::Stage::claimed);
    return place.stage_ == Place::Stage::published;
}

std::size_t PlaceMemory::size() const
{
    std::size_t size = 0;
    for (const Shard& shard : shards_) {
        const std::lock_guard lock(shard.mutex);
        size += shard.places.size();
    }
    return size;
}

std::size_t PlaceMemory::bytes() const
{
    std::size_t bytes = 0;
    for (const Shard& shard : shards_) {
        const std::lock_guard lock(shard.mutex);
        bytes += shard.table.size() * sizeof(Place*);
        for (const Place& place : shard.places) bytes += sizeof place + place.seen_.size() * sizeof(std::uint64_t);
    }
    return bytes;
}

}   // namespace gnomon::trace
