// SPDX-License-Identifier: Apache-2.0
#include "video/delivery.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <vector>

#include "base/hash.h"
#include "gnomon/error.h"
#include "video/timecode.h"

namespace gnomon::video {

namespace fs = std::filesystem;

namespace {
constexpr std::string_view k_extensions[] = {".mp4", ".mov", ".mkv", ".webm", ".gif"};   // of each Container
constexpr double k_fastest_gif = 50;   // frames a second: viewers show shorter frames more slowly
constexpr const char* k_first_timecode = "00:00:00:00";

constexpr unsigned bit(Container container)
{
    return 1u << static_cast<unsigned>(container);
}

struct Codec {
    VideoCodec codec;
    std::string_view name, title;
    unsigned containers;   // that take it, the most usual first in `k_extensions`
    unsigned with_alpha;   // those in which it has alpha
    bool deep;             // 10 bits
    bool deep_alpha;       // with alpha, too
    bool has_quality;
};
constexpr unsigned k_mp4 = bit(Container::mp4), k_mov = bit(Container::mov), k_mkv = bit(Container::mkv),
                   k_webm = bit(Container::webm), k_gif = bit(Container::gif);
constexpr Codec k_codecs[] = {
    {VideoCodec::automatic, "gif", "GIF", k_gif, k_gif, false, false, false},
    {VideoCodec::h264, "h264", "H.264", k_mp4 | k_mov | k_mkv, 0, false, false, true},
    {VideoCodec::h265, "h265", "H.265", k_mp4 | k_mov | k_mkv, 0, true, false, true},
    {VideoCodec::prores, "prores", "ProRes", k_mov | k_mkv, k_mov | k_mkv, true, true, true},
    {VideoCodec::vp9, "vp9", "VP9", k_webm | k_mkv | k_mp4, k_webm | k_mkv, true, false, true},
    {VideoCodec::ffv1, "ffv1", "FFV1", k_mkv, k_mkv, true, true, false},
};

const Codec& row_of(VideoCodec codec)
{
    return *std::find_if(std::begin(k_codecs), std::end(k_codecs), [&](const Codec& c) { return c.codec == codec; });
}

// ".mov or .mkv"
std::string extensions_of(unsigned containers)
{
    std::vector<std::string_view> names;
    for (std::size_t i = 0; i < std::size(k_extensions); ++i)
        if (containers & (1u << i)) names.push_back(k_extensions[i]);
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        text += i == 0 ? "" : i + 1 == names.size() ? " or " : ", ";
        text += names[i];
    }
    return text;
}

VideoCodec usual_codec(Container container, bool alpha)
{
    switch (container) {
        case Container::webm:
            return VideoCodec::vp9;
        case Container::gif:
            return VideoCodec::automatic;
        case Container::mov:
            return alpha ? VideoCodec::prores : VideoCodec::h264;
        case Container::mkv:
            return alpha ? VideoCodec::ffv1 : VideoCodec::h264;
        case Container::mp4:
            break;
    }
    return VideoCodec::h264;
}

void check_pair(const std::string& out, Container container, const Encoding& encoding, const Codec& codec, bool alpha)
{
    if (container == Container::gif) {
        if (encoding.codec != VideoCodec::automatic)
            throw UsageError(fmt::format("{}: a .gif has no other codec; leave out --codec", out));
        if (!encoding.audio.empty()) throw UsageError(fmt::format("{}: a .gif has no sound; leave out --audio", out));
    }
    if (!(codec.containers & bit(container)))
        throw UsageError(fmt::format("{}: {} is not for {}; write {}", out, codec.title,
                                     k_extensions[static_cast<std::size_t>(container)],
                                     extensions_of(codec.containers)));
    if (alpha && !(codec.with_alpha & bit(container))) {
        const std::string why = codec.with_alpha ? fmt::format("{} has no alpha in a {}", codec.title,
                                                               k_extensions[static_cast<std::size_t>(container)])
                                                 : fmt::format("{} has no alpha", codec.title);
        throw UsageError(
            fmt::format("{}: {}, and the background is transparent: write .mov with ProRes, .webm, .mkv "
                        "with FFV1, .gif or numbered .png images, or choose a background of one colour",
                        out, why));
    }
    if (encoding.quality && !codec.has_quality)
        throw UsageError(fmt::format("{}: {} has no quality to choose; leave out --quality", out, codec.title));
    if (encoding.quality && (*encoding.quality < 0 || *encoding.quality > 100))
        throw UsageError(fmt::format("{}: quality {}: expected 0 to 100", out, *encoding.quality));
}

std::string first_timecode(const std::string& out, Container container, const std::string& wanted, double fps,
                           int first)
{
    const bool can = (k_mov | k_mp4 | k_mkv) & bit(container), usual = (k_mov | k_mkv) & bit(container);
    if (!wanted.empty() && !can)
        throw UsageError(fmt::format("{}: a {} has no timecode; write {}", out,
                                     k_extensions[static_cast<std::size_t>(container)],
                                     extensions_of(k_mov | k_mp4 | k_mkv)));
    if (wanted.empty() && (!usual || !timecode_rate(fps))) return {};
    return timecode_after(wanted.empty() ? k_first_timecode : wanted, first - 1, fps);
}
}   // namespace

