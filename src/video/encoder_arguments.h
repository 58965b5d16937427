// SPDX-License-Identifier: Apache-2.0
#pragma once
// The arguments of ffmpeg that encode a video.
//
// Everything runs on one thread and without notes of time or machine, so that the bytes depend on the frames and on
// ffmpeg alone. Colours are those of screens: frames are sRGB and full range; codecs of light and colour get Rec. 709
// in studio range, and FFV1 keeps RGB. Each file is tagged with what it has.

#include <filesystem>
#include <string>
#include <vector>

#include "video/delivery.h"

namespace gnomon::video {

/// What is to be encoded.
struct EncodeJob {
    std::string rate;                  // as rate_text() has it
    double seconds = 0;                // length of the video
    std::filesystem::path out{};       // the file that ffmpeg writes
    std::string comment{};             // empty: none
    std::string sound_codec{};         // of Delivery::audio, as ffmpeg names it
    std::filesystem::path palette{};   // of a .gif
};

/// The encoder that ffmpeg needs for a codec: "libx264".
std::string encoder_of(VideoCodec codec);
/// The encoder of sound, if it cannot be copied; empty if it can.
std::string sound_encoder(Container container, const std::string& sound_codec);

/// ffmpeg with its arguments; PNG frames are read from standard input.
std::vector<std::string> encode_arguments(const EncodeJob& job, const Delivery& delivery);
/// The pass that chooses the colours of a .gif: writes job.palette.
std::vector<std::string> palette_arguments(const EncodeJob& job, const Delivery& delivery);

}   // namespace gnomon::video
