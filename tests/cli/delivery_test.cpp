// SPDX-License-Identifier: Apache-2.0
// What a video is delivered as, from the command line: exposure, alpha, sound, chunks, images, refusals.
#include <fmt/format.h>

#include <cmath>

#include "io/image/exr.h"
#include "io/image/float_image.h"
#include "io/image/image_file.h"
#include "run_program.h"
#include "video/process.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;

class Delivered : public testing::Test {
 protected:
    void SetUp() override
    {
        if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    }
    Outcome render(const std::string& name, const std::vector<std::string>& more = {}) const
    {
        std::vector<std::string> all{"render", scene,       "-o", folder / name, "--size",
                                     "64x48",  "--bounces", "1",  "--quiet"};
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    }
    void make(const std::string& name, const std::vector<std::string>& more = {}) const
    {
        const Outcome outcome = render(name, more);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
    }
    std::string decode(const std::string& name, const std::string& format,
                       const std::vector<std::string>& before = {}) const
    {
        std::vector<std::string> words{"ffmpeg", "-v", "error", "-xerror"};
        words.insert(words.end(), before.begin(), before.end());
        words.insert(words.end(), {"-i", folder / name, "-f", "rawvideo", "-pix_fmt", format, "-"});
        video::Process ffmpeg(words);
        EXPECT_EQ(ffmpeg.wait(), 0) << ffmpeg.errors();
        return ffmpeg.output();
    }
    ScratchFolder folder;
    std::string scene = "builtin:cornell";
};

double exposure_in(const Outcome& outcome)
{
    return outcome.json()["frames"][0]["exposure"].get<double>();
}

TEST_F(Delivered, ExposureOfAVideoDependsOnTheClipAlone)
{
    const Outcome whole = render("a-{frame}.png", {"--frames", "1-3", "--json"});
    ASSERT_EQ(whole.code, 0) << whole.err;
    const double exposure = exposure_in(whole);
    for (const auto& frame : whole.json()["frames"]) EXPECT_EQ(frame["exposure"], exposure);
    EXPECT_EQ(exposure_in(render("b-%d.png", {"--frames", "30-30", "--json"})), exposure);
    EXPECT_EQ(exposure_in(render("c.mp4", {"--frames", "40", "--json"})), exposure);
    EXPECT_EQ(exposure_in(render("d.mp4", {"--chunk", "7/9", "--json"})), exposure);
    EXPECT_EQ(exposure_in(render("e-{frame}.exr", {"--frames", "2-2", "--json"})), exposure);
    EXPECT_EQ(exposure_in(render("f-%d.png", {"--frames", "2-2", "--json", "--threads", "1"})), exposure);
    // A chunk leaves it in the manifest, where the others find it.
    const std::string manifest = bytes_of(folder / "d.mp4.frames/manifest.json");
    EXPECT_EQ(nlohmann::json::parse(manifest)["exposure"], exposure);
    EXPECT_EQ(exposure_in(render("d.mp4", {"--chunk", "1/9", "--json"})), exposure);

    // A single image has the exposure of its frame, as each frame has with auto-frame.
    const Outcome image = render("f.png", {"--frame", "30", "--json"});
    EXPECT_NE(exposure_in(image), exposure);
    EXPECT_EQ(exposure_in(render("g-%d.png", {"--frames", "30-30", "--exposure", "auto-frame", "--json"})),
              exposure_in(image));
    EXPECT_EQ(exposure_in(render("h.mp4", {"--frames", "30-30", "--exposure", "-1.5", "--json"})), -1.5);
    EXPECT_EQ(render("i.png", {"--exposure", "auto-clip"}).code, 2);
}

