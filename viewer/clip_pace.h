// SPDX-License-Identifier: Apache-2.0
#pragma once
// Chooses when a clip that plays goes on while the user moves the view. Objects and lights take their time to move,
// whatever the number of pixels; so the clip then goes on in fewer steps, and images in between show the view alone.

#include <chrono>

namespace gnomon::viewer {

class ClipPace {
 public:
    using Clock = std::chrono::steady_clock;
    static constexpr double k_share = 0.25;   // of all time: for moving objects and lights, at most

    bool goes_on(Clock::time_point now) const { return now >= next_; }
    /// Notes a request at another time of the clip.
    void went_on(Clock::time_point now)
    {
        next_ = now + std::chrono::duration_cast<Clock::duration>(
                          std::chrono::duration<double, std::milli>(following_ms_ / k_share));
    }
    /// Notes how long objects and lights took to follow such a request.
    void took(double ms) { following_ms_ = ms; }

 private:
    double following_ms_ = 0;
    Clock::time_point next_{};
};

}   // namespace gnomon::viewer
