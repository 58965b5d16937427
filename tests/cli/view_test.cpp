// SPDX-License-Identifier: Apache-2.0
// The viewer in a real window with real input.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "io/image/image_file.h"
#include "run_program.h"
#include "two_clips.h"
#include "video/process.h"

namespace gnomon::test {
namespace {

#ifdef GNOMON_VIEWER

// Skips the test if Xvfb or xdotool is missing.
#define NEED_WINDOWS()                                                                             \
    if (std::system("command -v Xvfb >/dev/null 2>&1 && command -v xdotool >/dev/null 2>&1") != 0) \
    GTEST_SKIP() << "no Xvfb or no xdotool on this machine: install the Debian packages xvfb and xdotool"

// Skips the test if no device of this machine can rasterise. With one, exit code 4 of the program is a fault.
#define NEED_DEVICE() \
    if (!has_device()) GTEST_SKIP() << "no suitable Vulkan device on this machine"

bool has_device()
{
    const nlohmann::json vulkan = run({"devices", "--json"}).json()["vulkan"];
    return std::ranges::any_of(vulkan["devices"],
                               [](const nlohmann::json& device) { return device["suitable"] == true; });
}

// The panel stands at the window's left and is 286 pixels wide; --size is that of the view beside it.
struct Seen {
    int code = -1;
    nlohmann::json json;
    std::string err;
};

Seen drive(const ScratchFolder& folder, const std::string& scene, const std::string& more, const std::string& steps,
           const std::string& size = "320x240")
{
    std::ofstream(folder / "steps") << steps;
    const std::string at = std::filesystem::path(folder / "").string();
    const std::string command = places::source_folder + "/tests/cli/drive_window.sh '" + at + "' " + places::program +
                                " view '" + scene + "' --size " + size + " --json=seen.json " + more + " < '" + at +
                                "/steps' > /dev/null 2> '" + at + "/err'";
    const int status = std::system(command.c_str());
    Seen seen{WIFEXITED(status) ? WEXITSTATUS(status) : -1, {}, bytes_of(folder / "err")};
    if (std::filesystem::exists(folder / "seen.json"))
        seen.json = nlohmann::json::parse(bytes_of(folder / "seen.json"));
    return seen;
}

TEST(View, ScreenshotEqualsTheRenderedImageAfterAnyInteraction)
{
    NEED_WINDOWS();
    const ScratchFolder folder;
    // Play, rotate, approach, fly, pick, panels, overlays, other sizes; then the scene's own camera and the first
    // frame.
    const Seen seen = drive(folder, "builtin:cornell", "",
                            "sleep 1\nmousemove 536 200\nmousedown 1\nmousemove 486 180\nmousemove 436 170\nmouseup 1\n"
                            "click 4\nclick 5\nkey w\nkey d\nclick 1\nsleep 0.5\nkey f\nkey o\nsleep 0.5\nkey o\n"
                            "key h\nkey h\nkey Tab\nkey space\nkey Right\nkey Left\nresize 400 200\nsleep 0.5\n"
                            "resize 320 240\nsleep 0.5\nkey c\nkey Home\nsleep 0.3\nkey p\nawait gnomon-0001.png\n"
                            "shot screen.png\nkey Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    EXPECT_EQ(seen.err, "");
    EXPECT_EQ(seen.json.at("files"), nlohmann::json::array({"gnomon-0001.png"}));
    EXPECT_GT(seen.json.at("pictures"), 5);
    EXPECT_EQ(seen.json.at("loads"), 1);
    const Outcome rendered = run({"render", "builtin:cornell", "--frame", "1", "--size", "320x240", "--samples", "1",
                                  "-o", folder / "render.png"});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    const Image8 shot = io::read_image(folder / "gnomon-0001.png"), truth = io::read_image(folder / "render.png");
    EXPECT_EQ(shot.width, 320);
    EXPECT_EQ(shot.data, truth.data);
    // Check the right half of the window, whose panel is hidden.
    const Image8 screen = io::read_image(folder / "screen.png");
    int near = 0;
    for (int y = 60; y < 180; ++y)
        for (int x = 200; x < 310; ++x)
            near += std::abs(static_cast<int>(screen.pixel(x, y)[1]) - static_cast<int>(truth.pixel(x, y)[1])) < 24;
    EXPECT_GT(near, 120 * 110 * 8 / 10);
}

// Drags of the handles at the picked object; Escape during a drag puts the object back.
TEST(View, HandlesMoveThePickedObject)
{
    NEED_WINDOWS();
    const ScratchFolder folder;
    // Screenshots wait for the first image, and for the one in which the ball is picked.
    const std::string begin =
        "sleep 1\nkey space\nkey Home\nkey Tab\nresize 800 600\nsleep 0.5\nkey p\nawait gnomon-0001.png\nmousemove 300 "
        "270\nclick 1\nkey p\nawait "
        "gnomon-0002.png\n"
        "mousemove 304 230\nmousedown 1\nmousemove 304 200\nmousemove 304 150\nsleep 0.5\n";
    const Seen moved = drive(folder, "builtin:cornell", "",
                             begin + "mouseup 1\nsleep 1\nkey p\nawait gnomon-0003.png\nkey Escape\n", "800x600");
    ASSERT_EQ(moved.code, 0) << moved.err;
    EXPECT_EQ(moved.json.at("frozen"), nlohmann::json::array({"ball"}));
    EXPECT_EQ(moved.json.at("moved"), nlohmann::json::array({"ball"}));
    const ScratchFolder other;
    const Seen cancelled =
        drive(other, "builtin:cornell", "",
              begin + "key Escape\nmouseup 1\nsleep 1\nkey p\nawait gnomon-0003.png\nkey Escape\n", "800x600");
    ASSERT_EQ(cancelled.code, 0) << cancelled.err;
    const Outcome rendered = run({"render", "builtin:cornell", "--frame", "1", "--size", "800x600", "--samples", "1",
                                  "-o", folder / "render.png"});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    const Image8 up = io::read_image(folder / "gnomon-0003.png"), back = io::read_image(other / "gnomon-0003.png");
    EXPECT_EQ(back.data, io::read_image(folder / "render.png").data);
    // The ball is 80 pixels higher.
    const auto is_ball = [](const Image8& image, int x, int y) {
        const std::uint8_t* const p = image.pixel(x, y);
        return p[2] > p[0] + 40;
    };
    EXPECT_TRUE(is_ball(back, 310, 270));
    EXPECT_FALSE(is_ball(up, 310, 300));
    EXPECT_TRUE(is_ball(up, 310, 190));
}

TEST(View, ShowsTheRasterisedFrame)
{
    NEED_WINDOWS();
    NEED_DEVICE();
    const ScratchFolder folder;
    const Seen seen = drive(folder, "builtin:cornell", "--renderer raster",
                            "sleep 2\nmousemove 536 200\nclick 1\nkey c\nkey Home\nsleep 0.5\nkey p\n"
                            "await gnomon-0001.png\nkey Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    const Outcome rendered = run({"render", "builtin:cornell", "--frame", "1", "--size", "320x240", "--renderer",
                                  "raster", "--samples", "1", "-o", folder / "render.png"});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    EXPECT_EQ(io::read_image(folder / "gnomon-0001.png").data, io::read_image(folder / "render.png").data);
}

// The texels that a step redrew in the light views are shown, and stay while the image of that moment is refined.
TEST(View, ShowsRedrawnTexels)
{
    NEED_WINDOWS();
    NEED_DEVICE();
    const ScratchFolder folder;
    const Seen seen =
        drive(folder, "builtin:cornell", "--renderer raster --overlay redrawn",
              "sleep 1\nkey Home\nkey p\nawait gnomon-0001.png\nkey Right\nkey p\nawait gnomon-0002.png\nkey "
              "o\nkey p\nawait gnomon-0003.png\nkey Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    const Outcome rendered =
        run({"render", "builtin:cornell", "--frames", "1-2", "--size", "320x240", "--renderer", "raster", "--overlay",
             "redrawn", "--exposure", "auto-frame", "-o", folder / "redrawn-{frame:04}.png"});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    // The ball is red in both images. The area that it left equals the previous frames, which are the window's own.
    const Image8 shown = io::read_image(folder / "gnomon-0002.png"),
                 truth = io::read_image(folder / "redrawn-0002.png");
    ASSERT_EQ(shown.data.size(), truth.data.size());
    const auto red = [](const std::uint8_t* p) { return p[0] > 100 && 3 * p[1] < 2 * p[0] && 2 * p[2] < p[0]; };
    int reds = 0, others = 0;
    for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x) {
            const std::uint8_t *a = shown.pixel(x, y), *b = truth.pixel(x, y);
            reds += red(b);
            others += red(a) != red(b) || (red(b) && !std::equal(a, a + 3, b));
        }
    EXPECT_GT(reds, 50);
    EXPECT_LT(reds, 2000);
    EXPECT_EQ(others, 0);
    const Outcome plain = run({"render", "builtin:cornell", "--frame", "2", "--size", "320x240", "--renderer", "raster",
                               "--samples", "1", "-o", folder / "plain.png"});
    ASSERT_EQ(plain.code, 0) << plain.err;
    EXPECT_EQ(io::read_image(folder / "gnomon-0003.png").data, io::read_image(folder / "plain.png").data);
}

// Every frame is recorded once, in order, in full size, fully refined, and with the exposure of the first: the bytes
// equal the rendered video, whatever was shown when the recording started and whatever happens to the window.
TEST(View, RecordingEqualsTheRenderedVideo)
{
    NEED_WINDOWS();
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    // The frames from the 28th on have another exposure than the first ones. There are more of them than will be
    // recorded: the clip starts again at its end.
    constexpr int k_first = 25;
    const Seen seen =
        drive(folder, "builtin:cornell", "--fps 120",
              "sleep 1\nkey space\nkey Home\nkey --repeat 24 Right\nkey r\nsleep 2\nresize 400 200\nsleep 2\nkey r\n"
              "await gnomon-0001.mp4\nkey Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    const std::string video = folder / "gnomon-0001.mp4";
    EXPECT_EQ(seen.json.at("files"), nlohmann::json::array({"gnomon-0001.mp4"}));
    video::Process ffprobe({"ffprobe", "-v", "error", "-count_frames", "-show_entries",
                            "stream=width,height,nb_read_frames", "-of", "csv=p=0", video});
    ASSERT_EQ(ffprobe.wait(), 0) << ffprobe.errors();
    int width = 0, height = 0, frames = 0;
    ASSERT_EQ(std::sscanf(ffprobe.output().c_str(), "%d,%d,%d", &width, &height, &frames), 3) << ffprobe.output();
    EXPECT_EQ(width, 320);
    EXPECT_EQ(height, 240);
    ASSERT_GE(frames, 5);
    const Outcome first = run({"render", "builtin:cornell", "--fps", "120", "--frame", fmt::format("{}", k_first),
                               "--size", "320x240", "--samples", "1", "--json", "-o", folder / "first.png"});
    ASSERT_EQ(first.code, 0) << first.err;
    const double exposure = first.json().at("frames").at(0).at("exposure");
    const Outcome rendered = run({"render", "builtin:cornell", "--fps", "120", "--frames",
                                  fmt::format("{}-{}", k_first, k_first + frames - 1), "--size", "320x240", "--samples",
                                  "1", "--exposure", fmt::format("{}", exposure), "-o", folder / "rendered.mp4"});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    // The comment of a rendered video says what it was rendered from; that of a recording cannot.
    const auto stream_of = [&](const std::string& file) {
        video::Process ffmpeg(
            {"ffmpeg", "-v", "error", "-i", file, "-map", "0:v", "-c", "copy", "-f", "h264", file + ".h264"});
        EXPECT_EQ(ffmpeg.wait(), 0) << ffmpeg.errors();
        return bytes_of(file + ".h264");
    };
    const auto recorded = stream_of(video);
    EXPECT_GT(recorded.size(), 1000u);
    EXPECT_TRUE(recorded == stream_of(folder / "rendered.mp4")) << frames << " frames";
}

TEST(View, FailingFrameEndsTheRecordingAndKeepsTheVideo)
{
    NEED_WINDOWS();
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    const ScopedVariable none("VK_DRIVER_FILES", "/nowhere.json"), none_either("VK_ICD_FILENAMES", "/nowhere.json");
    // The panel's first option is the renderer; its second choice needs a driver.
    const Seen seen = drive(folder, "builtin:cornell", "--indirect off",
                            "sleep 1\nkey Home\nkey r\nsleep 1\nmousemove 150 348\nclick 1\nsleep 0.5\n"
                            "mousemove 60 371\nclick 1\nsleep 0.5\nmousemove 60 416\nclick 1\n"
                            "await gnomon-0001.mp4\nkey Escape\n",
                            "400x500");
    ASSERT_EQ(seen.code, 0) << seen.err;
    EXPECT_EQ(seen.json.at("options_set"), nlohmann::json::array({"renderer"}));
    EXPECT_EQ(seen.json.at("files"), nlohmann::json::array({"gnomon-0001.mp4"}));
    EXPECT_GT(std::filesystem::file_size(folder / "gnomon-0001.mp4"), 1000u);
}

// The list of clips below the player loads the file again with the one that is chosen.
TEST(View, AClipIsChosenFromTheList)
{
    NEED_WINDOWS();
    const ScratchFolder folder;
    write_two_clips(folder / "two.gltf");
    const Seen seen = drive(folder, "two.gltf", "",
                            "sleep 6\nmousemove 90 83\nclick 1\nsleep 2\nmousemove 60 141\nclick 1\nsleep 3\n"
                            "mousemove 350 300\nkey Home\nkey Right\nkey Right\nkey Right\nsleep 0.5\nkey p\n"
                            "await gnomon-0001.png\nkey Escape\n",
                            "400x500");
    ASSERT_EQ(seen.code, 0) << seen.err;
    EXPECT_EQ(seen.json.at("options_set"), nlohmann::json::array({"animation"}));
    EXPECT_EQ(seen.json.at("loads"), 2);
    const auto rendered = [&](const std::string& clip) {
        const std::string out = folder / "render.png";
        const Outcome outcome = run({"render", folder / "two.gltf", "--animation", clip, "--frame", "4", "--size",
                                     "400x500", "--samples", "1", "-o", out});
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        return io::read_image(out).data;
    };
    const auto shot = io::read_image(folder / "gnomon-0001.png").data;
    EXPECT_EQ(shot, rendered("jump"));
    EXPECT_NE(shot, rendered("walk"));
}

// The list of cameras shows the frame through the one that is chosen, also after the view was turned. What was asked
// for is shown, and the summary says how soon.
TEST(View, ACameraIsChosenFromTheList)
{
    NEED_WINDOWS();
    const ScratchFolder folder;
    write_two_clips(folder / "two.gltf");
    std::string text = bytes_of(folder / "two.gltf");
    text.replace(text.find("[0,1]"), 5, "[0,1,2]");
    text.replace(text.find("[0,0,6]}"), 8, R"([0,0,6]},{"camera":0,"translation":[1,0,4]})");
    std::ofstream(folder / "two.gltf") << text;
    const Seen seen = drive(folder, "two.gltf", "",
                            "sleep 6\nmousemove 380 300\nmousedown 1\nmousemove 370 320\nmousemove 360 350\nmouseup 1\n"
                            "sleep 3\nmousemove 90 106\nclick 1\nsleep 2\nmousemove 60 164\nclick 1\nsleep 2\n"
                            "mousemove 350 300\nkey Home\nsleep 0.5\nkey p\nawait gnomon-0001.png\nkey Escape\n",
                            "400x500");
    ASSERT_EQ(seen.code, 0) << seen.err;
    EXPECT_EQ(seen.json.at("options_set"), nlohmann::json::array({"camera"}));
    EXPECT_EQ(seen.json.at("loads"), 1);
    EXPECT_GE(seen.json.at("inputs"), 1);
    EXPECT_GT(seen.json.at("median_latency_ms"), 0);
    EXPECT_GE(seen.json.at("longest_latency_ms"), seen.json.at("median_latency_ms"));
    EXPECT_GE(seen.json.at("longest_rendered_latency_ms"), seen.json.at("longest_latency_ms"));
    const Outcome rendered = run({"render", folder / "two.gltf", "--camera", "1", "--frame", "1", "--size", "400x500",
                                  "--samples", "1", "-o", folder / "render.png"});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    EXPECT_EQ(io::read_image(folder / "gnomon-0001.png").data, io::read_image(folder / "render.png").data);
}

// A key for a side moves the camera until all of a long object is shown, wherever it was before.
TEST(View, AKeyForASideShowsAllOfALongObject)
{
    NEED_WINDOWS();
    const ScratchFolder folder;
    std::ofstream(folder / "long.obj") << "v 5 0 0\nv 65 0 0\nv 65 2 0\nv 5 2 0\nf 1 2 3 4\n";
    const Seen seen =
        drive(folder, "long.obj", "--background '#f0f' --ground off",
              "sleep 1\nkey p\nawait gnomon-0001.png\nmousemove 440 120\nclick 4\nclick 4\nclick 4\nclick "
              "4\nclick 4\nclick 4\nkey d\nkey 1\nsleep 0.5\nkey p\nawait gnomon-0002.png\nkey Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    const Image8 shot = io::read_image(folder / "gnomon-0002.png");
    std::vector<int> columns;   // that show it in the middle row
    for (int x = 0; x < shot.width; ++x)
        if (shot.pixel(x, shot.height / 2)[1] > 20) columns.push_back(x);
    ASSERT_FALSE(columns.empty());
    EXPECT_EQ(columns.back() - columns.front() + 1, static_cast<int>(columns.size()));
    EXPECT_GE(columns.front(), shot.width / 50);
    EXPECT_LE(columns.back(), shot.width - 1 - shot.width / 50);
    EXPECT_GT(static_cast<int>(columns.size()), shot.width * 8 / 10);
}

TEST(View, ReloadsAChangedFile)
{
    NEED_WINDOWS();
    const ScratchFolder folder;
    const auto write = [&](const char* name, int size) {
        std::ofstream(folder / name) << "v 0 0 0\nv " << size << " 0 0\nv 0 " << size << " 0\nf 1 2 3\n";
    };
    write("a.obj", 1);
    std::jthread later([&] {
        wait_until([&] { return std::filesystem::exists(folder / "gnomon-0001.png"); });
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        write("a.obj", 2);
    });
    const Seen seen = drive(folder, "a.obj", "",
                            "sleep 1\nkey p\nawait gnomon-0001.png\nsleep 3\nkey p\nawait gnomon-0002.png\nkey "
                            "Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    EXPECT_EQ(seen.json.at("loads"), 2);
}

// A recording never contains two scenes: it ends with its own.
TEST(View, RecordingEndsWhenAnotherSceneIsLoaded)
{
    NEED_WINDOWS();
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    const auto write = [&](int size) {
        std::ofstream(folder / "a.obj") << "v 0 0 0\nv " << size << " 0 0\nv 0 " << size << " 0\nf 1 2 3\n";
    };
    write(1);
    std::jthread later([&] {
        wait_until([&] { return std::filesystem::exists(folder / "gnomon-0002.png"); });
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
        write(2);
    });
    // The first screenshot shows that the scene is loaded, the second that it is being recorded.
    const Seen seen = drive(folder, "a.obj", "",
                            "sleep 1\nkey p\nawait gnomon-0001.png\nkey r\nsleep 0.2\nkey p\nawait gnomon-0002.png\n"
                            "await gnomon-0001.mp4\nkey Escape\n");
    ASSERT_EQ(seen.code, 0) << seen.err;
    EXPECT_EQ(seen.json.at("loads"), 2);
}

TEST(View, FailureIsAnExitCodeAndOneLine)
{
    expect_failure(run({"view", "builtin:cornell"}, {{"DISPLAY", ":none"}, {"WAYLAND_DISPLAY", "none"}}), 4,
                   "cannot open a window");
    // A scene alone is shown; a word that is neither is still no subcommand.
    expect_failure(run({"builtin:cornell"}, {{"DISPLAY", ":none"}, {"WAYLAND_DISPLAY", "none"}}), 4,
                   "cannot open a window");
    expect_failure(run({"missing.gltf"}), 2, "no subcommand 'missing.gltf'");
    NEED_WINDOWS();
    const ScratchFolder folder;
    const Seen seen = drive(folder, "missing.gltf", "", "");
    EXPECT_EQ(seen.code, 3);
    EXPECT_NE(seen.err.find("missing.gltf"), std::string::npos) << seen.err;
    const Seen camera = drive(folder, "builtin:cornell", "--camera nave", "");
    EXPECT_EQ(camera.code, 2);
    EXPECT_EQ(camera.err, "gnomon: no camera 'nave': the scene has 1, numbered from 0\n");
}

#else

TEST(View, ReportsBuildWithoutViewer)
{
    expect_failure(run({"view", "builtin:cornell"}), 4, "without a window");
}

#endif

}   // namespace
}   // namespace gnomon::test
