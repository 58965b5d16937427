// SPDX-License-Identifier: Apache-2.0
#include "cli/progress_line.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace gnomon::cli {

namespace {
constexpr double k_silence = 1.0;             // seconds of work before anything is shown
constexpr double k_terminal_every = 0.1;      // least seconds between two updates of the line on a terminal
constexpr double k_plain_every = 5.0;         // least seconds between two plain lines
constexpr double k_plain_step = 0.1;          // least progress between two plain lines, as a fraction of the stage
constexpr std::size_t k_bar = 24;             // columns
constexpr std::size_t k_usual_columns = 80;   // of a terminal that does not report its size

double seconds(std::chrono::steady_clock::duration span)
{
    return std::chrono::duration<double>(span).count();
}

// The current width of the terminal, which may change at any time.
std::size_t columns()
{
    winsize size{};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : k_usual_columns;
}
}   // namespace

std::string duration_text(double span)
{
    const auto whole = static_cast<long long>(std::llround(std::max(0.0, span)));
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{}:{:02} min", whole / 60, whole % 60);
    return fmt::format("{}:{:02} h", whole / 3600, whole / 60 % 60);
}

std::string progress_text(std::string_view stage, double done, const std::string& left, std::size_t columns)
{
    const std::string head = fmt::format("{:<9} ", stage), tail = fmt::format(" {:3.0f} %  {}", 100 * done, left);
    // Shorten the bar, then cut the end, because text that wraps to the next line could not be erased.
    const std::size_t around = head.size() + tail.size() + 2;
    const std::size_t bar = columns > around ? std::min(k_bar, columns - around) : 0;
    std::string text = head;
    if (bar > 0) {
        const auto filled = static_cast<std::size_t>(done * static_cast<double>(bar));
        text += fmt::format("[{:<{}}]", std::string(filled, '='), bar);
    }
    return (text + tail).substr(0, columns);
}

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine()
{
    clear();
}

void ProgressLine::show(const ProgressStep& step)
{
    if (quiet_) return;
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (step.stage != stage_) {
        stage_ = step.stage;
        stage_start_ = last_shown_ = now;
        first_done_ = last_done_ = step.done;
    }
    const double elapsed = seconds(now - stage_start_), since = seconds(now - last_shown_);
    if (elapsed < k_silence) return;
    if (terminal_ ? since < k_terminal_every : since < k_plain_every || step.done < last_done_ + k_plain_step) return;

    const double done = std::clamp(step.done, 0.0, 1.0);
    const double gained = done - first_done_;
    const std::string left = gained > 0 ? duration_text(elapsed * (1 - done) / gained) + " left" : "";
    if (terminal_) {
        std::fputs(("\r\033[K" + progress_text(stage_, done, left, columns() - 1)).c_str(), stderr);
        visible_ = true;
    } else {
        std::fputs(fmt::format("{} {:.0f} %  {}\n", stage_, 100 * done, left).c_str(), stderr);
    }
    std::fflush(stderr);
    last_shown_ = now;
    last_done_ = step.done;
}

void ProgressLine::clear()
{
    const std::lock_guard lock(mutex_);
    if (visible_) std::fputs("\r\033[K", stderr);
    visible_ = false;
}

}   // namespace gnomon::cli
