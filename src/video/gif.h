// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads the ends of a GIF file [GIF89a]: whether it is complete, and its comment.
//
// The file may be anything; what is no GIF is not whole and has no comment.

#include <filesystem>
#include <string>

namespace gnomon::video {

/// Whether a file begins as a GIF does and ends with its trailer.
bool is_whole_gif(const std::filesystem::path& file);

/// The text of a comment right before the trailer; empty if there is none.
std::string comment_of_gif(const std::filesystem::path& file);

/// Puts a comment before the trailer of a whole GIF.
/// @param comment  at most 255 bytes; empty: nothing is done
/// @throws MissingError  the file cannot be written
void add_gif_comment(const std::filesystem::path& file, const std::string& comment);

}   // namespace gnomon::video
