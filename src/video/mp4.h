// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads the boxes of an MP4 or QuickTime file [ISO/IEC 14496-12]: whether the file is complete, and its comment.
//
// The file may be anything; what is no MP4 is not whole and has no comment.

#include <filesystem>
#include <string>

namespace gnomon::video {

/// Whether an MP4 has its index and its media data, and ends where its last box does. An encoder that was interrupted
/// may exit without an error.
bool is_whole_mp4(const std::filesystem::path& file);

/// The text of the comment that ffmpeg writes for -metadata comment=TEXT; empty if there is none.
std::string comment_of_mp4(const std::filesystem::path& file);

}   // namespace gnomon::video
