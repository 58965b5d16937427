// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sound of a video: which codec a file has.

#include <filesystem>
#include <string>

#include "gnomon/types.h"

namespace gnomon::video {

/// The codec of a file's first track of sound, as ffmpeg names it: "aac", "pcm_s16le". Asks the program ffprobe.
/// @throws InputError        the file has no sound that ffmpeg can read
/// @throws MissingError      ffprobe is not found
/// @throws InterruptedError  progress returned false
std::string sound_codec_of(const std::filesystem::path& file, const Progress& progress = {});

}   // namespace gnomon::video
