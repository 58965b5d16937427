// SPDX-License-Identifier: Apache-2.0
#include "video/encoder_arguments.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace gnomon::video {

namespace {
using Words = std::vector<std::string>;

// Constant rate factors at quality 0 and 100; between them they are linear, with an upper limit. All three then give
// about the same error (docs/guide/videos.md); at 75 it is visually almost lossless.
struct RateFactors {
    double worst, best;
};
constexpr RateFactors k_h264{40, 8}, k_h265{40, 8}, k_vp9{73, 13};
constexpr double k_largest_factor = 63;   // of VP9

// Profiles of ProRes, from the quality at which each begins: proxy, LT, standard, HQ; with alpha 4444 and 4444 XQ.
constexpr int k_lt = 25, k_standard = 50, k_hq = 75, k_xq = 90;

// Patterns are the same in all frames, so that what stands still does not shimmer, as it does with diffused errors.
constexpr const char* k_dither = "dither=bayer:bayer_scale=3";
constexpr int k_opaque = 128;   // alpha from which a pixel of a .gif is opaque

void append(Words& words, std::initializer_list<std::string> more)
{
    words.insert(words.end(), more);
}

std::string rate_factor(const RateFactors& factors, int quality)
{
    const double factor = factors.worst + (factors.best - factors.worst) * quality / 100;
    return std::to_string(std::lround(std::min(factor, k_largest_factor)));
}

std::string pixel_format(const Delivery& delivery)
{
    switch (delivery.codec) {
        case VideoCodec::h265:
            return "yuv420p10le";
        case VideoCodec::prores:
            return delivery.alpha ? "yuva444p10le" : "yuv422p10le";
        case VideoCodec::vp9:
            return delivery.alpha ? "yuva420p" : "yuv420p10le";
        case VideoCodec::ffv1:
            return delivery.alpha ? "gbrap10le" : "gbrp10le";
        case VideoCodec::h264:
        case VideoCodec::automatic:
            break;
    }
    return "yuv420p";
}

// Crop an odd side by one row or column where colours have half the resolution; convert with exact rounding. ffmpeg's
// converter takes 65,280 for white where values have 16 bits, so that 65,535 would become brighter than white by 0.4 %.
// The encoder of ProRes notes the tags of frames, not its own.
std::string filters(const Delivery& delivery)
{
    const bool prores = delivery.codec == VideoCodec::prores;
    const std::string format = pixel_format(delivery);
    const std::string scale = "scale=flags=bicubic+accurate_rnd+full_chroma_int+bitexact";
    if (delivery.codec == VideoCodec::ffv1) return fmt::format("{},format={}", scale, format);
    const char* const crop = !prores          ? "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,"
                             : delivery.alpha ? ""
                                              : "crop=trunc(iw/2)*2:ih:0:0,";
    const char* const white = delivery.deep ? "lutrgb=r=val*65280/65535:g=val*65280/65535:b=val*65280/65535," : "";
    const char* const tags = prores ? ",setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709" : "";
    return fmt::format("{}{}{}:out_color_matrix=bt709:out_range=tv,format={}{}", crop, white, scale, format, tags);
}

void add_codec(Words& words, const Delivery& delivery)
{
    append(words, {"-c:v", encoder_of(delivery.codec), "-threads", "1"});
    const int quality = delivery.quality;
    switch (delivery.codec) {
        case VideoCodec::h264:
            append(words, {"-crf", rate_factor(k_h264, quality), "-preset", "medium"});
            break;
        case VideoCodec::h265:
            append(words, {"-crf", rate_factor(k_h265, quality), "-preset", "medium", "-x265-params",
                           "pools=none:frame-threads=1:wpp=0:info=0:log-level=error"});
            if (delivery.container != Container::mkv) append(words, {"-tag:v", "hvc1"});   // as Apple's players need it
            break;
        case VideoCodec::prores: {
            const int profile = delivery.alpha ? 4 + (quality >= k_xq)
                                               : (quality >= k_lt) + (quality >= k_standard) + (quality >= k_hq);
            append(words, {"-profile:v", std::to_string(profile), "-vendor", "apl0"});
            if (delivery.alpha) append(words, {"-alpha_bits", "16"});
            break;
        }
        case VideoCodec::vp9:
            append(words, {"-b:v", "0", "-crf", rate_factor(k_vp9, quality), "-deadline", "good", "-cpu-used", "2",
                           "-row-mt", "0", "-tile-columns", "0"});
            // The encoder of alpha takes no frames that are never shown.
            if (delivery.alpha) append(words, {"-auto-alt-ref", "0"});
            break;
        case VideoCodec::ffv1:
            append(words, {"-level", "3", "-g", "1", "-slices", "4", "-slicecrc", "1"});
            break;
        case VideoCodec::automatic:
            break;
    }
    if (delivery.codec == VideoCodec::automatic) return;
    const bool rgb = delivery.codec == VideoCodec::ffv1;
    append(words, {"-color_primaries", "bt709", "-color_trc", rgb ? "iec61966-2-1" : "bt709", "-colorspace",
                   rgb ? "rgb" : "bt709", "-color_range", rgb ? "pc" : "tv"});
}

// The program, and the frames as its first input.
Words frame_input(const EncodeJob& job)
{
    return {"ffmpeg",     "-hide_banner", "-nostdin", "-loglevel", "error", "-y",  "-f", "image2pipe",
            "-framerate", job.rate,       "-threads", "1",         "-c:v",  "png", "-i", "pipe:0"};
}

std::string muxer_of(Container container)
{
    return container == Container::mkv ? "matroska" : std::string(extension_of(container).substr(1));
}

std::string file_word(const std::filesystem::path& file)
{
    return "file:" + file.string();
}

void add_sound(Words& words, const EncodeJob& job, Container container)
{
    const std::string encoder = sound_encoder(container, job.sound_codec);
    append(words, {"-map", "0:v:0", "-map", "1:a:0", "-c:a", encoder.empty() ? "copy" : encoder});
    if (!encoder.empty()) append(words, {"-b:a", encoder == "aac" ? "256k" : "192k"});
    append(words, {"-flags:a", "+bitexact"});
}
}   // namespace

