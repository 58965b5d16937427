// SPDX-License-Identifier: Apache-2.0
#include "video/frame_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace gnomon::video {

namespace {
// The position after the range of consecutive frames that begins at `begin`.
std::size_t end_of_range(const std::vector<int>& frames, std::size_t begin)
{
    std::size_t end = begin + 1;
    while (end < frames.size() && frames[end] == frames[end - 1] + 1) ++end;
    return end;
}

std::string range_text(int first, int last)
{
    return first == last ? fmt::format("{}", first) : fmt::format("{}-{}", first, last);
}
}   // namespace

std::string list_frames(const std::vector<int>& frames)
{
    constexpr std::size_t k_most_ranges = 8;
    std::vector<std::string> ranges;
    std::size_t begin = 0;
    while (begin < frames.size() && ranges.size() < k_most_ranges) {
        const std::size_t end = end_of_range(frames, begin);
        ranges.push_back(range_text(frames[begin], frames[end - 1]));
        begin = end;
    }
    if (begin < frames.size()) ranges.push_back(fmt::format("{} more", frames.size() - begin));
    std::string text = ranges.empty() ? std::string() : ranges.front();
    for (std::size_t i = 1; i < ranges.size(); ++i) text += (i + 1 == ranges.size() ? " and " : ", ") + ranges[i];
    return (frames.size() == 1 ? "frame " : "frames ") + text;
}

std::string first_range(std::vector<int> frames)
{
    std::sort(frames.begin(), frames.end());
    return fmt::format("{}-{}", frames.front(), frames[end_of_range(frames, 0) - 1]);
}

}   // namespace gnomon::video
