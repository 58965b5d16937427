// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which tracks change between two times: an interval tree laid out in one sorted array.
//
// Built once a scene. A query costs O(log n + answers), so tracks that are at rest are not looked at.

#include <cstdint>
#include <vector>

#include "scene/track.h"

namespace gnomon::scene {

class ChangeIndex {
 public:
    void add(std::uint32_t id, const Interval& interval)
    {
        entries_.push_back({interval.first, interval.last, interval.last, id});
    }
    /// Call once, after all add().
    void build();

    /// Ids of all tracks that may have another value at time b than at time a, in either direction; ascending, unique.
    void query(double a, double b, std::vector<std::uint32_t>& ids) const;

 private:
    struct Entry {
        double first, last;
        double latest;   // the largest `last` of the subtree that this entry is the root of
        std::uint32_t id;
    };
    double build_range(std::size_t begin, std::size_t end);
    void query_range(std::size_t begin, std::size_t end, double a, double b, std::vector<std::uint32_t>& ids) const;

    std::vector<Entry> entries_;   // by first
};

}   // namespace gnomon::scene
