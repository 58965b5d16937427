// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures a thread's time by stage: the time since the previous stage ended is added to the stage that ends now.

#include <chrono>

#include "gnomon/frame_times.h"

namespace gnomon {

class Stopwatch {
 public:
    explicit Stopwatch(FrameTimes& times) : times_(times) {}
    void restart() { last_ = Clock::now(); }
    void end(FrameTimes::Stage stage)
    {
        const Clock::time_point now = Clock::now();
        times_.ms[stage] += std::chrono::duration<double, std::milli>(now - last_).count();
        last_ = now;
    }

 private:
    using Clock = std::chrono::steady_clock;
    FrameTimes& times_;
    Clock::time_point last_ = Clock::now();
};

}   // namespace gnomon
