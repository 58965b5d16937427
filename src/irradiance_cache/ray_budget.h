// SPDX-License-Identifier: Apache-2.0
#pragma once
// Limits the rays that a frame casts for new cache points, for viewers.
//
// What a point costs is known only after it was evaluated, and one tile of a small image asks for hundreds of points at
// once. So a frame pays in advance, for each point what those of the frame before have cost on average.

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace gnomon::irradiance_cache {

/// grant() and settle() are thread-safe.
class RayBudget {
 public:
    /// @param rays  per frame; 0: no limit
    void limit(std::uint64_t rays) { limit_ = rays; }
    bool limited() const { return limit_ > 0; }
    void begin_frame();
    /// How many of so many new points may be evaluated now; the others are left to a later frame. Every frame may
    /// evaluate some, so that each one improves the next.
    std::size_t grant(std::size_t wanted);
    /// Tells how many rays granted points have cost, together with what else was evaluated beside them.
    void settle(std::size_t granted, std::uint64_t rays);
    /// Pays rays of something else in advance.
    /// @return  false if the frame has no rays left for it; it is left to a later frame, then
    bool pay(std::uint64_t rays);
    /// Whether some points were left to a later frame.
    bool any_deferred() const { return deferred_; }

 private:
    static constexpr std::uint64_t k_first_cost = 256;   // before any point was evaluated
    static constexpr std::size_t k_least = 4;            // points that every frame may evaluate
    static constexpr std::size_t k_share = 4;            // one call gets at most this part of what is left

    std::uint64_t limit_ = 0, cost_ = k_first_cost;
    std::atomic<std::int64_t> spent_ = 0;   // expected of what is granted, cast for what is settled
    std::atomic<std::uint64_t> granted_ = 0, settled_ = 0, cast_ = 0;
    std::atomic<bool> deferred_ = false;
};

}   // namespace gnomon::irradiance_cache
