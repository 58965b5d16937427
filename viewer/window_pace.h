// SPDX-License-Identifier: Apache-2.0
#pragma once
// When the window draws. Input is handled at once, whatever the window shows; drawing, which takes long without a
// graphics card and then takes the processor from the image that is rendered, follows when there is something to show,
// and leaves time in between.

#include <chrono>

namespace gnomon::viewer {

class WindowPace {
 public:
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    static constexpr int k_settling = 2;   // frames after an input, in which lists open and widgets take their size
    static constexpr double k_share = 3;   // from drawing to drawing, unless there is a new image: times as long
    static constexpr double k_moving_share = 1;   // the same where the view has moved
    static constexpr Seconds k_most{0.1};         // but never longer

    /// There is something to show: an input, a message, progress.
    void touch() { settling_ = k_settling, pending_ = true; }
    /// The same, and nothing follows from it.
    void touch_once() { pending_ = true; }
    /// Whether the next frame should follow without waiting for input.
    bool settles() const { return settling_ > 0; }
    void begin_frame();
    /// The view has moved, and the window shows it where it was: that waits for less time.
    void move_view(bool moves) { moves_ = moves; }
    /// Whether to draw this frame.
    /// @param new_image  the frame shows an image that was not drawn yet
    bool draws(bool new_image, Clock::time_point now) const;
    void drawn(Clock::time_point start, Clock::time_point end);
    /// Whether something waits to be drawn, and for how long yet.
    bool pending() const { return pending_ || moves_; }
    Seconds left(Clock::time_point now) const;

 private:
    int settling_ = 0;
    bool pending_ = true, moves_ = false;
    Clock::time_point drawn_{};   // the end of the last drawing
    Seconds took_{0};
};

}   // namespace gnomon::viewer
