// SPDX-License-Identifier: Apache-2.0
#include "viewer/latency.h"

#include <algorithm>
#include <limits>

namespace gnomon::viewer {

void Latency::note(Clock::time_point when)
{
    if (!noted_) noted_ = when;
}

void Latency::ask(std::uint64_t request)
{
    if (noted_) asked_.emplace_back(request, *noted_);
    noted_.reset();
}

void Latency::show_all(Clock::time_point when)
{
    show(std::numeric_limits<std::uint64_t>::max(), when);
    if (noted_) ms_.push_back(std::chrono::duration<double, std::milli>(when - *noted_).count());
    noted_.reset();
}

void Latency::show(std::uint64_t request, Clock::time_point when)
{
    std::erase_if(asked_, [&](const auto& asked) {
        if (asked.first > request) return false;
        ms_.push_back(std::chrono::duration<double, std::milli>(when - asked.second).count());
        return true;
    });
}

void Latency::forget()
{
    noted_.reset();
    asked_.clear();
}

Latency::Summary Latency::summary() const
{
    if (ms_.empty()) return {};
    std::vector<double> sorted = ms_;
    std::sort(sorted.begin(), sorted.end());
    return {sorted.size(), sorted[sorted.size() / 2], sorted.back()};
}

}   // namespace gnomon::viewer