std::string encoder_of(VideoCodec codec)
{
    switch (codec) {
        case VideoCodec::h264:
            return "libx264";
        case VideoCodec::h265:
            return "libx265";
        case VideoCodec::prores:
            return "prores_ks";
        case VideoCodec::vp9:
            return "libvpx-vp9";
        case VideoCodec::ffv1:
            return "ffv1";
        case VideoCodec::automatic:
            break;
    }
    return "gif";
}

std::string sound_encoder(Container container, const std::string& sound_codec)
{
    const auto among = [&](std::initializer_list<std::string_view> names) {
        return std::find(names.begin(), names.end(), sound_codec) != names.end();
    };
    const bool pcm = among({"pcm_s16le", "pcm_s24le", "pcm_s32le", "pcm_f32le"});
    const bool common = among({"aac", "mp3", "ac3", "eac3", "alac"});
    switch (container) {
        case Container::webm:
            return among({"opus", "vorbis"}) ? "" : "libopus";
        case Container::mkv:
            return common || pcm || among({"opus", "vorbis", "flac", "dts"}) ? "" : "aac";
        case Container::mov:
            return common || pcm || among({"pcm_s16be", "pcm_s24be"}) ? "" : "aac";
        case Container::mp4:
        case Container::gif:
            break;
    }
    return common || among({"opus", "flac"}) ? "" : "aac";
}

std::vector<std::string> encode_arguments(const EncodeJob& job, const Delivery& delivery)
{
    Words words = frame_input(job);
    const bool sound = !delivery.audio.empty();
    if (sound) append(words, {"-t", fmt::format("{:.6f}", job.seconds), "-i", file_word(delivery.audio)});
    if (delivery.container == Container::gif) append(words, {"-i", file_word(job.palette)});
    if (!sound) append(words, {"-an"});
    append(words, {"-sn", "-map_metadata", "-1"});
    if (sound) append(words, {"-map_chapters", "-1"});
    append(words, {"-filter_threads", "1"});
    if (delivery.container == Container::gif)
        append(words, {"-filter_complex_threads", "1", "-lavfi",
                       fmt::format("[0:v][1:v]paletteuse={}:alpha_threshold={}", k_dither, k_opaque)});
    else
        append(words, {"-vf", filters(delivery)});
    add_codec(words, delivery);
    if (sound) add_sound(words, job, delivery.container);
    append(words, {"-fflags", "+bitexact", "-flags:v", "+bitexact"});
    if (delivery.container == Container::mp4 || delivery.container == Container::mov)
        append(words, {"-movflags", "+faststart"});
    if (!delivery.timecode.empty()) append(words, {"-metadata", "timecode=" + delivery.timecode});
    if (!job.comment.empty()) append(words, {"-metadata", "comment=" + job.comment});
    append(words, {"-f", muxer_of(delivery.container), file_word(job.out)});
    return words;
}

std::vector<std::string> palette_arguments(const EncodeJob& job, const Delivery& delivery)
{
    Words words = frame_input(job);
    append(words, {"-filter_threads", "1", "-vf",
                   fmt::format("palettegen=stats_mode=full:reserve_transparent={}", delivery.alpha ? 1 : 0),
                   "-frames:v", "1", "-c:v", "png", "-f", "image2", "-update", "1", file_word(job.palette)});
    return words;
}

}   // namespace gnomon::video
