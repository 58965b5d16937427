// SPDX-License-Identifier: Apache-2.0
#include "scene/change_index.h"

#include <algorithm>

namespace gnomon::scene {

void ChangeIndex::build()
{
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& x, const Entry& y) { return x.first < y.first; });
    build_range(0, entries_.size());
}

double ChangeIndex::build_range(std::size_t begin, std::size_t end)
{
    if (begin == end) return -std::numeric_limits<double>::infinity();
    const std::size_t middle = begin + (end - begin) / 2;
    Entry& root = entries_[middle];
    root.latest = std::max({root.last, build_range(begin, middle), build_range(middle + 1, end)});
    return root.latest;
}

void ChangeIndex::query(double a, double b, std::vector<std::uint32_t>& ids) const
{
    ids.clear();
    if (a == b) return;
    if (a > b) std::swap(a, b);
    query_range(0, entries_.size(), a, b, ids);
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

// A step at time s takes effect from s on, so it lies between a and b if a < s <= b. An interval of change counts if
// any part of it lies between them.
void ChangeIndex::query_range(std::size_t begin, std::size_t end, double a, double b,
                              std::vector<std::uint32_t>& ids) const
{
    if (begin == end) return;
    const std::size_t middle = begin + (end - begin) / 2;
    const Entry& root = entries_[middle];
    if (root.latest <= a) return;
    query_range(begin, middle, a, b, ids);
    if (root.first > b) return;
    if (root.last > a) ids.push_back(root.id);
    query_range(middle + 1, end, a, b, ids);
}

}   // namespace gnomon::scene
