// SPDX-License-Identifier: Apache-2.0
#include "viewer/window_pace.h"

#include <algorithm>

namespace gnomon::viewer {

void WindowPace::begin_frame()
{
    if (settling_ > 0) --settling_;
}

bool WindowPace::draws(bool new_image, Clock::time_point now) const
{
    return new_image || (pending_ && now >= next_);
}

void WindowPace::drawn(Clock::time_point start, Clock::time_point end)
{
    pending_ = settling_ > 0;
    next_ = end + std::chrono::duration_cast<Clock::duration>(std::min(k_share * Seconds(end - start), k_most));
}

WindowPace::Seconds WindowPace::left(Clock::time_point now) const
{
    return std::max(Seconds(next_ - now), Seconds(0));
}

}   // namespace gnomon::viewer
