// SPDX-License-Identifier: Apache-2.0
#pragma once
// Names of images, numbered sets and videos.

#include <filesystem>

namespace gnomon::io {

enum class OutputKind { image, numbered, video };

/// What a name asks for: by its extension, and whether it holds {frame} or {frame:0N}.
/// @throws UsageError for an extension we do not write, or a pattern that makes no sense
OutputKind output_kind(const std::filesystem::path& out);

/// Whether the name asks for OpenEXR.
bool is_exr_name(const std::filesystem::path& out);

/// The name of one frame of a numbered set: name-{frame:04}.png and 7 give name-0007.png.
std::filesystem::path numbered_name(const std::filesystem::path& pattern, int frame);

/// Fails before the work, not after: the folder must be there and let us write.
/// @throws MissingError
void check_writable(const std::filesystem::path& out);

}   // namespace gnomon::io
