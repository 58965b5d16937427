// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/point_claims.h"

#include "base/check.h"

namespace gnomon::irradiance_cache {

void FrameFailure::record(std::exception_ptr failure) noexcept
{
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
}

void FrameFailure::rethrow() const
{
    std::exception_ptr failure;
    {
        const std::lock_guard lock(mutex_);
        failure = failure_;
    }
    GNOMON_CHECK(failure);
    std::rethrow_exception(failure);
}

bool FrameFailure::any() const
{
    const std::lock_guard lock(mutex_);
    return failure_ != nullptr;
}

void FrameFailure::clear()
{
    const std::lock_guard lock(mutex_);
    failure_ = nullptr;
}

void PointClaims::begin(std::uint32_t frame)
{
    frame_ = frame;
    claimed_.clear();
    awaited_.clear();
}

CachePoint* PointClaims::find_or_create(AnchorKey key)
{
    // Neighbouring pixels need the same few points.
    Recent& recent = recent_[(key * 0x9e3779b97f4a7c15ull) >> (64 - k_recent_bits)];
    if (recent.key == key && recent.frame == frame_) return recent.point;
    CachePoint& point = table_.find_or_create(key);
    find(point);
    recent = {key, frame_, &point};
    return &point;
}

void PointClaims::find(CachePoint& point)
{
    if (!claim(point) && point.ready.load(std::memory_order_acquire) != frame_) awaited_.push_back(&point);
}

// Whether the point became this thread's.
bool PointClaims::claim(CachePoint& point)
{
    std::uint32_t claimed = point.claimed.load(std::memory_order_relaxed);
    if (claimed == frame_) return false;
    // List the point before it is claimed: once claimed it must be published, whatever fails.
    claimed_.push_back(&point);
    if (point.claimed.compare_exchange_strong(claimed, frame_)) return true;
    claimed_.pop_back();
    return false;
}

void PointClaims::publish(CachePoint& point) const
{
    // In one total order with the waiter's registration, or a waiter could be missed.
    point.ready.store(frame_, std::memory_order_seq_cst);
    point.ready.notify_all();
}

void PointClaims::publish()
{
    for (CachePoint* point : claimed_) publish(*point);
    claimed_.clear();
}

void PointClaims::abandon() noexcept
{
    for (CachePoint* point : claimed_) {
        point->ready.store(abandoned_in(frame_), std::memory_order_seq_cst);
        point->ready.notify_all();
    }
    claimed_.clear();
}

void PointClaims::wait(const FrameFailure& failure) const
{
    for (const CachePoint* point : awaited_) {
        std::uint32_t ready = point->ready.load(std::memory_order_acquire);
        while (ready != frame_) {
            if (ready == abandoned_in(frame_)) failure.rethrow();
            point->ready.wait(ready, std::memory_order_acquire);
            ready = point->ready.load(std::memory_order_acquire);
        }
    }
}

}   // namespace gnomon::irradiance_cache
