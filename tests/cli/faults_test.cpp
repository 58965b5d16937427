// SPDX-License-Identifier: Apache-2.0
// Failures while the program runs: full disks, files at their size limit, folders that vanish, an encoder that dies,
// signals, too little memory. Each ends with its exit code and one line, leaves no incomplete output, and can be
// resumed.
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include "run_program.h"
#include "sanitized.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;
const std::string k_scene = "builtin:cornell";

// A disk of a few kilobytes in memory, visible to this process and its children only.
class SmallDisk {
 public:
    SmallDisk()
    {
        there_ = ::unshare(CLONE_NEWNS) == 0 && ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                 ::mount("none", folder_.path().c_str(), "tmpfs", 0, "size=1m") == 0;
    }
    ~SmallDisk()
    {
        if (there_) ::umount2(folder_.path().c_str(), MNT_DETACH);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    bool there() const { return there_; }
    void hold(int kilobytes) const
    {
        const std::string size = "size=" + std::to_string(kilobytes) + "k";
        ASSERT_EQ(::mount("none", folder_.path().c_str(), nullptr, MS_REMOUNT, size.c_str()), 0);
    }
    const fs::path& path() const { return folder_.path(); }
    fs::path operator/(const std::string& name) const { return folder_ / name; }

 private:
    ScratchFolder folder_;
    bool there_ = false;
};

// Quiet, because on a slow machine progress lines would precede the one line of a failure.
std::vector<std::string> video(const fs::path& out)
{
    return {"render", k_scene, "-o",         out,   "--frames", "1-12",
            "--size", "64x48", "--indirect", "off", "--resume", "--quiet"};
}

std::string undisturbed_video()
{
    const ScratchFolder folder;
    EXPECT_EQ(run(video(folder / "a.mp4")).code, 0);
    return bytes_of(folder / "a.mp4");
}

// Detected before rendering, or by a write.
void expect_full_disk(const Outcome& outcome)
{
    const bool before = outcome.err.find("the disk has") != std::string::npos;
    expect_failure(outcome, 4, before ? "" : "No space left on device");
}

TEST(Faults, FullDiskFailsTheVideoAndLeavesNoPartOfIt)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const SmallDisk disk;
    if (!disk.there()) GTEST_SKIP() << "no permission to mount a disk";
    const std::string whole = undisturbed_video();
    // Full from the start, while frames are rendered, and while the video is encoded. (The size is in pages.)
    int full = 0, made = 0;
    for (const int kilobytes : {4, 16, 36, 64, 80, 1024}) {
        disk.hold(kilobytes);
        const Outcome outcome = run(video(disk / "a.mp4"));
        if (outcome.code == 0) {
            ++made;
        } else {
            ++full;
            expect_full_disk(outcome);
            EXPECT_FALSE(fs::exists(disk / "a.mp4"));
            disk.hold(1024);
            EXPECT_EQ(run(video(disk / "a.mp4")).code, 0);
        }
        EXPECT_TRUE(bytes_of(disk / "a.mp4") == whole) << kilobytes << " KB";
        EXPECT_EQ(names_in(disk.path()), std::vector<std::string>{"a.mp4"});
        fs::remove(disk / "a.mp4");
    }
    EXPECT_GT(full, 2);
    EXPECT_GT(made, 0);
}

