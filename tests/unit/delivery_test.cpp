// SPDX-License-Identifier: Apache-2.0
// What a video is delivered as: which pairs of codec and container there are, timecodes, and each codec's file as
// ffprobe and ffmpeg read it.
#include "video/delivery.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "gnomon/error.h"
#include "io/image/image_file.h"
#include "support.h"
#include "video/clip_exposure.h"
#include "video/encoder.h"
#include "video/finished_video.h"
#include "video/frame_file.h"
#include "video/process.h"
#include "video/timecode.h"

namespace gnomon::video {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Delivery, ChoosesTheUsualCodec)
{
    const auto codec = [](const char* out, bool alpha = false) { return choose_delivery(out, {}, alpha, 24).codec; };
    EXPECT_EQ(codec("a.mp4"), VideoCodec::h264);
    EXPECT_EQ(codec("a.MOV"), VideoCodec::h264);
    EXPECT_EQ(codec("a.mkv"), VideoCodec::h264);
    EXPECT_EQ(codec("a.webm"), VideoCodec::vp9);
    EXPECT_EQ(codec("a.gif"), VideoCodec::automatic);
    EXPECT_EQ(codec("a.mov", true), VideoCodec::prores);
    EXPECT_EQ(codec("a.mkv", true), VideoCodec::ffv1);
    EXPECT_EQ(codec("a.webm", true), VideoCodec::vp9);
    EXPECT_FALSE(choose_delivery("a.mp4", {}, false, 24).deep);
    EXPECT_TRUE(choose_delivery("a.mp4", {VideoCodec::h265}, false, 24).deep);
    EXPECT_FALSE(choose_delivery("a.webm", {}, true, 24).deep) << "VP9 has no alpha with 10 bits";
}

std::string refusal(const char* out, const Encoding& encoding, bool alpha = false, double fps = 24)
{
    try {
        choose_delivery(out, encoding, alpha, fps);
    } catch (const UsageError& error) {
        return error.what();
    }
    return {};
}

TEST(Delivery, RefusesWhatDoesNotGoTogether)
{
    EXPECT_EQ(refusal("a.mp4", {VideoCodec::prores}), "a.mp4: ProRes is not for .mp4; write .mov or .mkv");
    EXPECT_EQ(refusal("a.mov", {VideoCodec::vp9}), "a.mov: VP9 is not for .mov; write .mp4, .mkv or .webm");
    EXPECT_EQ(refusal("a.webm", {VideoCodec::h264}), "a.webm: H.264 is not for .webm; write .mp4, .mov or .mkv");
    EXPECT_EQ(refusal("a.mov", {VideoCodec::ffv1}), "a.mov: FFV1 is not for .mov; write .mkv");
    EXPECT_NE(refusal("a.gif", {VideoCodec::h264}).find("leave out --codec"), std::string::npos);
    EXPECT_NE(refusal("a.gif", {.audio = "a.wav"}).find("no sound"), std::string::npos);
    EXPECT_NE(refusal("a.gif", {.quality = 50}).find("leave out --quality"), std::string::npos);
    EXPECT_NE(refusal("a.mkv", {VideoCodec::ffv1, 50}).find("FFV1 has no quality"), std::string::npos);
    EXPECT_NE(refusal("a.mp4", {.quality = 101}).find("expected 0 to 100"), std::string::npos);
    EXPECT_NE(refusal("a.mp4", {}, true).find("H.264 has no alpha"), std::string::npos);
    EXPECT_NE(refusal("a.mp4", {VideoCodec::vp9}, true).find("VP9 has no alpha in a .mp4"), std::string::npos);
    EXPECT_NE(refusal("a.gif", {}, false, 60).find("at most 50"), std::string::npos);
    EXPECT_NE(refusal("a.webm", {.timecode = "01:00:00:00"}).find("no timecode"), std::string::npos);
    EXPECT_NE(refusal("a.mov", {.timecode = "01:00:00:24"}).find("no such time"), std::string::npos);
    EXPECT_NE(refusal("a.mov", {.timecode = "1:0:0:0"}).find("expected HH:MM:SS:FF"), std::string::npos);
    EXPECT_NE(refusal("a.mov", {.timecode = "01:00:00:00"}, false, 39.95).find("has no timecode"), std::string::npos);
    EXPECT_EQ(refusal("a.mov", {}, false, 39.95), "") << "without one, it is left out";
}

