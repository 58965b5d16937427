// SPDX-License-Identifier: Apache-2.0
#include "video/sound.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "gnomon/error.h"
#include "video/process.h"

namespace gnomon::video {

std::string sound_codec_of(const std::filesystem::path& file, const Progress& progress)
{
    std::error_code error;
    if (!std::filesystem::exists(file, error)) throw InputError(file.string(), "", "no such file");
    if (!std::filesystem::is_regular_file(file, error)) throw InputError(file.string(), "", "not a file");
    // Read files of sound and video alone: a list of parts could name others, and be waited for.
    constexpr const char* k_formats =
        "wav,w64,aiff,caf,au,mp3,aac,ac3,eac3,dts,flac,ogg,mov,matroska,avi,asf,mpegts,mpeg,amr,ape,wv,tta";
    std::optional<Process> ffprobe;
    try {
        ffprobe.emplace(std::vector<std::string>{"ffprobe", "-v", "error", "-protocol_whitelist", "file",
                                                 "-format_whitelist", k_formats, "-select_streams", "a:0",
                                                 "-show_entries", "stream=codec_name,sample_rate", "-of",
                                                 "default=noprint_wrappers=1:nokey=1", "file:" + file.string()});
    } catch (const MissingError&) {
        throw MissingError(
            fmt::format("ffprobe, which comes with ffmpeg, is needed to read {} and was not found", file.string()));
    }
    const int status = ffprobe->wait([&] { return !progress || progress({"encoding", 0}); });
    const std::string answer = ffprobe->output();
    std::string codec = answer.substr(0, answer.find('\n'));
    const bool sound =
        !codec.empty() && codec != "unknown" &&
        std::all_of(codec.begin(), codec.end(), [](unsigned char c) { return std::isalnum(c) || c == '_'; });
    if (status != 0 || !sound) throw InputError(file.string(), "", "there is no sound in it that ffmpeg can read");
    return codec;
}

}   // namespace gnomon::video