TEST_F(Delivered, ChunksMakeTheSameBytesWithEveryCodec)
{
    struct Kind {
        const char* name;
        std::vector<std::string> options;
    };
    for (const Kind& kind : {Kind{"a.mp4", {"--codec", "h265"}}, Kind{"a.mov", {"--codec", "prores"}},
                             Kind{"a.webm", {}}, Kind{"a.mkv", {"--codec", "ffv1"}}, Kind{"a.gif", {}}}) {
        std::vector<std::string> options{"--frames", "3-8"};
        options.insert(options.end(), kind.options.begin(), kind.options.end());
        const std::string whole = std::string("whole-") + kind.name;
        make(whole, options);
        for (const char* chunk : {"2/2", "1/2"}) {
            std::vector<std::string> part = options;
            part.insert(part.end(), {"--chunk", chunk});
            make(kind.name, part);
        }
        const Outcome joined = run({"join", folder / kind.name, "--quiet"});
        ASSERT_EQ(joined.code, 0) << joined.err;
        EXPECT_EQ(bytes_of(folder / kind.name), bytes_of(folder / whole)) << kind.name;
        // A finished video is recognised, and one of another encoding is not.
        options.insert(options.end(), {"--resume", "--json"});
        const Outcome again = render(whole, options);
        for (const auto& frame : again.json()["frames"]) EXPECT_TRUE(frame.value("kept", false)) << kind.name;
    }
}

// Spheres over a checkerboard, from a video with alpha, and from the PNG of the same frame.
TEST_F(Delivered, AlphaCompositesAsThatOfTheImage)
{
    scene = "builtin:spheres?objects=30&dynamic=10";
    const std::vector<std::string> options{"--background", "transparent", "--frames", "1-1", "--exposure", "0"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), options.begin(), options.end());
        return more;
    };
    make("a-{frame}.png", with({}));
    const Image8 png = io::read_image(folder / "a-1.png");
    ASSERT_EQ(png.channels, 4);
    const auto over = [](double color, double alpha, int x, int y) {
        const double board = (x / 8 + y / 8) % 2 ? 200 : 60;
        return alpha * color + (1 - alpha) * board;
    };
    struct Kind {
        const char* name;
        std::vector<std::string> more, decoder;
        double mean;   // error allowed, in codes of 255
    };
    std::size_t edges = 0;
    for (int i = 0; i < 64 * 48; ++i) edges += png.data[4 * i + 3] > 0 && png.data[4 * i + 3] < 255;
    EXPECT_GT(edges, 30u) << "the test needs edges";
    for (const Kind& kind :
         {Kind{"a.mov", {}, {}, 1.5}, Kind{"a.mkv", {}, {}, 0.3}, Kind{"a.webm", {}, {"-c:v", "libvpx-vp9"}, 3}}) {
        make(kind.name, with(kind.more));
        const std::string rgba = decode(kind.name, "rgba", kind.decoder);
        ASSERT_EQ(rgba.size(), 4u * 64 * 48) << kind.name;
        double sum = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) {
                const auto* p = reinterpret_cast<const unsigned char*>(rgba.data()) + 4 * (y * 64 + x);
                const std::uint8_t* q = png.pixel(x, y);
                for (int c = 0; c < 3; ++c)
                    sum += std::abs(over(p[c], p[3] / 255.0, x, y) - over(q[c], q[3] / 255.0, x, y));
            }
        EXPECT_LT(sum / (3 * 64 * 48), kind.mean) << kind.name;
    }
    make("a.gif", with({}));
    EXPECT_EQ(decode("a.gif", "rgba").size(), 4u * 64 * 48);

    const Outcome refused = render("b.mp4", with({}));
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("H.264 has no alpha"), std::string::npos) << refused.err;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1);
    EXPECT_EQ(render("b.jpg", {"--background", "transparent"}).code, 2);
    EXPECT_FALSE(fs::exists(folder / "b.mp4"));
}

