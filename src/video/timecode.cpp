// SPDX-License-Identifier: Apache-2.0
#include "video/timecode.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>

#include "gnomon/error.h"

namespace gnomon::video {

namespace {
constexpr double k_rounding = 1e-6;   // of a rate that is given as a number
constexpr int k_highest_rate = 99;    // frames have two digits

struct Timecode {
    std::array<int, 4> parts{};   // hours, minutes, seconds, frames
    bool drops = false;
};

// Returns nothing if the text is no timecode.
std::optional<Timecode> parse(const std::string& text)
{
    constexpr std::size_t k_length = 11;   // HH:MM:SS:FF
    if (text.size() != k_length) return std::nullopt;
    Timecode code;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (i % 3 != 2) {
            if (c < '0' || c > '9') return std::nullopt;
            int& part = code.parts[i / 3];
            part = 10 * part + (c - '0');
        } else if (i == 8 && c == ';') {
            code.drops = true;
        } else if (c != ':') {
            return std::nullopt;
        }
    }
    return code;
}
}   // namespace

std::optional<int> timecode_rate(double fps)
{
    const double whole = std::round(fps), television = std::round(fps * 1.001);
    const bool is_whole = std::abs(fps - whole) < k_rounding * fps;
    const bool is_television = std::abs(fps * 1.001 - television) < k_rounding * fps;
    const double rate = is_whole ? whole : television;
    if (!(is_whole || is_television) || rate < 1 || rate > k_highest_rate) return std::nullopt;
    return static_cast<int>(rate);
}

std::string timecode_after(const std::string& start, int frames, double fps)
{
    const std::optional<int> rate = timecode_rate(fps);
    if (!rate)
        throw UsageError(
            fmt::format("a video of {:.6g} frames a second has no timecode; --fps sets another rate", fps));
    const std::optional<Timecode> code = parse(start);
    if (!code) throw UsageError(fmt::format("timecode '{}': expected HH:MM:SS:FF, such as 01:00:00:00", start));
    const auto& [hours, minutes, seconds, number] = code->parts;
    const bool exact = std::abs(fps - *rate) < k_rounding * fps;
    if (code->drops && (exact || *rate % 30 != 0))
        throw UsageError(
            fmt::format("timecode '{}': numbers are dropped at 30000/1001 and 60000/1001 frames a second "
                        "alone; write ':' before the frames",
                        start));
    const std::int64_t dropped = code->drops ? *rate / 15 : 0;   // numbers a minute
    if (hours > 23 || minutes > 59 || seconds > 59 || number >= *rate ||
        (dropped > 0 && minutes % 10 != 0 && seconds == 0 && number < dropped))
        throw UsageError(fmt::format("timecode '{}': there is no such time at {} frames a second", start, *rate));

    // Count the frames up to the start, and those after it.
    const std::int64_t all_minutes = 60 * hours + minutes;
    const std::int64_t minute = 60 * *rate - dropped, ten_minutes = 10 * minute + dropped, day = 144 * ten_minutes;
    std::int64_t count = (60 * all_minutes + seconds) * *rate + number - dropped * (all_minutes - all_minutes / 10);
    count = (count + frames) % day;
    // Add the numbers that are left out, and write what results as a time.
    const std::int64_t tens = count / ten_minutes, rest = count % ten_minutes;
    count += dropped * 9 * tens;
    if (dropped > 0 && rest >= minute + dropped) count += dropped * ((rest - dropped) / minute);
    const std::int64_t all_seconds = count / *rate;
    return fmt::format("{:02}:{:02}:{:02}{}{:02}", all_seconds / 3600, all_seconds / 60 % 60, all_seconds % 60,
                       code->drops ? ';' : ':', count % *rate);
}

}   // namespace gnomon::video
