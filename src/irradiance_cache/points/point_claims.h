// SPDX-License-Identifier: Apache-2.0
#pragma once
// Distributes the evaluation of cache points over threads: each point is evaluated by one thread per frame.
//
// A thread finds the points that it needs (find_or_create). A point that no thread has claimed in this frame becomes
// its own to evaluate; one that another thread claimed and has not published is awaited. A thread evaluates and
// publishes everything that it claimed before it waits, and nothing in between waits; so waits form no cycle, and a
// thread that waits holds up no other. Waiting sleeps on the point's atomic. If an evaluation fails, the points of that
// thread are abandoned, and whoever waits for them fails in the same way.
//
// Cost: a look-up in a table of recent points, or else in the point table, under one of its locks.

#include <algorithm>
#include <array>
#include <exception>
#include <mutex>
#include <span>
#include <vector>

#include "irradiance_cache/points/point_table.h"

namespace gnomon::irradiance_cache {

/// The first failure of a frame. Thread-safe.
class FrameFailure {
 public:
    void record(std::exception_ptr failure) noexcept;
    [[noreturn]] void rethrow() const;
    bool any() const;
    void clear();

 private:
    mutable std::mutex mutex_;
    std::exception_ptr failure_;
};

class PointClaims {
 public:
    explicit PointClaims(PointTable& table) : table_(table) {}

    /// Starts a new list of points.
    /// @param frame  CacheFrame::number
    void begin(std::uint32_t frame);
    /// The point of a key; claimed, awaited or ready.
    CachePoint* find_or_create(AnchorKey key);
    /// The same for a point that is known already.
    void find(CachePoint& point);
    std::span<CachePoint* const> claimed() const { return claimed_; }
    /// Takes from the claimed points those that `defer` returns true for: they are published as they are.
    template <class Defer>
    void defer_if(const Defer& defer)
    {
        const auto kept =
            std::stable_partition(claimed_.begin(), claimed_.end(), [&](CachePoint* point) { return !defer(*point); });
        for (auto point = kept; point != claimed_.end(); ++point) publish(**point);
        claimed_.erase(kept, claimed_.end());
    }
    /// Tells other threads that the claimed points are evaluated.
    void publish();
    /// Tells other threads that the claimed points will not be evaluated in this frame.
    void abandon() noexcept;
    /// Waits until the awaited points are ready. Only after publish().
    /// @throws the frame's failure  if one of them was abandoned
    void wait(const FrameFailure& failure) const;
    /// Forgets the recent points: the table may drop some now.
    void end_frame() { recent_ = {}; }

 private:
    bool claim(CachePoint& point);
    void publish(CachePoint& point) const;

    struct Recent {
        AnchorKey key = 0;
        std::uint32_t frame = 0;
        CachePoint* point = nullptr;
    };
    static constexpr unsigned k_recent_bits = 10;
    PointTable& table_;
    std::uint32_t frame_ = 0;
    std::array<Recent, 1u << k_recent_bits> recent_;
    std::vector<CachePoint*> claimed_, awaited_;
};

}   // namespace gnomon::irradiance_cache
