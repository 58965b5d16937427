// SPDX-License-Identifier: Apache-2.0
#include "video/encoder.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>

#include "gnomon/error.h"
#include "gnomon/video.h"
#include "io/file/atomic_file.h"
#include "io/image/image_file.h"
#include "video/encoder_arguments.h"
#include "video/finished_video.h"
#include "video/gif.h"
#include "video/process.h"
#include "video/sound.h"

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
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
// Runs ffmpeg with arguments and feeds it the frames one by one.
class Encoder {
 public:
    Encoder(const std::vector<fs::path>& frames, const fs::path& out, const Progress& progress, int passes)
        : frames_(frames), out_(out), progress_(progress), passes_(passes)
    {
    }

    /// @param file  what has to be there afterwards
    /// @throws MissingError  it fails, or the file is not complete
    void run(const std::vector<std::string>& arguments, const std::function<bool()>& is_complete)
    {
        const auto keep_waiting = [&] { return !progress_ || progress_({"encoding", done_}); };
        Process ffmpeg(arguments);
        // If the program stops reading, it has reported an error.
        bool reading = true;
        for (std::size_t i = 0; i < frames_.size() && reading; ++i) {
            if (!keep_waiting()) throw InterruptedError("interrupted");
            reading = ffmpeg.write(bytes_of(frames_[i]), keep_waiting);
            const double part = static_cast<double>(i + 1) / static_cast<double>(frames_.size());
            done_ = (passes_done_ + part) / passes_;
        }
        const int status = ffmpeg.wait(keep_waiting);
        ++passes_done_;
        if (status < 0) throw MissingError(fmt::format("ffmpeg was ended by signal {} ({})", -status, out_.string()));
        if (status == 0 && reading && is_complete()) return;
        const std::string reason = last_line(ffmpeg.errors());
        const std::string short_of =
            fmt::format("exit status {}{}", status, status == 0 ? ", but the video is incomplete" : "");
        throw MissingError(
            fmt::format("ffmpeg could not write {}: {}", out_.string(), reason.empty() ? short_of : reason));
    }

 private:
    const std::vector<fs::path>& frames_;
    const fs::path& out_;
    const Progress& progress_;
    int passes_;
    int passes_done_ = 0;
    double done_ = 0;
};
}   // namespace

void encode_video(const std::vector<fs::path>& frames, double fps, const fs::path& out, const Progress& progress,
                  const std::string& comment, const Delivery& delivery)
{
    if (frames.empty()) throw UsageError(fmt::format("{}: a video needs at least one frame", out.string()));
    if (!(fps > 0)) throw UsageError(fmt::format("{}: the rate of a video must be above 0", out.string()));

    io::AtomicFile file(out, frames.front().parent_path());   // the unfinished file is stored with the frames
    EncodeJob job;
    job.rate = rate_text(fps);
    job.seconds = static_cast<double>(frames.size()) / fps;
    job.out = file.temporary();
    job.comment = comment;
    if (!delivery.audio.empty()) job.sound_codec = sound_codec_of(delivery.audio, progress);
    const bool gif = delivery.container == Container::gif;
    Encoder encoder(frames, out, progress, gif ? 2 : 1);
    std::optional<io::AtomicFile> palette;   // is removed at the end
    if (gif) {
        palette.emplace(out.string() + ".palette", frames.front().parent_path());
        job.palette = palette->temporary();
        std::error_code none;
        encoder.run(palette_arguments(job, delivery), [&] { return fs::file_size(job.palette, none) > 0; });
    }
    encoder.run(encode_arguments(job, delivery), [&] { return is_whole_video(job.out, delivery.container); });
    if (gif) add_gif_comment(job.out, comment);
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

bool have_ffmpeg(const Progress& progress, const std::string& encoder)
{
    // Check for the encoder, too, because its absence would otherwise be found only after rendering.
    try {
        Process ffmpeg({"ffmpeg", "-hide_banner", "-h", "encoder=" + encoder});
        return ffmpeg.wait([&] {
            return !progress || progress({"encoding", 0});
        }) == 0 &&
               ffmpeg.output().find("Encoder " + encoder) != std::string::npos;
    } catch (const MissingError&) {
        return false;
    }
}

void check_encoder(const Delivery& delivery, const Progress& progress)
{
    const std::string extension(extension_of(delivery.container));
    const auto need = [&](const std::string& encoder, const std::string& what, const char* instead) {
        if (!have_ffmpeg(progress, encoder))
            throw MissingError(
                fmt::format("ffmpeg with {} is needed for {} and was not found; {}", encoder, what, instead));
    };
    const std::string what = delivery.codec == VideoCodec::h264 || delivery.codec == VideoCodec::automatic
                                 ? extension
                                 : fmt::format("{} in a {}", title_of(delivery.codec), extension);
    need(encoder_of(delivery.codec), what, "write name-{frame:04}.png instead");
    if (delivery.audio.empty()) return;
    const std::string sound = sound_encoder(delivery.container, sound_codec_of(delivery.audio, progress));
    if (!sound.empty()) need(sound, "the sound of a " + extension, "convert it first, or leave out --audio");
}

}   // namespace gnomon::video

namespace gnomon {

bool can_encode_video(const Progress& progress)
{
    return video::have_ffmpeg(progress);
}

void encode_video(const std::vector<std::filesystem::path>& pngs, double fps, const std::filesystem::path& out,
                  const Progress& progress, const Encoding& encoding)
{
    if (pngs.empty()) throw UsageError(fmt::format("{}: a video needs at least one frame", out.string()));
    const io::PngKind kind = io::png_kind(pngs.front());
    video::Delivery delivery = video::choose_delivery(out, encoding, kind.alpha, fps);
    if (!delivery.audio.empty()) delivery.audio_hash = video::hash_of_file(delivery.audio);
    video::encode_video(pngs, fps, out, progress, {}, delivery);
}

}   // namespace gnomon
