// SPDX-License-Identifier: Apache-2.0
#pragma once
// Evaluates near-field points: the near field of static geometry once, and what dynamic objects change of it in those
// frames in which one may occlude it.

#include <span>
#include <vector>

#include "irradiance_cache/cache_frame.h"
#include "irradiance_cache/points/cache_point.h"

namespace gnomon::irradiance_cache {

/// Holds a thread's scratch memory.
class NearEvaluator {
 public:
    /// Brings the near-field points among the claimed ones up to this frame.
    /// @return  bytes that they keep beyond before
    std::ptrdiff_t evaluate(const CacheFrame& frame, std::span<CachePoint* const> claimed, CacheCounters& counters);

 private:
    template <class Wanted, class Store>
    void gather(const CacheFrame& frame, std::span<CachePoint* const> claimed, bool change, const Wanted& wanted,
                const Store& store, CacheCounters& counters);

    std::vector<CachePoint*> points_;
    std::vector<NearReceiver> receivers_;
    std::vector<NearAnswer> answers_;
    std::vector<std::uint8_t> reach_;   // by point and direction
    NearLight::Scratch scratch_;
};

}   // namespace gnomon::irradiance_cache
