// SPDX-License-Identifier: Apache-2.0
#pragma once
// The rays of a traced frame, in order, so that they can be traced again without the frame around them (bench trace).

#include <cstdint>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::trace {

struct TraceLog {
    struct Entry {
        ray::RayQueue rays;
        bool any_hit = false;
    };
    std::vector<Entry> entries;   // one for each bulk trace

    std::uint64_t rays() const;
    /// Traces all rays again on the caller's thread and returns a number that depends on the results.
    std::uint64_t replay(const ray::RayScene& scene) const;
};

}   // namespace gnomon::trace
