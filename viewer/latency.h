// SPDX-License-Identifier: Apache-2.0
#pragma once
// How long inputs wait until an image shows them: from the moment at which the window received one to the moment at
// which the image is on the screen.

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace gnomon::viewer {

class Latency {
 public:
    using Clock = std::chrono::steady_clock;

    /// An input came that changes the image. Until a request has it, further ones are counted as one with it.
    void note(Clock::time_point when);
    /// The request has what was noted.
    void ask(std::uint64_t request);
    /// The screen shows all that was noted or requested.
    void show_all(Clock::time_point when);
    /// An image is on the screen: it shows its own request and those before it.
    void show(std::uint64_t request, Clock::time_point when);
    /// Nothing will show what was noted, because another scene takes its place.
    void forget();

    struct Summary {
        std::uint64_t inputs = 0;
        double median_ms = 0, longest_ms = 0;
    };
    Summary summary() const;

 private:
    std::optional<Clock::time_point> noted_;
    std::vector<std::pair<std::uint64_t, Clock::time_point>> asked_;
    std::vector<double> ms_;
};

}   // namespace gnomon::viewer
