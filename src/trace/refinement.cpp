// SPDX-License-Identifier: Apache-2.0
#include "trace/refinement.h"

#include <atomic>

#include "base/interruption.h"

namespace gnomon::trace {

void RefinedPixels::select(const Refinement& refinement, Tasks& tasks)
{
    const bool alpha = !refinement.single.alpha.data.empty();
    tasks.for_each(static_cast<std::size_t>(state_.height), [&](std::size_t row, int) {
        interruption_point();
        const int y = static_cast<int>(row);
        for (int x = 0; x < state_.width; ++x)
            if (*state_.pixel(x, y) != k_left_out &&
                (refinement.centres.needs_more(x, y, refinement.single.color, refinement.options) ||
                 (alpha && refinement.centres.covered_in_part(x, y))))
                *state_.pixel(x, y) = k_selected;
    });
}

bool RefinedPixels::select_next(Tasks& tasks)
{
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
    tasks.for_each(static_cast<std::size_t>(state_.height), [&](std::size_t row, int) {
        interruption_point();
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

}   // namespace gnomon::trace