TEST(Faults, FullDiskFailsEveryOtherOutput)
{
    const SmallDisk disk;
    if (!disk.there()) GTEST_SKIP() << "no permission to mount a disk";
    disk.hold(4);
    const ScratchFolder folder;
    for (const char* frame : {"1", "20"})
        ASSERT_EQ(run({"render", k_scene, "-o", folder / (std::string(frame) + ".png"), "--frame", frame}).code, 0);
    const std::vector<std::vector<std::string>> calls = {
        {"render", k_scene, "-o", disk / "a.png", "--size", "200x150", "--quiet"},
        {"render", k_scene, "-o", disk / "a.exr", "--size", "64x48", "--quiet"},
        {"render", k_scene, "-o", disk / "a-{frame}.png", "--size", "200x150", "--frames", "3-5", "--quiet"},
        {"render", k_scene, "-o", folder / "b.png", "--contact-sheet", disk / "s.png", "--size", "200x150", "--quiet"},
        {"render", k_scene, "-o", folder / "c-{frame}.png", "--size", "8x8", "--json=" + (disk / "a.json").string(),
         "--quiet"},
        {"compare", folder / "1.png", folder / "20.png", "--heatmap", disk / "h.png", "--quiet"},
    };
    for (const std::vector<std::string>& call : calls) {
        expect_full_disk(run(call));
        EXPECT_TRUE(names_in(disk.path()).empty()) << testing::PrintToString(call);
    }
}

TEST(Faults, FileSizeLimitFailsTheVideoAndLeavesNoPartOfIt)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    const std::string whole = undisturbed_video();
    for (const rlim_t bytes : {1, 1000, 4000, 1 << 20}) {
        const auto limit = [bytes] {
            const rlimit file{bytes, bytes};
            ::setrlimit(RLIMIT_FSIZE, &file);
        };
        // Standard error is a file as well, and the first of these limits truncates it.
        const Outcome outcome = RunningProgram(video(folder / "a.mp4"), {}, {}, limit).wait();
        EXPECT_EQ(outcome.code, bytes <= 4000 ? 4 : 0) << bytes << ": " << outcome.err;
        EXPECT_EQ(fs::exists(folder / "a.mp4"), outcome.code == 0);
    }
    ASSERT_EQ(run(video(folder / "a.mp4")).code, 0);
    EXPECT_TRUE(bytes_of(folder / "a.mp4") == whole);
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
}

TEST(Faults, VanishedFolderFailsTheRender)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder folder;
    const std::string whole = undisturbed_video();
    fs::create_directory(folder / "there");
    const fs::path frame = folder / "there/a.mp4.frames/frame-000003.png";
    RunningProgram program(video(folder / "there/a.mp4"));
    ASSERT_TRUE(wait_until([&] { return fs::exists(frame); }));
    fs::rename(folder / "there", folder / "gone");
    expect_failure(program.wait(), 4, "No such file or directory");
    EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"gone"});
    ASSERT_EQ(run(video(folder / "gone/a.mp4")).code, 0);
    EXPECT_TRUE(bytes_of(folder / "gone/a.mp4") == whole);
    EXPECT_EQ(names_in(folder / "gone"), std::vector<std::string>{"a.mp4"});

    // A set of images whose folder is deleted.
    fs::create_directory(folder / "set");
    RunningProgram set(
        {"render", k_scene, "-o", folder / "set/{frame}.png", "--size", "64x48", "--frames", "1-40", "--quiet"});
    ASSERT_TRUE(wait_until([&] { return fs::exists(folder / "set/3.png"); }));
    fs::rename(folder / "set", folder / "away");
    expect_failure(set.wait(), 4, "No such file or directory");
    EXPECT_FALSE(fs::exists(folder / "set"));
}

TEST(Faults, DyingEncoderFailsTheVideo)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const std::string whole = undisturbed_video();
    const std::string found = "#!/bin/sh\ncase \"$*\" in *encoder=*) echo Encoder libx264; exit 0;; esac\n";
    const std::string last = "eval out=\\${$#}; out=${out#file:}\n";   // its last argument: the output file
    for (const auto& [script, about] :
         std::map<std::string, std::string>{{"head -c 3000 >$out; kill -9 $$", "signal 9"},
                                            {"head -c 3000 >$out; kill -SEGV $$", "signal 11"},
                                            {"head -c 3000 >$out; echo 'no such codec' >&2; exit 1", "no such codec"},
                                            {"head -c 3000 >$out; exit 0", "ffmpeg could not write"},
                                            {"cat >/dev/null; exit 0", "ffmpeg could not write"}}) {
        const ScratchFolder folder, programs;
        std::ofstream(programs / "ffmpeg") << found << last << script << '\n';
        fs::permissions(programs / "ffmpeg", fs::perms::owner_all);
        expect_failure(run(video(folder / "a.mp4"), {{"PATH", programs.path().string() + ":/usr/bin:/bin"}}), 4, about);
        EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4.frames"});
        EXPECT_EQ(names_in(folder / "a.mp4.frames").size(), 13u) << script;
        EXPECT_EQ(run(video(folder / "a.mp4")).code, 0);
        EXPECT_TRUE(bytes_of(folder / "a.mp4") == whole) << script;
    }
}

