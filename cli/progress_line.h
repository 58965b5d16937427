// SPDX-License-Identifier: Apache-2.0
#pragma once
// How far long work has come, and how long it will take: one line that renews itself on a terminal, a few plain lines
// elsewhere. Work of less than a second shows nothing.

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include "gnomon/types.h"

namespace gnomon::cli {

/// A stage with its bar, in at most so many columns.
std::string progress_text(std::string_view stage, double done, const std::string& left, std::size_t columns);

class ProgressLine {
 public:
    /// On standard error.
    explicit ProgressLine(bool quiet);
    ~ProgressLine();

    void show(const ProgressStep& step);
    /// Takes the line off the terminal, so that something else can be said.
    void clear();

 private:
    using Clock = std::chrono::steady_clock;

    bool quiet_, terminal_;
    bool visible_ = false;
    std::string stage_;
    Clock::time_point stage_start_{}, last_shown_{};
    double first_done_ = 0, last_done_ = 0;   // of the stage
    std::mutex mutex_;
};

/// "43 s", "1:23 min" or "2:05 h".
std::string duration_text(double seconds);

}   // namespace gnomon::cli