TEST(Timecode, CountsFramesAndDropsNumbers)
{
    constexpr double cinema = 24000.0 / 1001, television = 30000.0 / 1001;
    EXPECT_EQ(timecode_rate(cinema), 24);
    EXPECT_EQ(timecode_rate(25), 25);
    EXPECT_EQ(timecode_rate(23.976), std::nullopt);
    EXPECT_EQ(timecode_rate(0.5), std::nullopt);
    EXPECT_EQ(timecode_after("01:00:00:00", 0, cinema), "01:00:00:00");
    EXPECT_EQ(timecode_after("01:00:59:23", 1, 24), "01:01:00:00");
    EXPECT_EQ(timecode_after("23:59:59:24", 1, 25), "00:00:00:00");
    EXPECT_EQ(timecode_after("00:00:59;29", 1, television), "00:01:00;02");
    EXPECT_EQ(timecode_after("00:09:59;29", 1, television), "00:10:00;00");
    EXPECT_EQ(timecode_after("00:00:00;00", 17982, television), "00:10:00;00");
    EXPECT_EQ(timecode_after("00:00:59;59", 1, 2 * television), "00:01:00;04");
    EXPECT_THROW(timecode_after("00:01:00;00", 0, television), UsageError) << "this number is dropped";
    EXPECT_THROW(timecode_after("00:00:00;00", 0, 30), UsageError);
    // Counting one by one gives the same as counting at once.
    std::string code = "00:00:00;00";
    for (int i = 0; i < 20000; ++i) code = timecode_after(code, 1, television);
    EXPECT_EQ(code, timecode_after("00:00:00;00", 20000, television));
}

TEST(ClipExposure, FramesSpreadOverTheClip)
{
    EXPECT_EQ(exposure_frames(1), (std::vector<int>{1}));
    EXPECT_EQ(exposure_frames(3), (std::vector<int>{1, 2, 3}));
    const std::vector<int> frames = exposure_frames(800);
    ASSERT_EQ(frames.size(), 8u);
    EXPECT_EQ(frames.front(), 51);
    EXPECT_EQ(frames.back(), 751);
}

// Frames of 10 bits: a ramp with more levels than 8 bits have, and a square that moves over it.
std::vector<fs::path> deep_frames(const test::ScratchFolder& folder, int count, bool alpha)
{
    std::vector<fs::path> frames;
    for (int i = 0; i < count; ++i) {
        Image16 image(258, 64, alpha ? 4 : 3);
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) {
                std::uint16_t* p = image.pixel(x, y);
                const bool square = x / 16 == i % 8 && y / 16 == 2;
                for (int c = 0; c < 3; ++c)
                    p[c] = ten_bits(static_cast<std::uint16_t>(square ? 50000 : 64 * (256 + x + (c == 1 ? y : 0))));
                if (alpha) p[3] = ten_bits(static_cast<std::uint16_t>(square ? 65535 : 200 * x));
            }
        frames.push_back(folder / fmt::format("{}.png", i));
        io::write_png(frames.back(), image);
    }
    return frames;
}

std::string probe(const fs::path& video, const std::string& entries)
{
    Process ffprobe({"ffprobe", "-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries",
                     "stream=" + entries, "-of", "default=noprint_wrappers=1:nokey=1", video.string()});
    EXPECT_EQ(ffprobe.wait(), 0) << ffprobe.errors();
    EXPECT_EQ(ffprobe.errors(), "");
    std::string words = ffprobe.output();
    for (char& c : words)
        if (c == '\n') c = ' ';
    return words;
}

// Decodes a video to its end as raw pixels; no error may occur.
std::string decode(const fs::path& video, const std::string& format, const std::vector<std::string>& before = {})
{
    std::vector<std::string> words{"ffmpeg", "-v", "error", "-xerror"};
    words.insert(words.end(), before.begin(), before.end());
    words.insert(words.end(), {"-i", video.string(), "-map", "0:v", "-f", "rawvideo", "-pix_fmt", format, "-"});
    Process ffmpeg(words);
    EXPECT_EQ(ffmpeg.wait(), 0) << ffmpeg.errors();
    EXPECT_EQ(ffmpeg.errors(), "");
    return ffmpeg.output();
}

struct Case {
    const char* name;
    Encoding encoding;
    bool alpha;
    const char* pixels;   // pix_fmt
    const char* colors;   // range, matrix, transfer, primaries
    const char* size = "258 64";
};

class EveryCodec : public testing::TestWithParam<Case> {};

