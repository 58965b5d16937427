// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a video file is: its container, codec, depth and sound, as chosen from its name and the options.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "gnomon/video.h"

namespace gnomon::video {

enum class Container : std::uint8_t { mp4, mov, mkv, webm, gif };

/// The container that a name selects by its extension.
/// @throws UsageError  none of them
Container container_of(const std::filesystem::path& file);
/// ".mp4"
std::string_view extension_of(Container container);
/// "h264", as the command line names it; "gif" for automatic, which only a .gif keeps.
std::string_view name_of(VideoCodec codec);
/// The inverse.
/// @throws UsageError  there is none
VideoCodec codec_named(std::string_view name);
/// "H.264", for messages
std::string_view title_of(VideoCodec codec);

/// How a video is encoded, with nothing left to choose.
struct Delivery {
    Container container = Container::mp4;
    VideoCodec codec = VideoCodec::h264;   // automatic: that of a .gif
    int quality = k_video_quality;         // 0 to 100; of codecs that have one
    bool alpha = false;
    bool deep = false;               // 10 bits a channel instead of 8
    std::filesystem::path audio{};   // empty: none
    std::uint64_t audio_hash = 0;    // of that file
    std::string timecode{};          // of the first frame; empty: none
    friend bool operator==(const Delivery&, const Delivery&) = default;
};

/// Chooses what is not given, and checks that container, codec and the rest go together. The audio file is not opened.
/// @param transparent  the frames have alpha
/// @param first        number of the video's first frame in the clip, for the timecode
/// @throws UsageError  they do not go together: what the container takes instead
Delivery choose_delivery(const std::filesystem::path& out, const Encoding& encoding, bool transparent, double fps,
                         int first = 1);

/// A hash of a file's bytes.
/// @throws InputError  it cannot be read
std::uint64_t hash_of_file(const std::filesystem::path& file);

/// In words, for the text that a finished video carries: "h265, quality 75"; empty for an .mp4 with the defaults.
std::string text_of(const Delivery& delivery);

}   // namespace gnomon::video
