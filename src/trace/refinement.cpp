// SPDX-License-Identifier: Apache-2.0
#include "trace/refinement.h"

#include <algorithm>
#include <atomic>
#include <cstring>

#include "base/interruption.h"

namespace gnomon::trace {

void RefinedPixels::select(const Refinement& refinement, Tasks& tasks)
{
    constexpr int k_rows = 16;   // of a task
    const bool alpha = !refinement.single.alpha.data.empty();
    const auto bands = static_cast<std::size_t>((state_.height + k_rows - 1) / k_rows);
    tasks.for_each(bands, [&](std::size_t band, int) {
        interruption_point();
        const int begin = static_cast<int>(band) * k_rows, end = std::min(begin + k_rows, state_.height);
        std::vector<std::uint8_t> more(static_cast<std::size_t>(end - begin) * static_cast<std::size_t>(state_.width));
        refinement.centres.find_more(begin, end, refinement.single.color, refinement.options, more);
        std::size_t pixel = 0;
        for (int y = begin; y < end; ++y)
            for (int x = 0; x < state_.width; ++x, ++pixel) {
                std::uint8_t& state = *state_.pixel(x, y);
                if (state != k_left_out && (more[pixel] || (alpha && refinement.centres.covered_in_part(x, y))))
                    state = k_selected;
            }
    });
}

bool RefinedPixels::select_next(Tasks& tasks)
{
    // Find the rows in which something was found: few, and then none.
    const auto height = static_cast<std::size_t>(state_.height);
    std::vector<char> found(height);
    tasks.for_each(height, [&](std::size_t row, int) {
        interruption_point();
        found[row] = std::memchr(state_.pixel(0, static_cast<int>(row)), k_found,
                                 static_cast<std::size_t>(state_.width)) != nullptr;
    });
    if (std::ranges::find(found, char{1}) == found.end()) return false;

    // Select the neighbours of pixels that found something. The states that this reads do not change meanwhile.
    std::atomic<bool> any = false;
    const auto beside_found = [&](int x, int y) {
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const int nx = x + dx, ny = y + dy;
                const bool inside = nx >= 0 && ny >= 0 && nx < state_.width && ny < state_.height;
                if (inside && *state_.pixel(nx, ny) == k_found) return true;
            }
        return false;
    };
    Image8 next = state_;
    tasks.for_each(height, [&](std::size_t row, int) {
        interruption_point();
        if (!found[row] && !(row > 0 && found[row - 1]) && !(row + 1 < height && found[row + 1])) return;
        const int y = static_cast<int>(row);
        for (int x = 0; x < state_.width; ++x) {
            const std::uint8_t state = *state_.pixel(x, y);
            if (state == k_found) *next.pixel(x, y) = k_refined;
            if (state != k_single || !beside_found(x, y)) continue;
            *next.pixel(x, y) = k_selected;
            any = true;
        }
    });
    state_ = std::move(next);
    return any;
}

bool RefinedPixels::any_selected(const Tile& tile) const
{
    for (int y = 0; y < tile.height; ++y)
        if (std::memchr(state_.pixel(tile.x, tile.y + y), k_selected, static_cast<std::size_t>(tile.width)))
            return true;
    return false;
}

}   // namespace gnomon::trace
