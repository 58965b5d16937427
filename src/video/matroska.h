// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reads the elements of a Matroska or WebM file [RFC 8794, RFC 9559]: whether the file is complete, and its comment.
//
// The file may be anything; what is no Matroska is not whole and has no comment.

#include <filesystem>
#include <string>

namespace gnomon::video {

/// Whether a file has an index, and its segment, of known size, ends where the file does. An encoder writes both last.
bool is_whole_matroska(const std::filesystem::path& file);

/// The text of the tag COMMENT; empty if there is none.
std::string comment_of_matroska(const std::filesystem::path& file);

}   // namespace gnomon::video
