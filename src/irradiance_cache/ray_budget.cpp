// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/ray_budget.h"

#include <algorithm>

namespace gnomon::irradiance_cache {

void RayBudget::begin_frame()
{
    // Follow what points cost. A frame of few points tells little.
    constexpr std::uint64_t k_telling = 16;
    if (settled_ >= k_telling) cost_ = std::max<std::uint64_t>(cast_ / settled_, 1);
    spent_ = 0, granted_ = 0, settled_ = 0, cast_ = 0;
    deferred_ = false;
}

std::size_t RayBudget::grant(std::size_t wanted)
{
    if (!limited() || wanted == 0) return wanted;
    const std::int64_t left = static_cast<std::int64_t>(limit_) - spent_;
    std::size_t granted = 0;
    if (left > 0) granted = std::max<std::size_t>(static_cast<std::uint64_t>(left) / cost_ / k_share, 1);
    if (granted == 0 && granted_ < k_least) granted = 1;
    granted = std::min(granted, wanted);
    spent_ += static_cast<std::int64_t>(granted * cost_);
    granted_ += granted;
    if (granted < wanted) deferred_ = true;
    return granted;
}

void RayBudget::settle(std::size_t granted, std::uint64_t rays)
{
    spent_ += static_cast<std::int64_t>(rays) - static_cast<std::int64_t>(granted * cost_);
    settled_ += granted, cast_ += rays;
}

bool RayBudget::pay(std::uint64_t rays)
{
    if (!limited()) return true;
    if (spent_ >= static_cast<std::int64_t>(limit_)) {
        deferred_ = true;
        return false;
    }
    spent_ += static_cast<std::int64_t>(rays);
    return true;
}

}   // namespace gnomon::irradiance_cache
