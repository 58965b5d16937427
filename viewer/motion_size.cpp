// SPDX-License-Identifier: Apache-2.0
#include "viewer/motion_size.h"

#include <algorithm>
#include <utility>

namespace gnomon::viewer {

void MotionSize::add(int divisor, const Cost& cost, double target_ms)
{
    if (divisor != this->divisor()) return;
    const double fixed = std::clamp(cost.fixed_ms, 0.0, cost.ms), allowed = std::max(target_ms, (1 + k_more) * fixed);

    // Follow the cost of a ray, where they were what the image could have more of.
    if (cost.rays >= rays_ && cost.light_ms > 0) {
        const double change = std::clamp(k_light * allowed / cost.light_ms, 0.5, 1.25);
        rays_ = std::clamp(static_cast<std::uint64_t>(change * static_cast<double>(rays_)), k_fewest_rays, k_most_rays);
    }

    // Coarser as far as it takes: at once, if it is by much.
    const double light = std::clamp(cost.light_ms, 0.0, cost.ms - fixed);
    const auto expected = [&](std::size_t level) {
        const double finer = static_cast<double>(divisor) / k_divisors[level];
        return fixed + light * finer + (cost.ms - fixed - light) * finer * finer;
    };
    late_ = cost.ms > allowed ? late_ + 1 : 0;
    if (late_ > 0) {
        calm_ = 0;
        if (late_ < k_late && cost.ms < k_much * allowed) return;
        late_ = 0;
        while (level_ + 1 < k_divisors.size() && expected(level_) > allowed) ++level_;
        return;
    }
    // After the first image, as fine as it takes; later step by step, and only where one image was no exception.
    if (std::exchange(first_, false)) {
        while (level_ > 0 && expected(level_ - 1) <= fixed + k_spare * (allowed - fixed)) --level_;
        return;
    }
    if (level_ == 0 || expected(level_ - 1) > fixed + k_spare * (allowed - fixed)) {
        calm_ = 0;
        return;
    }
    if (++calm_ < k_calm) return;
    calm_ = 0;
    --level_;
}

void MotionSize::restart()
{
    level_ = k_divisors.size() - 1;
    calm_ = late_ = 0;
    first_ = true;
    rays_ = std::min(rays_, k_first_rays);
}

}   // namespace gnomon::viewer
