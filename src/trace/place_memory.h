// SPDX-License-Identifier: Apache-2.0
#pragma once
// What shared places (shared_places.h) see of an environment image, for all tiles of a frame, and of later frames as
// long as nothing moves.
//
// Rays of rough lobes from many tiles meet the same surfaces. Each place is therefore evaluated once, by the thread
// that asks first; a thread that needs a place which another one evaluates waits for it. A thread publishes everything
// that it claimed before it waits, so waits form no cycle. If an evaluation fails, its places are abandoned, and who
// waits for them evaluates them for itself.
//
// Cost: a look-up under one of 64 locks. Memory: some 200 bytes for each place.

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <vector>

#include "base/math.h"
#include "environment_light/cell_light.h"

namespace gnomon::trace {

/// A part of a side of a triangle.
struct PlaceKey {
    std::uint64_t triangle = 0, part = 0;
    friend bool operator==(const PlaceKey&, const PlaceKey&) = default;
};

class PlaceMemory {
 public:
    class Place {
     public:
        /// Of the cells that the place sees. @pre published
        std::span<const std::uint64_t> seen() const { return seen_; }
        /// On a surface with the normal of the triangle. @pre published
        const glm::vec3& irradiance() const { return from_cells_.irradiance; }
        const environment_light::FromCells& from_cells() const { return from_cells_; }

     private:
        friend class PlaceMemory;
        PlaceKey key_;
        std::vector<std::uint64_t> seen_;
        environment_light::FromCells from_cells_;
        enum class Stage : std::uint32_t { claimed, published, abandoned };
        std::atomic<Stage> stage_ = Stage::claimed;
    };

    /// Forgets all places if there are many, or if some were abandoned. Call between frames.
    void begin_frame();
    void forget();

    /// Finds a place, or adds it. Thread-safe.
    /// @param is_own  out: the caller has to publish or abandon it
    Place& find(const PlaceKey& key, bool& is_own);
    /// Thread-safe.
    static void publish(Place& place, std::span<const std::uint64_t> seen,
                        const environment_light::FromCells& from_cells);
    void abandon(Place& place) noexcept;
    /// Waits for the thread that evaluates a place. Only after publishing what the caller claimed.
    /// @return  whether it was published; otherwise it was abandoned
    static bool wait(const Place& place);

    std::size_t size() const;
    std::size_t bytes() const;

 private:
    static constexpr std::size_t k_shards = 64, k_most = std::size_t{1} << 20;   // places, kept between frames
    struct Shard {
        mutable std::mutex mutex;
        std::deque<Place> places;
        std::vector<Place*> table;   // a power of two, at most half full
    };
    static void grow(Shard& shard);
    std::array<Shard, k_shards> shards_;
    std::atomic<bool> some_abandoned_ = false;
};

}   // namespace gnomon::trace
