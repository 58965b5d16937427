// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bounds the rays that continue from one camera ray where surfaces both reflect and refract.
//
// A surface that mirrors as much as it lets through doubles the rays at each depth, all of them bright. A path may take
// the dimmer of two rays k_most_splits times; after that it goes on along the brighter one, with the weight of both. In
// glass, which mirrors little, dim paths end before that. The rule depends on the path alone, so it is the same for any
// order of rays and any number of threads.

#include <algorithm>
#include <cstdint>

#include "base/math.h"

namespace gnomon::trace {

constexpr std::uint8_t k_most_splits = 2;

/// How often the paths of the two rays took the dimmer of two.
struct PathSplits {
    std::uint8_t reflected = 0, refracted = 0;
};

/// Splits a path; if it may not be split again, one of the weights becomes their sum, and the other 0.
/// @param throughput  of the path
/// @param least       of a ray's throughput, below which it is not traced
/// @param splits      how often the path took the dimmer ray
inline PathSplits split_path(const glm::vec3& throughput, float least, std::uint8_t splits, glm::vec3& reflected,
                             glm::vec3& refracted)
{
    const auto largest = [&](const glm::vec3& weight) {
        const glm::vec3 v = throughput * weight;
        return std::max({v.x, v.y, v.z});
    };
    const float by_reflection = largest(reflected), by_refraction = largest(refracted);
    if (!(by_reflection >= least) || !(by_refraction >= least)) return {splits, splits};
    const bool mirrors = by_reflection >= by_refraction;   // mostly
    if (splits < k_most_splits) {
        const auto more = static_cast<std::uint8_t>(splits + 1);
        return {mirrors ? splits : more, mirrors ? more : splits};
    }
    glm::vec3 &stays = mirrors ? reflected : refracted, &goes = mirrors ? refracted : reflected;
    stays += goes, goes = glm::vec3(0);
    return {splits, splits};
}

}   // namespace gnomon::trace