Container container_of(const fs::path& file)
{
    std::string extension = file.extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (std::size_t i = 0; i < std::size(k_extensions); ++i)
        if (extension == k_extensions[i]) return static_cast<Container>(i);
    throw UsageError(fmt::format("{}: no video; expected {}", file.string(), extensions_of(~0u)));
}

std::string_view extension_of(Container container)
{
    return k_extensions[static_cast<std::size_t>(container)];
}

std::string_view name_of(VideoCodec codec)
{
    return row_of(codec).name;
}

VideoCodec codec_named(std::string_view name)
{
    for (const Codec& codec : k_codecs)
        if (codec.name == name) return codec.codec;
    throw UsageError(fmt::format("no codec '{}'", name));
}

std::string_view title_of(VideoCodec codec)
{
    return row_of(codec).title;
}

Delivery choose_delivery(const fs::path& out, const Encoding& encoding, bool transparent, double fps, int first)
{
    Delivery delivery;
    delivery.container = container_of(out);
    delivery.alpha = transparent;
    delivery.codec =
        encoding.codec == VideoCodec::automatic ? usual_codec(delivery.container, transparent) : encoding.codec;
    const Codec& codec = row_of(delivery.codec);
    check_pair(out.string(), delivery.container, encoding, codec, transparent);
    if (delivery.container == Container::gif && fps > k_fastest_gif)
        throw UsageError(
            fmt::format("{}: a .gif of {:g} frames a second: viewers show at most {:g}; --fps sets "
                        "another rate",
                        out.string(), fps, k_fastest_gif));
    delivery.deep = transparent ? codec.deep_alpha : codec.deep;
    delivery.quality = codec.has_quality ? encoding.quality.value_or(k_video_quality) : 100;
    delivery.audio = encoding.audio;
    delivery.timecode = first_timecode(out.string(), delivery.container, encoding.timecode, fps, first);
    return delivery;
}

std::uint64_t hash_of_file(const fs::path& file)
{
    std::error_code error;
    std::ifstream in(file, std::ios::binary);
    if (!in || !fs::is_regular_file(file, error)) throw InputError(file.string(), "", "cannot be read");
    std::vector<char> part(1 << 20);
    std::uint64_t hash = hash_bytes(nullptr, 0);
    while (in.read(part.data(), static_cast<std::streamsize>(part.size())) || in.gcount() > 0)
        hash = hash_bytes(part.data(), static_cast<std::size_t>(in.gcount()), hash);
    return hash;
}

std::string text_of(const Delivery& delivery)
{
    if (delivery == Delivery{}) return {};
    std::string text(name_of(delivery.codec));
    if (row_of(delivery.codec).has_quality) text += fmt::format(", quality {}", delivery.quality);
    if (delivery.alpha) text += ", alpha";
    if (!delivery.audio.empty()) text += fmt::format(", sound {:016x}", delivery.audio_hash);
    if (!delivery.timecode.empty()) text += fmt::format(", timecode {}", delivery.timecode);
    return text;
}

}   // namespace gnomon::video
