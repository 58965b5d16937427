// SPDX-License-Identifier: Apache-2.0
#pragma once
// Names of output files: images, numbered sets and videos.

#include <filesystem>

namespace gnomon::io {

enum class OutputKind { image, numbered, video };

/// The kind of output that a name selects: by its extension, and whether it contains {frame} or
/// {frame:0N}, or %d or %0Nd.
/// @throws UsageError  unsupported extension, or invalid pattern
OutputKind output_kind(const std::filesystem::path& out);

/// Whether the name selects OpenEXR.
bool is_exr_name(const std::filesystem::path& out);
/// Whether the name selects JPEG: .jpg or .jpeg.
bool is_jpeg_name(const std::filesystem::path& out);

/// The name of one frame of a numbered set: name-{frame:04}.png, or name-%04d.png, and 7 give
/// name-0007.png.
std::filesystem::path numbered_name(const std::filesystem::path& pattern, int frame);

/// Makes the folder that a file lies in, and those above it, if they are not there.
/// @throws MissingError
void make_folder(const std::filesystem::path& out);

/// Checks before rendering that the folder exists and is writable.
/// @throws MissingError
void check_writable(const std::filesystem::path& out);

}   // namespace gnomon::io
