// SPDX-License-Identifier: Apache-2.0
#include "trace/trace_log.h"

namespace gnomon::trace {

std::uint64_t TraceLog::rays() const
{
    std::uint64_t sum = 0;
    for (const Entry& entry : entries) sum += entry.rays.size();
    return sum;
}

std::uint64_t TraceLog::replay(const ray::RayScene& scene) const
{
    std::uint64_t result = 0;
    ray::Hits hits;
    std::vector<std::uint8_t> occluded;
    for (const Entry& entry : entries) {
        const std::size_t count = entry.rays.size();
        if (entry.any_hit) {
            occluded.resize(count + ray::k_packet_pad);
            scene.occluded(entry.rays, 0, count, occluded.data());
            result += occluded[count / 2];
        } else {
            hits.resize(count);
            scene.closest(entry.rays, 0, count, hits, ray::Sides::front);
            result += hits.triangle[count / 2];
        }
    }
    return result;
}

}   // namespace gnomon::trace
