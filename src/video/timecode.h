// SPDX-License-Identifier: Apache-2.0
#pragma once
// Timecodes of frames, as editors number them: HH:MM:SS:FF.
//
// At 30000/1001 and 60000/1001 frames a second, numbers that count whole seconds fall behind the clock. With ";" before
// the frames, the first 2 (4) numbers of each minute are left out, but in every tenth minute [SMPTE 12M].

#include <optional>
#include <string>

namespace gnomon::video {

/// Frames that a timecode counts as a second: the rate, if it is whole, or the whole rate above it, if it is that times
/// 1000/1001. Nothing for other rates, which have no timecode.
std::optional<int> timecode_rate(double fps);

/// The timecode that is `frames` after another one; hours begin anew after 23.
/// @param start  HH:MM:SS:FF, or HH:MM:SS;FF
/// @throws UsageError  `start` is no timecode at this rate, or the rate has none
std::string timecode_after(const std::string& start, int frames, double fps);

}   // namespace gnomon::video
