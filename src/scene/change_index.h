// SPDX-License-Identifier: Apache-2.0
#pragma once
// Finds the tracks that change between two times, with an interval tree stored in one sorted array.
//
// The tree is built once per scene. A query costs O(log n + results), so it does not visit tracks at rest.

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
    /// Builds the tree. Call once, after all add().
    void build();

    /// Returns the ids of all tracks whose value may differ between times a and b, in either order; ascending, unique.
    void query(double a, double b, std::vector<std::uint32_t>& ids) const;

 private:
    struct Entry {
        double first, last;
        double latest;   // the largest `last` of the subtree that this entry is the root of
        std::uint32_t id;
    };
    double build_range(std::size_t begin, std::size_t end);
    void query_range(std::size_t begin, std::size_t end, double a, double b, std::vector<std::uint32_t>& ids) const;

    std::vector<Entry> entries_;   // sorted by `first`
};

}   // namespace gnomon::scene