TEST_F(Delivered, RefusesInOneLineWhatDoesNotGo)
{
    std::ofstream(folder / "text.wav") << "no sound";
    const auto refused = [&](const std::string& name, const std::vector<std::string>& options, int code,
                             const std::string& text) {
        const Outcome outcome = render(name, options);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    };
    refused("a.mp4", {"--codec", "prores"}, 2, "ProRes is not for .mp4; write .mov or .mkv");
    refused("a.mp4", {"--codec", "mjpeg"}, 2, "--codec mjpeg");
    refused("a.png", {"--codec", "h264"}, 2, "--codec needs the output of a video");
    refused("a.png", {"--quality", "50"}, 2, "--quality needs");
    refused("a.mp4", {"--exr-type", "half"}, 2, "--exr-type needs .exr output");
    refused("a.mp4", {"--audio", folder / "text.wav"}, 3, "there is no sound in it");
    refused("a.mp4", {"--audio", folder / "none.wav"}, 3, "none.wav");
    refused("none/a.mp4", {}, 4, "none");
    refused("a.avi", {}, 2, "write .png, .jpg, .exr, .mp4, .mov, .mkv, .webm or .gif");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"text.wav"});

    // An ffmpeg without an encoder is found out before the first frame.
    ScratchFolder programs;
    std::ofstream(programs / "ffmpeg") << "#!/bin/sh\ncase \"$*\" in *libx264*) echo Encoder libx264;; esac\n";
    fs::permissions(programs / "ffmpeg", fs::perms::owner_all);
    const Outcome lacking = run({"render", "builtin:cornell", "-o", folder / "a.mp4", "--codec", "h265", "--quiet"},
                                {{"PATH", programs.path()}});
    EXPECT_EQ(lacking.code, 4);
    EXPECT_NE(lacking.err.find("ffmpeg with libx265 is needed for H.265"), std::string::npos) << lacking.err;
}

TEST_F(Delivered, JoinNeedsTheSoundThatTheChunksHad)
{
    video::Process tone({"ffmpeg", "-v", "error", "-f", "lavfi", "-i", "sine=duration=3", folder / "a.wav"});
    ASSERT_EQ(tone.wait(), 0);
    make("a.mkv", {"--frames", "1-4", "--audio", folder / "a.wav", "--chunk", "1/1"});
    make("b.mkv", {"--frames", "1-4", "--audio", folder / "a.wav", "--chunk", "1-4"});
    const Outcome joined = run({"join", folder / "b.mkv", "--quiet"});
    ASSERT_EQ(joined.code, 0) << joined.err;
    EXPECT_EQ(bytes_of(folder / "a.mkv"), bytes_of(folder / "b.mkv"));
    make("c.mkv", {"--frames", "1-4", "--audio", folder / "a.wav", "--chunk", "1-4"});
    std::ofstream(folder / "a.wav", std::ios::app) << "more";
    const Outcome other = run({"join", folder / "c.mkv", "--quiet"});
    EXPECT_EQ(other.code, 3);
    EXPECT_NE(other.err.find("not the one"), std::string::npos) << other.err;
}

TEST(NumberedJpegs, AreResumedByTheirSizes)
{
    ScratchFolder folder;
    const std::vector<std::string> words{"render",    "builtin:cornell",
                                         "-o",        folder / "new/deep/a-%03d.jpg",
                                         "--frames",  "1-3",
                                         "--size",    "40x30",
                                         "--quality", "80",
                                         "--quiet",   "--json"};
    ASSERT_EQ(run(words).code, 0);
    EXPECT_EQ(names_in(folder / "new/deep"), (std::vector<std::string>{"a-001.jpg", "a-002.jpg", "a-003.jpg"}));
    const std::string before = bytes_of(folder / "new/deep/a-002.jpg");
    EXPECT_EQ(io::read_image(folder / "new/deep/a-002.jpg").width, 40);
    std::ofstream(folder / "new/deep/a-002.jpg") << before.substr(0, before.size() / 2);
    std::vector<std::string> again = words;
    again.push_back("--resume");
    const Outcome outcome = run(again);
    const auto frames = outcome.json()["frames"];
    EXPECT_TRUE(frames[0].value("kept", false));
    EXPECT_FALSE(frames[1].value("kept", false));
    EXPECT_EQ(bytes_of(folder / "new/deep/a-002.jpg"), before);
}

