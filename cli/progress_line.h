// SPDX-License-Identifier: Apache-2.0
#pragma once
// Shows the progress of long work and the estimated time left: on a terminal one line that is redrawn, elsewhere a few
// plain lines. Work of less than a second shows nothing.

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include "gnomon/types.h"

namespace gnomon::cli {

/// One progress line: the stage, a bar, the percentage and `left`, in at most `columns` columns.
std::string progress_text(std::string_view stage, double done, const std::string& left, std::size_t columns);

class ProgressLine {
 public:
    /// Writes to standard error, or nothing if `quiet`.
    explicit ProgressLine(bool quiet);
    ~ProgressLine();

    void show(const ProgressStep& step);
    /// Erases the line from the terminal, so that other text can be printed.
    void clear();

 private:
    using Clock = std::chrono::steady_clock;

    bool quiet_, terminal_;
    bool visible_ = false;
    std::string stage_;
    Clock::time_point stage_start_{}, last_shown_{};
    double first_done_ = 0, last_done_ = 0;   // progress of the stage when it began, and when it was last shown
    std::mutex mutex_;
};

/// "43 s", "1:23 min" or "2:05 h".
std::string duration_text(double seconds);

}   // namespace gnomon::cli
