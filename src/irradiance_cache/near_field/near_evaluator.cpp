// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_evaluator.h"

#include <algorithm>

#include "base/interruption.h"
#include "irradiance_cache/near_field/near_of_points.h"

namespace gnomon::irradiance_cache {

// Gathers the near field of those near-field points that are wanted, or what dynamic objects change of it, some at a
// time, and stores the answers.
template <class Wanted, class Store>
void NearEvaluator::gather(const CacheFrame& frame, std::span<CachePoint* const> claimed, bool change,
                           const Wanted& wanted, const Store& store, CacheCounters& counters)
{
    constexpr std::size_t k_rays = 2048;
    const std::size_t most = std::max<std::size_t>(1, k_rays / static_cast<std::size_t>(frame.options.near_rays));
    std::size_t next = 0;
    while (next < claimed.size()) {
        interruption_point();   // every point is either complete or untouched here
        points_.clear();
        receivers_.clear();
        for (; next < claimed.size() && points_.size() < most; ++next) {
            CachePoint& point = *claimed[next];
            if (!point.exists || !is_near(point.key) || !wanted(point)) continue;
            points_.push_back(&point);
            receivers_.push_back({point.origin(), point.normal, point.horizon, point.near_reach});
        }
        answers_.resize(points_.size());
        reach_.resize(points_.size() * static_cast<std::size_t>(frame.options.near_rays));
        const NearLight& light = frame.near_field.light();
        if (change)
            light.find_change(*frame.state, *frame.rays, frame.dynamic_bounds, receivers_.data(), receivers_.size(),
                              scratch_, answers_.data());
        else
            light.gather(*frame.state, *frame.rays, receivers_.data(), receivers_.size(), ray::Against::static_only,
                         scratch_, answers_.data(), frame.dynamic_bounds.empty() ? nullptr : reach_.data());
        for (std::size_t k = 0; k < points_.size(); ++k) store(*points_[k], k);
    }
    counters.rays += scratch_.cast;
    scratch_.cast = 0;
}

std::ptrdiff_t NearEvaluator::evaluate(const CacheFrame& frame, std::span<CachePoint* const> claimed,
                                       CacheCounters& counters)
{
    if (!frame.near_field.hints()) return 0;
    const std::uint32_t version = frame.lights.geometry_version();
    const auto rays = static_cast<std::size_t>(frame.options.near_rays);
    std::ptrdiff_t more = 0;
    // Gather the near field of static geometry for new points.
    gather(
        frame, claimed, false, [&](const CachePoint& point) { return point.version != version; },
        [&](CachePoint& point, std::size_t k) {
            std::copy(answers_[k].light, answers_[k].light + 3, point.static_light);
            point.free[0] = answers_[k].nearest, point.near_factor = answers_[k].form_factor;
            // Keep what tells which rays dynamic objects may matter to.
            more -= static_cast<std::ptrdiff_t>(point.near_reach.size());
            const auto first = reach_.begin() + static_cast<std::ptrdiff_t>(k * rays);
            const std::size_t kept = frame.dynamic_bounds.empty() ? 0 : rays;
            point.near_reach.assign(first, first + static_cast<std::ptrdiff_t>(kept));
            more += static_cast<std::ptrdiff_t>(point.near_reach.size());
            point.version = version;
            point.dynamic_version = 0;
            ++counters.near_points;
        },
        counters);
    // Correct it where a dynamic object may occlude it.
    gather(
        frame, claimed, true,
        [&](CachePoint& point) {
            if (point.dynamic_version == frame.dynamic_version) return false;
            point.dynamic_version = frame.dynamic_version;
            std::copy(point.static_light, point.static_light + 3, point.light);
            return dynamic_may_occlude_near(frame, point);
        },
        [&](CachePoint& point, std::size_t k) {
            for (int colour = 0; colour < 3; ++colour) point.light[colour] += answers_[k].light[colour];
        },
        counters);
    return more;
}

}   // namespace gnomon::irradiance_cache
