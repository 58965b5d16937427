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
    return new_image || (pending() && left(now) <= Seconds(0));
}

void WindowPace::drawn(Clock::time_point start, Clock::time_point end)
{
    pending_ = settling_ > 0;
    drawn_ = end, took_ = end - start;
}

WindowPace::Seconds WindowPace::left(Clock::time_point now) const
{
    const Seconds pause = std::min((moves_ ? k_moving_share : k_share) * took_, k_most);
    return std::max(pause - Seconds(now - drawn_), Seconds(0));
}

}   // namespace gnomon::viewer
