// SPDX-License-Identifier: Apache-2.0
#pragma once
// Encodes videos with the ffmpeg program, which is run as a process because of the library's licence and ABI.

#include <filesystem>
#include <string>
#include <vector>

#include "gnomon/types.h"
#include "video/delivery.h"

namespace gnomon::video {

/// Encodes PNG frames of one size: single-threaded, bit-exact, without metadata of time or machine. By default to H.264
/// in MP4, playable everywhere (yuv420p). Where colours have half the resolution, an odd side loses its last row or
/// column.
/// @param comment  text that the video carries, at most 255 bytes; empty: none
/// @throws InputError    Delivery::audio has no sound that ffmpeg can read
/// @throws MissingError  ffmpeg is not found, fails, or is killed; no file remains at `out`
void encode_video(const std::vector<std::filesystem::path>& frames, double fps, const std::filesystem::path& out,
                  const Progress& progress = {}, const std::string& comment = {}, const Delivery& delivery = {});

/// A rate as ffmpeg reads it exactly: a fraction of 1001 for the rates of television, such as 24000/1001; else a
/// number.
std::string rate_text(double fps);

/// Whether ffmpeg can be run and has an encoder. Checked before a long rendering.
/// @throws InterruptedError  progress returned false
bool have_ffmpeg(const Progress& progress = {}, const std::string& encoder = "libx264");

/// Checks before a long rendering that a video can be encoded.
/// @throws InputError        Delivery::audio has no sound that ffmpeg can read
/// @throws MissingError      ffmpeg is not found, or lacks the encoder
/// @throws InterruptedError  progress returned false
void check_encoder(const Delivery& delivery, const Progress& progress = {});

}   // namespace gnomon::video