TEST_P(EveryCodec, HasItsFramesFormatAndTags)
{
    if (!have_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
    const Case& one = GetParam();
    constexpr double fps = 24000.0 / 1001;
    const Delivery delivery = choose_delivery(one.name, one.encoding, one.alpha, fps);
    if (delivery.container != Container::gif && !have_ffmpeg({}, "libx265")) GTEST_SKIP() << "not all encoders";
    const test::ScratchFolder folder;
    const std::vector<fs::path> frames = deep_frames(folder, 9, one.alpha);
    const fs::path out = folder / one.name;
    const std::string comment = "gnomon 1 2 3 4, frames 1-9 at 24";
    encode_video(frames, fps, out, {}, comment, delivery);
    // ffprobe has an order of its own.
    const bool gif = delivery.container == Container::gif;
    const std::string entries = gif ? "width,height,pix_fmt,nb_read_frames"
                                    : "width,height,pix_fmt,color_range,color_space,color_transfer,color_primaries,"
                                      "r_frame_rate,nb_read_frames";
    EXPECT_EQ(probe(out, entries),
              fmt::format("{} {} {}{}9 ", one.size, one.pixels, one.colors, gif ? "" : "24000/1001 "));
    EXPECT_EQ(decode(out, "gray").size(), 9u * 258 * 64);
    EXPECT_TRUE(is_whole_video(out, delivery.container));
    EXPECT_EQ(comment_of_video(out, delivery.container), comment);

    // The same bytes again.
    const fs::path again = folder / (std::string("again-") + one.name);
    encode_video(frames, fps, again, {}, comment, delivery);
    EXPECT_EQ(bytes_of(out), bytes_of(again));

    // A part of a file is not whole, and has no comment or a whole one.
    const std::string whole = bytes_of(out);
    for (std::size_t size = 0; size + 1 < whole.size(); size += 1 + whole.size() / 97) {
        std::ofstream(again, std::ios::binary) << whole.substr(0, size);
        EXPECT_FALSE(is_whole_video(again, delivery.container)) << size;
        const std::string found = comment_of_video(again, delivery.container);
        EXPECT_TRUE(found.empty() || found == comment) << size;
    }
    // Nor does a damaged one do harm.
    std::string damaged = whole;
    for (std::size_t i = 0; i < 200; ++i) {
        damaged[i * i * 31 % damaged.size()] = static_cast<char>(i % 3 == 0 ? 0xff : 37 * i);
        std::ofstream(again, std::ios::binary) << damaged;
        is_whole_video(again, delivery.container);
        EXPECT_LE(comment_of_video(again, delivery.container).size(), 4096u);
    }
}

constexpr const char* k_screen = "tv bt709 bt709 bt709 ";
INSTANTIATE_TEST_SUITE_P(
    Codecs, EveryCodec,
    testing::Values(Case{"a.mp4", Encoding{}, false, "yuv420p", k_screen},
                    Case{"b.mov", {}, false, "yuv420p", k_screen},
                    Case{"c.mkv", Encoding{}, false, "yuv420p", k_screen},
                    Case{"d.mp4", {VideoCodec::h265}, false, "yuv420p10le", k_screen},
                    Case{"e.mov", {VideoCodec::h265}, false, "yuv420p10le", k_screen},
                    Case{"f.mkv", {VideoCodec::h265}, false, "yuv420p10le", k_screen},
                    Case{"g.mov", {VideoCodec::prores}, false, "yuv422p10le", k_screen},
                    Case{"h.mkv", {VideoCodec::prores, 10}, false, "yuv422p10le", k_screen},
                    Case{"i.mov", {}, true, "yuva444p12le", k_screen},
                    Case{"j.webm", Encoding{}, false, "yuv420p10le", k_screen},
                    Case{"k.webm", {}, true, "yuv420p", k_screen},   // its alpha is a stream beside
                    Case{"l.mp4", {VideoCodec::vp9}, false, "yuv420p10le", k_screen},
                    Case{"m.mkv", {VideoCodec::ffv1}, false, "gbrp10le", "pc gbr iec61966-2-1 bt709 "},
                    Case{"n.mkv", {}, true, "gbrap10le", "pc gbr iec61966-2-1 bt709 "},
                    Case{"o.gif", Encoding{}, false, "bgra", ""}, Case{"p.gif", {}, true, "bgra", ""}),
    [](const testing::TestParamInfo<Case>& of) {
        std::string name = of.param.name;
        name[1] = '_';
        return name;
    });

TEST(Encoder, Ffv1KeepsTenBitsExactly)
{
    if (!have_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
    const test::ScratchFolder folder;
    const std::vector<fs::path> frames = deep_frames(folder, 1, false);
    const fs::path out = folder / "a.mkv";
    encode_video(frames, 24, out, {}, {}, choose_delivery(out, {VideoCodec::ffv1}, false, 24));
    const std::string planes = decode(out, "gbrp10le");
    ASSERT_EQ(planes.size(), 3u * 2 * 258 * 64);
    const auto value = [&](std::size_t plane, int x, int y) {
        const std::size_t at = 2 * ((plane * 64 + static_cast<std::size_t>(y)) * 258 + static_cast<std::size_t>(x));
        return static_cast<unsigned char>(planes[at]) | static_cast<unsigned char>(planes[at + 1]) << 8;
    };
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 258; ++x) {
            ASSERT_EQ(value(0, x, y), ten_bits(static_cast<std::uint16_t>(64 * (256 + x + y))) >> 6) << x << ' ' << y;
            ASSERT_EQ(value(2, x, y), ten_bits(static_cast<std::uint16_t>(64 * (256 + x))) >> 6) << x << ' ' << y;
        }
}

TEST(Encoder, ConvertsColorsByTheMatrixOfItsTags)
{
    if (!have_ffmpeg({}, "libx265")) GTEST_SKIP() << "no ffmpeg with libx265";
    // White, and a saturated colour, whose light would differ by 17 % with the matrix of Rec. 601.
    const test::ScratchFolder folder;
    for (const std::uint16_t other : {std::uint16_t{65535}, std::uint16_t{8000}}) {
        const std::uint16_t green = other == 65535 ? other : 52000;
        Image16 image(64, 64, 3);
        for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = ten_bits(i % 3 == 1 ? green : other);
        io::write_png(folder / "a.png", image);
        const double luma = (0.7152 * green + (0.2126 + 0.0722) * other) / 65535;
        for (const VideoCodec codec : {VideoCodec::h264, VideoCodec::h265, VideoCodec::vp9, VideoCodec::prores}) {
            const fs::path out = folder / (codec == VideoCodec::prores ? "a.mov" : "a.mkv");
            encode_video({folder / "a.png"}, 24, out, {}, {}, choose_delivery(out, {codec, 100}, false, 24));
            const bool deep = codec != VideoCodec::h264;
            const std::string y = decode(out, codec == VideoCodec::prores ? "yuv422p10le"
                                              : deep                      ? "yuv420p10le"
                                                                          : "yuv420p");
            const auto byte = [&](std::size_t at) { return static_cast<double>(static_cast<unsigned char>(y[at])); };
            const double found = deep ? byte(2080) + 256 * byte(2081) : byte(1040);
            EXPECT_NEAR(found, (deep ? 4 : 1) * (16 + 219 * luma), 1) << static_cast<int>(codec);
        }
    }
}

TEST(Encoder, WritesTheTimecode)
{
    if (!have_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
    const test::ScratchFolder folder;
    const std::vector<fs::path> frames = deep_frames(folder, 2, false);
    for (const char* name : {"a.mov", "a.mp4", "a.mkv"}) {
        const Delivery delivery = choose_delivery(name, {.timecode = "10:00:00:20"}, false, 24000.0 / 1001, 9);
        EXPECT_EQ(delivery.timecode, "10:00:01:04");
        encode_video(frames, 24000.0 / 1001, folder / name, {}, {}, delivery);
        Process ffprobe({"ffprobe", "-v", "error", "-show_entries", "format_tags=timecode:stream_tags=timecode", "-of",
                         "default=noprint_wrappers=1", (folder / name).string()});
        EXPECT_EQ(ffprobe.wait(), 0);
        EXPECT_NE(ffprobe.output().find("=10:00:01:04"), std::string::npos) << name << ffprobe.output();
    }
}

// A tone of some seconds.
void make_sound(const fs::path& file, double seconds, const std::vector<std::string>& codec)
{
    std::vector<std::string> words{"ffmpeg", "-v",    "error", "-y",
                                   "-f",     "lavfi", "-i",    fmt::format("sine=frequency=440:duration={}", seconds)};
    words.insert(words.end(), codec.begin(), codec.end());
    words.push_back(file.string());
    Process ffmpeg(words);
    ASSERT_EQ(ffmpeg.wait(), 0) << ffmpeg.errors();
}

TEST(Encoder, CopiesOrEncodesSoundAndEndsItWithTheVideo)
{
    if (!have_ffmpeg({}, "libopus")) GTEST_SKIP() << "no ffmpeg with libopus";
    const test::ScratchFolder folder;
    make_sound(folder / "long.wav", 5, {});
    make_sound(folder / "short.m4a", 0.4, {"-c:a", "aac"});
    const std::vector<fs::path> frames = deep_frames(folder, 48, false);
    const auto encoded = [&](const char* name, const char* sound, const char* codec, double seconds) {
        const Encoding encoding{.audio = folder / sound};
        gnomon::encode_video(frames, 24, folder / name, {}, encoding);
        EXPECT_EQ(probe(folder / name, "nb_read_frames"), "48 ") << name;
        Process ffprobe({"ffprobe", "-v", "error", "-count_packets", "-select_streams", "a:0", "-show_entries",
                         "stream=codec_name:packet=pts_time,duration_time", "-of", "csv=p=0",
                         (folder / name).string()});
        EXPECT_EQ(ffprobe.wait(), 0);
        const std::string text = ffprobe.output();
        EXPECT_NE(text.find(codec), std::string::npos)
            << name << text.substr(text.size() - std::min<std::size_t>(text.size(), 60));
        // The last packet's time and duration.
        double end = 0;
        for (std::size_t begin = 0; begin < text.size(); begin = text.find('\n', begin) + 1) {
            double at = 0, length = 0;
            if (std::sscanf(text.c_str() + begin, "%lf,%lf", &at, &length) == 2) end = std::max(end, at + length);
        }
        EXPECT_NEAR(end, seconds, 0.05) << name;
    };
    encoded("a.mp4", "long.wav", "aac", 2);
    encoded("a.mov", "long.wav", "pcm_s16le", 2);
    encoded("a.mkv", "long.wav", "pcm_s16le", 2);
    encoded("a.webm", "long.wav", "opus", 2);
    encoded("b.mp4", "short.m4a", "aac", 0.4);   // the video goes on in silence
}

TEST(Encoder, RefusesSoundThatIsNone)
{
    if (!have_ffmpeg()) GTEST_SKIP() << "no ffmpeg";
    const test::ScratchFolder folder;
    const std::vector<fs::path> frames = deep_frames(folder, 1, false);
    std::ofstream(folder / "text.wav") << "this is no sound";
    std::ofstream(folder / "empty.mp3");
    // A list that names another file must not be followed.
    std::ofstream(folder / "list.m3u8") << "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nhttp://127.0.0.1:9/a.ts\n";
    for (const char* name : {"text.wav", "empty.mp3", "list.m3u8", "0.png", "missing.wav", "."}) {
        const Encoding encoding{.audio = folder / name};
        EXPECT_THROW(gnomon::encode_video(frames, 24, folder / "a.mp4", {}, encoding), InputError) << name;
        EXPECT_FALSE(fs::exists(folder / "a.mp4")) << name;
    }
}

TEST(Jpeg, IsReadAgainAndRecognised)
{
    const test::ScratchFolder folder;
    Image8 image(37, 21, 3);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = static_cast<std::uint8_t>(5 * x + 2 * y + 10 * c);
    io::write_jpeg(folder / "fine.jpg", image, 95);
    io::write_jpeg(folder / "coarse.jpg", image, 20);
    EXPECT_LT(fs::file_size(folder / "coarse.jpg"), fs::file_size(folder / "fine.jpg"));
    const Image8 read = io::read_image(folder / "fine.jpg");
    ASSERT_EQ(read.data.size(), image.data.size());
    int most = 0;
    for (std::size_t i = 0; i < read.data.size(); ++i) most = std::max(most, std::abs(read.data[i] - image.data[i]));
    EXPECT_LE(most, 6);
    EXPECT_TRUE(io::is_whole_jpeg(folder / "fine.jpg", 37, 21));
    EXPECT_FALSE(io::is_whole_jpeg(folder / "fine.jpg", 21, 37));
    const std::string whole = bytes_of(folder / "fine.jpg");
    for (std::size_t size = 0; size < whole.size(); ++size) {
        std::ofstream(folder / "part.jpg", std::ios::binary) << whole.substr(0, size);
        EXPECT_FALSE(io::is_whole_jpeg(folder / "part.jpg", 37, 21)) << size;
    }
}

}   // namespace
}   // namespace gnomon::video
