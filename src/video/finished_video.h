// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads finished videos: whether a file is complete, and the comment that says what it shows.
//
// The file may be anything; what is no video of the container is not whole and has no comment.

#include <filesystem>
#include <string>

#include "video/delivery.h"

namespace gnomon::video {

/// Whether a video is complete. An encoder that was interrupted may exit without an error.
bool is_whole_video(const std::filesystem::path& file, Container container);

/// The text of the comment that was given to the encoder; empty if there is none.
std::string comment_of_video(const std::filesystem::path& file, Container container);

}   // namespace gnomon::video