// The signal arrives while the scene is loaded, rendered, or encoded: 130, one line, no file, no encoder process left.
TEST(Faults, SignalAtAnyTimeEndsWithCode130AndNoOutput)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const ScratchFolder programs;
    std::ofstream(programs / "ffmpeg") << "#!/bin/sh\ncase \"$*\" in *encoder=*) echo Encoder libx264; exit 0;; esac\n"
                                          "touch $FLAG; exec sleep 60\n";
    fs::permissions(programs / "ffmpeg", fs::perms::owner_all);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        const ScratchFolder folder;
        const std::string flag = folder / "flag";
        RunningProgram encoding(video(folder / "a.mp4"),
                                {{"PATH", programs.path().string() + ":/usr/bin:/bin"}, {"FLAG", flag}});
        ASSERT_TRUE(wait_until([&] { return fs::exists(flag); }));
        encoding.send(signal);
        expect_failure(encoding.wait(), 130, "interrupted");
        EXPECT_EQ(names_in(folder / "a.mp4.frames").size(), 13u) << "frames and manifest are kept, no partial video";
        fs::remove(flag);
        EXPECT_EQ(run(video(folder / "a.mp4")).code, 0);
        EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.mp4"});
    }
    for (const char* out : {"a.exr", "{frame}.png"}) {
        const ScratchFolder folder;
        for (const int milliseconds : {50, 400}) {
            RunningProgram program(
                {"render", "builtin:kinetic", "-o", folder / out, "--size", "2000x2000", "--samples", "64", "--quiet"});
            std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
            program.send(SIGTERM);
            const Outcome outcome = program.wait();
            // Before the handlers are installed, a signal ends the process directly.
            if (outcome.code != -SIGTERM) expect_failure(outcome, 130, "interrupted");
            EXPECT_TRUE(names_in(folder.path()).empty()) << out << " after " << milliseconds << " ms";
        }
    }
}

// From too little memory to start to enough: an image, or one line and no file.
TEST(Faults, TooLittleMemoryIsOneLineAndNoOutput)
{
    if (k_sanitized) GTEST_SKIP() << "sanitizers need address space of their own";
    const ScratchFolder folder;
    int refused = 0, made = 0;
    for (const rlim_t megabytes : {50, 65, 85, 150, 190, 205, 215, 3000}) {
        const auto limit = [megabytes] {
            const rlimit memory{megabytes << 20, megabytes << 20};
            ::setrlimit(RLIMIT_AS, &memory);
        };
        const Outcome outcome =
            RunningProgram({"render", k_scene, "-o", folder / "a.png", "--size", "64x48", "--threads", "2", "--quiet"},
                           {}, {}, limit)
                .wait();
        if (outcome.code == 127) continue;   // refused by the dynamic loader: the program has not started
        if (outcome.code == 0) {
            ++made;
            EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"a.png"});
            fs::remove(folder / "a.png");
            continue;
        }
        ++refused;
        expect_failure(outcome, 4, "memory");
        EXPECT_TRUE(names_in(folder.path()).empty()) << megabytes << " MB";
    }
    EXPECT_GT(refused, 0);
    EXPECT_GT(made, 0);
}

}   // namespace
}   // namespace gnomon::test
