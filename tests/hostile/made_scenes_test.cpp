// SPDX-License-Identifier: Apache-2.0
// Renders hundreds of malformed scenes (made_scenes.h) with all layers, within 10 s of processor time and 512 MB of
// memory. The result is an image with finite values only, or exit code 3 and one line; the full run prints the table.
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <set>

#include "hostile/made_scenes.h"
#include "io/image/exr.h"
#include "run_program.h"
#include "sanitized.h"

namespace gnomon::test {
namespace {

namespace fs = std::filesystem;

constexpr rlim_t k_memory = 512ull << 20;   // bytes of address space
constexpr rlim_t k_seconds = 10 * k_patience;

// Scenes that need more than that memory, and must fail for that reason. A sanitizer, whose memory cannot be limited,
// would render them: one layer per light, gigabytes and hours; five million triangles in one place.
const std::set<std::string> k_beyond_memory{"gltf/100000 lights", "obj/a face of 10 MB", "aff/30000 lights",
                                            "aff/1000000 lights"};

struct Result {
    int code = 0;
    double seconds = 0;
    std::string line;    // its message
    std::string fault;   // empty: as expected
};

void limit()
{
    const rlimit memory{k_memory, k_memory}, time{k_seconds, k_seconds}, core{0, 0};
    if (!k_sanitized) ::setrlimit(RLIMIT_AS, &memory);
    ::setrlimit(RLIMIT_CPU, &time);
    ::setrlimit(RLIMIT_CORE, &core);
}

std::size_t not_finite(const fs::path& exr)
{
    const std::string bytes = bytes_of(exr);
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    std::size_t count = 0;
    for (const io::ExrLayer& layer : io::decode_exr({data, bytes.size()}, exr.string()).layers)
        for (const float value : layer.data) count += !std::isfinite(value);
    return count;
}

double processor_seconds_of_children()
{
    rusage usage{};
    ::getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// What is wrong with how the program ended; empty if it did as expected.
std::string fault_of(Expected expected, const Outcome& outcome, const fs::path& out)
{
    std::string fault;
    const auto lines = std::count(outcome.err.begin(), outcome.err.end(), '\n');
    if (outcome.code == 0) {
        if (const std::size_t count = not_finite(out)) fault = std::to_string(count) + " numbers are not finite";
        if (!outcome.err.empty()) fault = "says something on success";
        if (expected == Expected::refused) fault = "ought to be refused";
    } else if (outcome.code == 3) {
        if (lines != 1 || !outcome.err.starts_with("gnomon: ")) fault = "not one line";
        if (outcome.err.find_first_of("\x1b\x01\t") != std::string::npos) fault = "control characters";
        if (fs::exists(out)) fault = "a file is left";
        if (expected == Expected::image) fault = "ought to be shown";
    } else if (outcome.code == 4 && expected == Expected::either) {
        // More than the allowed memory.
        if (lines != 1 || outcome.err.find("memory") == std::string::npos) fault = "not one line about memory";
        if (fs::exists(out)) fault = "a file is left";
    } else if (outcome.code == 2 && expected == Expected::either) {
        // More lights than an .exr can hold.
        if (lines != 1 || outcome.err.find(" lights; an .exr of ") == std::string::npos)
            fault = "not one line about lights";
        if (fs::exists(out)) fault = "a file is left";
    } else {
        fault = "exit code " + std::to_string(outcome.code);
    }
    return fault;
}

Result render(const MadeScene& scene)
{
    const ScratchFolder folder;
    for (const auto& [name, bytes] : scene.files()) {
        const fs::path file = folder / "scene" / name;
        fs::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << bytes;
    }
    const fs::path out = folder / "out.exr";
    Result result;
    const double before = processor_seconds_of_children();
    const Outcome outcome = RunningProgram({"render", folder / "scene" / scene.main, "-o", out, "--size", "40x30",
                                            "--frame", "1", "--quiet"},
                                           {}, {}, limit)
                                .wait();
    result.seconds = processor_seconds_of_children() - before;
    result.code = outcome.code;
    result.line = outcome.err.substr(0, outcome.err.find('\n'));
    result.fault = fault_of(scene.expected, outcome, out);
    return result;
}

std::string shown(std::string text, std::size_t width)
{
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
    return text.size() <= width ? text : text.substr(0, width - 3) + "...";
}

// Renders every `step`-th scene, the valid one among them.
void render_all(const std::vector<MadeScene>& scenes, std::size_t step, bool table)
{
    int images = 0, refused = 0, no_memory = 0, faults = 0;
    double longest = 0;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        if (i % step != 0) continue;
        if (k_sanitized && k_beyond_memory.contains(scenes[i].name)) {
            std::printf("left out under a sanitizer: %s\n", scenes[i].name.c_str());
            continue;
        }
        const Result result = render(scenes[i]);
        images += result.code == 0, refused += result.code == 3 || result.code == 2, no_memory += result.code == 4,
            faults += !result.fault.empty();
        longest = std::max(longest, result.seconds);
        EXPECT_EQ(result.fault, "") << scenes[i].name << ": " << result.line;
        if (table)
            std::printf(
                "%-64s %-8s %5.2f s  %s\n", shown(scenes[i].name, 64).c_str(),
                result.code == 0                       ? "image"
                : result.code == 3 || result.code == 2 ? "refused"
                : result.fault.empty()                 ? "memory"
                                                       : "FAULT",
                result.seconds,
                shown(result.line.substr(0, 8) == "gnomon: " ? result.line.substr(8) : result.line, 90).c_str());
    }
    std::printf("%d images, %d refused, %d out of memory, %d faults; the longest %.2f s\n", images, refused, no_memory,
                faults, longest);
}

// Each kind of fault that the tests below look for is found.
TEST(MadeScenes, FaultsAreFound)
{
    const ScratchFolder folder;
    const fs::path out = folder / "out.exr", none = folder / "none.exr";
    const auto write = [&](float value) {
        const std::vector<io::ExrLayer> layers{{"", {"R", "G", "B"}, {0, 1, value}}};
        io::write_exr(out, {1, 1}, layers);
    };
    const Outcome done{0, "", ""}, refused{3, "", "gnomon: a.gltf: no\n"}, memory{4, "", "gnomon: no memory\n"};
    write(2);
    EXPECT_EQ(fault_of(Expected::image, done, out), "");
    EXPECT_EQ(fault_of(Expected::refused, done, out), "ought to be refused");
    EXPECT_EQ(fault_of(Expected::image, {0, "", "warning\n"}, out), "says something on success");
    EXPECT_EQ(fault_of(Expected::refused, refused, out), "a file is left");
    for (const float value : {std::nanf(""), HUGE_VALF}) {
        write(value);
        EXPECT_EQ(fault_of(Expected::image, done, out), "1 numbers are not finite");
    }
    EXPECT_EQ(fault_of(Expected::refused, refused, none), "");
    EXPECT_EQ(fault_of(Expected::either, memory, none), "");
    EXPECT_EQ(fault_of(Expected::image, refused, none), "ought to be shown");
    EXPECT_EQ(fault_of(Expected::refused, {3, "", "gnomon: a\nb\n"}, none), "not one line");
    EXPECT_EQ(fault_of(Expected::refused, {3, "", "gnomon: \x1b[2J\n"}, none), "control characters");
    EXPECT_EQ(fault_of(Expected::either, {4, "", "gnomon: no driver\n"}, none), "not one line about memory");
    EXPECT_EQ(fault_of(Expected::image, memory, none), "exit code 4");
    EXPECT_EQ(fault_of(Expected::either, {-SIGSEGV, "", ""}, none), "exit code -11");
}

TEST(MadeScenes, SampleOfGltfRendersOrIsRefused)
{
    render_all(made_gltf_scenes(), 13, false);
}
TEST(MadeScenes, SampleOfObjRendersOrIsRefused)
{
    render_all(made_obj_scenes(), 13, false);
}
TEST(MadeScenes, SampleOfAffRendersOrIsRefused)
{
    render_all(made_aff_scenes(), 13, false);
}

TEST(MadeScenesFull, AllGltfRenderOrAreRefused)
{
    render_all(made_gltf_scenes(), 1, true);
}
TEST(MadeScenesFull, AllObjRenderOrAreRefused)
{
    render_all(made_obj_scenes(), 1, true);
}
TEST(MadeScenesFull, AllAffRenderOrAreRefused)
{
    render_all(made_aff_scenes(), 1, true);
}

}   // namespace
}   // namespace gnomon::test
