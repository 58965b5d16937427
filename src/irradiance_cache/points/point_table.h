// SPDX-License-Identifier: Apache-2.0
#pragma once
// The table of all cache points, by key: a hash table in shards, each with a lock of its own.
//
// Threads find and create points at the same time. Between frames, points that were unused for longest are dropped if
// the table exceeds its memory.

#include <array>
#include <functional>
#include <mutex>
#include <vector>

#include "irradiance_cache/points/cache_point.h"

namespace gnomon::irradiance_cache {

class PointTable {
 public:
    PointTable();
    /// The point of a key, created if it is missing. Thread-safe; the address stays valid until the point is dropped.
    CachePoint& find_or_create(AnchorKey key);
    /// Records that a point's list of visible nodes, or of divided directions of the sky, changed its length.
    /// Thread-safe.
    void resized(std::size_t before, std::size_t after)
    {
        seen_bytes_.fetch_add((after - before) * sizeof(SeenNode), std::memory_order_relaxed);
    }
    /// Records that a point keeps so many bytes more. Thread-safe.
    void grew(std::ptrdiff_t bytes)
    {
        seen_bytes_.fetch_add(static_cast<std::size_t>(bytes), std::memory_order_relaxed);
    }
    struct Memory {
        std::size_t bytes = 0;   // for points, or twice those of a frame if that is more
        std::size_t ample = 0;   // up to so many, four times those of a frame
    };
    /// Between frames: if the points take more than their memory, drops those unused for longest until a quarter of it
    /// is free. The points of `frame` stay.
    /// @param dropped  called for each
    void drop_unseen(std::uint32_t frame, const Memory& memory, const std::function<void(const CachePoint&)>& dropped);
    /// Between frames: drops all points.
    void clear(const std::function<void(const CachePoint&)>& dropped);
    std::size_t size() const;
    std::size_t bytes() const;

 private:
    static constexpr std::size_t k_shards = 64;
    static std::uint64_t mixed(AnchorKey key)
    {
        key ^= key >> 31;
        key *= 0x9e3779b97f4a7c15ull;
        key ^= key >> 29;
        key *= 0xbf58476d1ce4e5b9ull;
        return key ^ (key >> 32);
    }
    struct Shard {
        std::mutex mutex;
        std::vector<CachePoint*> slots;   // open addressing; a power of two
        std::vector<std::unique_ptr<CachePoint>> points;
    };
    static_assert(sizeof(DividedDirection) == sizeof(SeenNode));
    static void insert(Shard& shard, CachePoint* point);
    std::array<Shard, k_shards> shards_;
    std::atomic<std::size_t> seen_bytes_ = 0;   // of all lists and reaches
};

}   // namespace gnomon::irradiance_cache
