// SPDX-License-Identifier: Apache-2.0
#pragma once
// Lists of frame numbers in words.

#include <string>
#include <vector>

namespace gnomon::video {

/// "frame 3", or "frames 3-7, 9 and 11-12". Of many ranges the first ones are listed, and the number of further frames.
/// @param frames  ascending, at least one
std::string list_frames(const std::vector<int>& frames);

/// The first range of consecutive frames, as --chunk takes it: "3-3" or "3-7".
/// @param frames  in any order, at least one
std::string first_range(std::vector<int> frames);

}   // namespace gnomon::video