TEST(ExrOutput, TypesCompressionsAndMetadata)
{
    ScratchFolder folder;
    const auto make = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> words{"render",       "builtin:cornell", "-o",      folder / name, "--size",
                                       "48x32",        "--frame",         "7",       "--ids",       "--motion",
                                       "--background", "transparent",     "--quiet", "--samples",   "1"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome outcome = run(words);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
    };
    const auto read = [&](const std::string& name) {
        const std::string bytes = bytes_of(folder / name);
        return io::decode_exr({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, name);
    };
    const auto layer = [](const io::ExrImage& image, const std::string& name) {
        for (const io::ExrLayer& one : image.layers)
            if (one.name == name) return one;
        ADD_FAILURE() << name;
        return io::ExrLayer{};
    };
    make("float.exr", {});
    const io::ExrImage exact = read("float.exr");
    EXPECT_EQ(layer(exact, "").channels, (std::vector<std::string>{"R", "G", "B", "A"}));
    for (const char* compression : {"none", "rle", "zips", "piz", "pxr24"}) {
        make("other.exr", {"--exr-compression", compression});
        const io::ExrImage other = read("other.exr");
        ASSERT_EQ(other.layers.size(), exact.layers.size());
        for (const io::ExrLayer& one : exact.layers) {
            const io::ExrLayer same = layer(other, one.name);
            if (std::string(compression) != "pxr24" || one.name == "id") {
                EXPECT_EQ(same.data, one.data) << compression << one.name;
            }
        }
        EXPECT_TRUE(io::is_whole_exr(folder / "other.exr", {48, 32})) << compression;
    }
    make("half.exr", {"--exr-type", "half"});
    const io::ExrImage half = read("half.exr");
    EXPECT_LT(fs::file_size(folder / "half.exr"), fs::file_size(folder / "float.exr"));
    for (const char* name : {"depth", "motion", "id"}) EXPECT_EQ(layer(half, name).data, layer(exact, name).data);
    const std::vector<float> wide = layer(exact, "").data, narrow = layer(half, "").data;
    bool differs = false;
    for (std::size_t i = 0; i < wide.size(); ++i) {
        EXPECT_NEAR(narrow[i], wide[i], wide[i] / 1024 + 1e-7);
        differs |= narrow[i] != wide[i];
    }
    EXPECT_TRUE(differs);
    const std::string header = bytes_of(folder / "float.exr").substr(0, 4096);
    for (const char* name : {"worldToCamera", "worldToNDC", "framesPerSecond", "chromaticities", "gnomon.frame",
                             "gnomon.time", "gnomon.version", "gnomon.instructionSet"})
        EXPECT_NE(header.find(name), std::string::npos) << name;
}

TEST(Presets, GivenOptionsWin)
{
    ScratchFolder folder;
    const auto samples = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"render", "builtin:cornell", "-o",      folder / "a.png",
                                       "--size", "32x24",           "--quiet", "--json"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome outcome = run(words);
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return bytes_of(folder / "a.png");
    };
    const std::string good = samples({});
    EXPECT_EQ(samples({"--preset", "good"}), good);
    const std::string draft = samples({"--preset", "draft"});
    EXPECT_NE(draft, good);
    EXPECT_EQ(samples({"--samples", "1", "--max-depth", "4"}), draft);
    EXPECT_NE(samples({"--preset", "draft", "--samples", "4"}), draft);
    EXPECT_EQ(samples({"--preset", "best", "--samples", "4", "--filter", "box"}), samples({"--samples", "4"}));
    std::ofstream(folder / "options.json") << R"({"preset": "draft"})";
    EXPECT_EQ(samples({"--config", folder / "options.json"}), draft);
    EXPECT_EQ(run({"render", "builtin:cornell", "-o", folder / "a.png", "--preset", "fast"}).code, 2);
    // What the other renderer or another method has not is no reason to refuse a preset.
    EXPECT_EQ(run({"render", "builtin:cornell", "-o", folder / "b.png", "--preset", "draft", "--indirect", "rsm",
                   "--size", "16x16", "--quiet"})
                  .code,
              0);
}

}   // namespace
}   // namespace gnomon::test
