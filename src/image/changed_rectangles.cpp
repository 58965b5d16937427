// SPDX-License-Identifier: Apache-2.0
#include "image/changed_rectangles.h"

#include <algorithm>
#include <cstring>

namespace gnomon::image {

namespace {

constexpr int k_side = 16;   // pixels a side of a tile

// Pixels from `low` to before `high`; empty at first.
struct Bounds {
    int low_x = 0, low_y = 0, high_x = 0, high_y = 0;

    bool empty() const { return high_x <= low_x; }
    void add(const Bounds& other)
    {
        if (other.empty()) return;
        if (empty()) *this = other;
        low_x = std::min(low_x, other.low_x), low_y = std::min(low_y, other.low_y);
        high_x = std::max(high_x, other.high_x), high_y = std::max(high_y, other.high_y);
    }
};

// Returns the bounds of the differing pixels of a tile.
Bounds differing_in(const ImageF& before, const ImageF& now, int left, int top)
{
    const int right = std::min(left + k_side, now.width), bottom = std::min(top + k_side, now.height);
    const std::size_t pixel = static_cast<std::size_t>(now.channels) * sizeof(float);
    const auto same = [&](int x, int y, int count) {
        return std::memcmp(before.pixel(x, y), now.pixel(x, y), pixel * static_cast<std::size_t>(count)) == 0;
    };
    Bounds bounds;
    for (int y = top; y < bottom; ++y) {
        if (same(left, y, right - left)) continue;
        int first = left, last = right - 1;
        while (same(first, y, 1)) ++first;
        while (same(last, y, 1)) --last;
        bounds.add({first, y, last + 1, y + 1});
    }
    return bounds;
}

// Differing tiles side by side, from column `first` to before `end`.
struct Run {
    int first = 0, end = 0;
    Bounds bounds;
};

}   // namespace

std::vector<PixelRectangle> changed_rectangles(const ImageF& before, const ImageF& now, Tasks& tasks)
{
    if (now.empty()) return {};
    if (before.width != now.width || before.height != now.height || before.channels != now.channels)
        return {{0, 0, now.width, now.height}};

    // Compare the tiles.
    const int columns = (now.width + k_side - 1) / k_side, rows = (now.height + k_side - 1) / k_side;
    std::vector<Bounds> tiles(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    tasks.for_each(static_cast<std::size_t>(rows), [&](std::size_t row, int) {
        for (int c = 0; c < columns; ++c)
            tiles[row * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)] =
                differing_in(before, now, c * k_side, static_cast<int>(row) * k_side);
    });

    // Form the runs of each row, and append a run to the rectangle of an equal run in the row above.
    std::vector<Run> finished, above;
    for (int r = 0; r < rows; ++r) {
        const Bounds* const row = tiles.data() + static_cast<std::size_t>(r) * static_cast<std::size_t>(columns);
        std::vector<Run> here;
        for (int c = 0; c < columns; ++c) {
            if (row[c].empty()) continue;
            if (here.empty() || here.back().end != c) here.push_back({c, c, {}});
            here.back().end = c + 1;
            here.back().bounds.add(row[c]);
        }
        for (const Run& run : above) {
            const auto equal = std::find_if(here.begin(), here.end(), [&](const Run& other) {
                return other.first == run.first && other.end == run.end;
            });
            if (equal == here.end())
                finished.push_back(run);
            else
                equal->bounds.add(run.bounds);
        }
        above = std::move(here);
    }
    finished.insert(finished.end(), above.begin(), above.end());

    std::vector<PixelRectangle> rectangles;
    for (const Run& run : finished) {
        const Bounds& b = run.bounds;
        rectangles.push_back({b.low_x, b.low_y, b.high_x - b.low_x, b.high_y - b.low_y});
    }
    std::sort(rectangles.begin(), rectangles.end(),
              [](const PixelRectangle& a, const PixelRectangle& b) { return a.y != b.y ? a.y < b.y : a.x < b.x; });
    return rectangles;
}

}   // namespace gnomon::image
