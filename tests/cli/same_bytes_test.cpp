// SPDX-License-Identifier: Apache-2.0
// The same bytes under every instruction set: GNOMON_ISA limits the program to those that this machine has.
#include "run_program.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;

// The instruction sets that this machine can be limited to, from the first to the last.
std::vector<std::string> instruction_sets()
{
    const Outcome devices = run({"devices", "--json"});
    EXPECT_EQ(devices.code, 0) << devices.err;
    const std::string last = devices.json()["cpu"]["instruction_set"];
    std::vector<std::string> sets;
    for (const char* name : {"sse4.2", "avx", "avx2", "avx512"}) {
        sets.emplace_back(name);
        if (last == name) break;
    }
    return sets;
}

// A video in parts, each under another instruction set, and in one run.
void expect_parts_equal_one_run(const std::vector<std::string>& options, int chunks,
                                const std::vector<std::string>& sets)
{
    const ScratchFolder folder;
    const auto make = [&](const std::string& name, const std::vector<std::string>& more, const Environment& variables) {
        std::vector<std::string> all = options;
        all.insert(all.end(), {"-o", folder / name, "--json"});
        all.insert(all.end(), more.begin(), more.end());
        const Outcome outcome = run(all, variables);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        const auto document = outcome.json();
        EXPECT_EQ(document["isa"], "auto");
        if (const auto set = variables.find("GNOMON_ISA"); set != variables.end()) {
            EXPECT_EQ(document["instruction_set"], set->second) << "the limit has no effect";
        }
    };
    make("one.mp4", {"--isa", "auto"}, {});
    for (int i = 1; i <= chunks; ++i)
        make("parts.mp4", {"--isa", "auto", "--chunk", std::to_string(i) + "/" + std::to_string(chunks)},
             {{"GNOMON_ISA", sets[static_cast<std::size_t>(i - 1) % sets.size()]}});
    const auto frames = names_in(folder / "parts.mp4.frames").size();
    const Outcome joined = run([&] {
        std::vector<std::string> all = options;
        all.insert(all.end(), {"-o", folder / "parts.mp4", "--isa", "auto", "--resume", "--json"});
        return all;
    }());
    ASSERT_EQ(joined.code, 0) << joined.err;
    EXPECT_EQ(joined.json()["frames"].size() + 1, frames);
    for (const auto& frame : joined.json()["frames"]) EXPECT_EQ(frame["ms"], 0) << "rendered again: " << frame;
    EXPECT_EQ(bytes_of(folder / "one.mp4"), bytes_of(folder / "parts.mp4"));
}

TEST(SameBytes, VideoOfPartsUnderThreeInstructionSetsEqualsOneRun)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const std::vector<std::string> sets = instruction_sets();
    if (sets.size() < 2) GTEST_SKIP() << "this processor has one instruction set";
    std::vector<std::string> three(sets.end() - static_cast<std::ptrdiff_t>(std::min<std::size_t>(sets.size(), 2)),
                                   sets.end());
    three.insert(three.begin(), sets.front());
    expect_parts_equal_one_run(
        {"render", "builtin:spheres?objects=30&dynamic=20", "--frames", "1-6", "--size", "96x54"}, 3, three);
}

TEST(SameBytesFull, KitchenInSixPartsUnderThreeInstructionSetsEqualsOneRun)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    const std::vector<std::string> sets = instruction_sets();
    if (sets.size() < 2) GTEST_SKIP() << "this processor has one instruction set";
    std::vector<std::string> three(sets.end() - static_cast<std::ptrdiff_t>(std::min<std::size_t>(sets.size(), 2)),
                                   sets.end());
    three.insert(three.begin(), sets.front());
    expect_parts_equal_one_run({"render", file.string(), "--frames", "295-306", "--size", "256x256"}, 6, three);
}

TEST(SameBytes, NativeFramesOfAnotherInstructionSetAreRenderedAgain)
{
    if (!video_tools()) GTEST_SKIP() << "no ffmpeg";
    const std::vector<std::string> sets = instruction_sets();
    if (sets.size() < 2) GTEST_SKIP() << "this processor has one instruction set";
    const ScratchFolder folder;
    const auto arguments = [&](const std::string& name, const std::vector<std::string>& more) {
        std::vector<std::string> all{"render", "builtin:cornell", "-o",    folder / name, "--frames",
                                     "1-4",    "--size",          "33x25", "--isa",       "native"};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    const Environment first{{"GNOMON_ISA", sets.front()}}, last{{"GNOMON_ISA", sets.back()}};
    ASSERT_EQ(run(arguments("whole.mp4", {}), last).code, 0);
    ASSERT_EQ(run(arguments("a.mp4", {"--chunk", "1/2"}), first).code, 0);
    const auto manifest = nlohmann::json::parse(bytes_of(folder / "a.mp4.frames/manifest.json"));
    EXPECT_EQ(manifest["instruction_set"], "native-" + sets.front());

    const Outcome again = run(arguments("a.mp4", {"--resume", "--json"}), last);
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_NE(
        again.err.find("rendered with the instruction set native-" + sets.front() + ", not native-" + sets.back()),
        std::string::npos)
        << again.err;
    for (const auto& frame : again.json()["frames"]) EXPECT_GT(frame["ms"], 0) << "kept: " << frame;
    EXPECT_EQ(bytes_of(folder / "a.mp4"), bytes_of(folder / "whole.mp4"));
}

TEST(SameBytes, UnknownInstructionSetsAreRefused)
{
    expect_failure(run({"devices"}, {{"GNOMON_ISA", "sse9"}}), 2, "GNOMON_ISA=sse9: not an instruction set");
    const std::vector<std::string> sets = instruction_sets();
    if (sets.back() == "avx512") GTEST_SKIP() << "this processor has every instruction set";
    expect_failure(run({"devices"}, {{"GNOMON_ISA", "avx512"}}), 4, "this processor lacks that instruction set");
}

}   // namespace
}   // namespace gnomon::test
