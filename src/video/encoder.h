// SPDX-License-Identifier: Apache-2.0
#pragma once
// Videos by the ffmpeg program (the library's licence and ABI stay its own).

#include <filesystem>
#include <vector>

#include "gnomon/types.h"

namespace gnomon::video {

/// Encodes PNG frames of one size to H.264 in MP4: single-threaded, bit-exact, no metadata of time or machine; plays
/// everywhere (yuv420p; an odd side loses its last row or column).
/// @throws MissingError if ffmpeg is not found, fails, or is killed; nothing is left at `out`
void encode_video(const std::vector<std::filesystem::path>& frames, double fps, const std::filesystem::path& out,
                  const Progress& progress = {});

/// Whether ffmpeg can be run. Checked before a long rendering, not after.
/// @throws InterruptedError  progress returned false
bool have_ffmpeg(const Progress& progress = {});

}   // namespace gnomon::video
