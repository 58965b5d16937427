// SPDX-License-Identifier: Apache-2.0
#include "video/encoder.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>

#include "gnomon/error.h"
#include "gnomon/video.h"
#include "io/file/atomic_file.h"
#include "video/mp4.h"
#include "video/process.h"

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
constexpr const char* k_program = "ffmpeg";
constexpr const char* k_quality = "16";   // x264's constant rate factor: visually almost lossless
// Crop an odd side by one row or column; use screen colours (Rec. 709, studio range) with exact rounding.
constexpr const char* k_filters =
    "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,"
    "scale=flags=bicubic+accurate_rnd+full_chroma_int+bitexact:out_color_matrix=bt709:out_range=tv,format=yuv420p";

// One thread everywhere: x264's results are repeatable, but depend on the number of threads.
std::vector<std::string> encode_arguments(double fps, const fs::path& out, const std::string& comment)
{
    std::vector<std::string> arguments{k_program,
                                       "-hide_banner",
                                       "-nostdin",
                                       "-loglevel",
                                       "error",
                                       "-y",
                                       "-f",
                                       "image2pipe",
                                       "-framerate",
                                       rate_text(fps),
                                       "-threads",
                                       "1",
                                       "-c:v",
                                       "png",
                                       "-i",
                                       "pipe:0",
                                       "-an",
                                       "-sn",
                                       "-map_metadata",
                                       "-1",
                                       "-filter_threads",
                                       "1",
                                       "-vf",
                                       k_filters,
                                       "-c:v",
                                       "libx264",
                                       "-threads",
                                       "1",
                                       "-crf",
                                       k_quality,
                                       "-preset",
                                       "medium",
                                       "-color_primaries",
                                       "bt709",
                                       "-color_trc",
                                       "bt709",
                                       "-colorspace",
                                       "bt709",
                                       "-color_range",
                                       "tv",
                                       "-fflags",
                                       "+bitexact",
                                       "-flags:v",
                                       "+bitexact",
                                       "-movflags",
                                       "+faststart"};
    if (!comment.empty()) arguments.insert(arguments.end(), {"-metadata", "comment=" + comment});
    arguments.insert(arguments.end(), {"-f", "mp4", "file:" + out.string()});
    return arguments;
}

std::vector<std::uint8_t> bytes_of(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
    if (!in || bytes.empty()) throw MissingError(fmt::format("cannot read the frame {}", file.string()));
    return bytes;
}

// The last informative line of ffmpeg's messages; it ends with a generic remark that it failed.
std::string last_line(const std::string& text)
{
    std::string last;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        while (!line.empty() && static_cast<unsigned char>(line.back()) <= ' ') line.pop_back();
        if (!line.empty() && line != "Conversion failed!") last = std::move(line);
        begin = end + 1;
    }
    return last;
}
}   // namespace

void encode_video(const std::vector<fs::path>& frames, double fps, const fs::path& out, const Progress& progress,
                  const std::string& comment)
{
    if (frames.empty()) throw UsageError(fmt::format("{}: a video needs at least one frame", out.string()));
    if (!(fps > 0)) throw UsageError(fmt::format("{}: the rate of a video must be above 0", out.string()));

    double done = 0;
    const auto keep_waiting = [&] { return !progress || progress({"encoding", done}); };
    io::AtomicFile file(out, frames.front().parent_path());   // the unfinished file is stored with the frames
    Process ffmpeg(encode_arguments(fps, file.temporary(), comment));

    // Feed the frames one by one. If the program stops reading, it has reported an error.
    bool reading = true;
    for (std::size_t i = 0; i < frames.size() && reading; ++i) {
        if (!keep_waiting()) throw InterruptedError("interrupted");
        reading = ffmpeg.write(bytes_of(frames[i]), keep_waiting);
        done = static_cast<double>(i + 1) / static_cast<double>(frames.size());
    }
    const int status = ffmpeg.wait(keep_waiting);
    if (status < 0) throw MissingError(fmt::format("ffmpeg was ended by signal {} ({})", -status, out.string()));
    const bool whole = status == 0 && reading && is_whole_mp4(file.temporary());
    if (!whole) {
        const std::string reason = last_line(ffmpeg.errors());
        const std::string short_of =
            fmt::format("exit status {}{}", status, status == 0 ? ", but the video is incomplete" : "");
        throw MissingError(
            fmt::format("ffmpeg could not write {}: {}", out.string(), reason.empty() ? short_of : reason));
    }
    file.commit();
}

std::string rate_text(double fps)
{
    constexpr double k_rounding = 1e-3;
    const double above = std::round(fps * 1001);
    const bool whole = std::abs(fps - std::round(fps)) < k_rounding / 1001;
    if (!whole && std::abs(fps * 1001 - above) < k_rounding) return fmt::format("{}/1001", std::llround(above));
    return fmt::format("{:.9g}", fps);
}

bool have_ffmpeg(const Progress& progress)
{
    // Check for the encoder, too, because its absence would otherwise be found only after rendering.
    try {
        Process ffmpeg({k_program, "-hide_banner", "-h", "encoder=libx264"});
        return ffmpeg.wait([&] {
            return !progress || progress({"encoding", 0});
        }) == 0 &&
               ffmpeg.output().find("Encoder libx264") != std::string::npos;
    } catch (const MissingError&) {
        return false;
    }
}

}   // namespace gnomon::video

namespace gnomon {

bool can_encode_video(const Progress& progress)
{
    return video::have_ffmpeg(progress);
}

void encode_video(const std::vector<std::filesystem::path>& pngs, double fps, const std::filesystem::path& out,
                  const Progress& progress)
{
    video::encode_video(pngs, fps, out, progress);
}

}   // namespace gnomon
