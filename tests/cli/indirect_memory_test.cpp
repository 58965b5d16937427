// SPDX-License-Identifier: Apache-2.0
// --indirect-memory from the command line: the limit changes no byte of an image.
#include <fmt/format.h>

#include <fstream>

#include "run_program.h"
#include "sanitized.h"

namespace gnomon::test {
namespace {

Outcome make(const std::string& out, const std::string& megabytes)
{
    return run({"render", "builtin:cornell", "-o", out, "--size", "288x256", "--frames", "5-8", "--indirect-memory",
                megabytes});
}

TEST(IndirectMemory, SameBytesWithTheSmallestLimit)
{
    const ScratchFolder folder;
    for (const char* megabytes : {"1", "64"}) {
        const Outcome outcome = make(folder / (std::string("of-") + megabytes + "-{frame:04}.exr"), megabytes);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
    }
    for (const char* frame : {"0005.exr", "0006.exr", "0007.exr", "0008.exr"})
        EXPECT_EQ(bytes_of(folder / (std::string("of-1-") + frame)), bytes_of(folder / (std::string("of-64-") + frame)))
            << frame;
}

TEST(IndirectMemory, RefusesValuesOutOfRange)
{
    const ScratchFolder folder;
    for (const char* megabytes : {"0", "65537", "-3", "many"}) {
        const Outcome outcome = make(folder / "none-{frame:04}.png", megabytes);
        EXPECT_EQ(outcome.code, 2) << megabytes;
        EXPECT_NE(outcome.err.find("indirect-memory"), std::string::npos) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "none-0005.png"));
    }
}

// Large triangles around a small bright light: near-field irradiance is cached where it is seen, not on all surfaces.
TEST(IndirectMemory, GrowsWithVisibleSurfacesOnly)
{
    if (k_sanitized) GTEST_SKIP() << "a sanitizer needs memory of its own";
    const ScratchFolder folder;
    constexpr int k_quads = 100;   // per side, of one metre each
    std::string text;
    for (int z = 0; z <= k_quads; ++z)
        for (int x = 0; x <= k_quads; ++x) text += fmt::format("v {} 0 {}\n", x - k_quads / 2, z - k_quads / 2);
    for (int z = 0; z < k_quads; ++z)
        for (int x = 0; x < k_quads; ++x) {
            const int a = z * (k_quads + 1) + x + 1, b = a + k_quads + 1;
            text += fmt::format("f {} {} {} {}\n", a, b, b + 1, a + 1);
        }
    std::ofstream(folder / "grid.obj") << text;
    const Outcome outcome = run({"render", folder / "grid.obj", "-o", folder / "p.png", "--light",
                                 "spot 0.3 0.5 0.3 0 -1 0 5 1 1 1", "--size", "160x90", "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_LT(outcome.json()["peak_memory_bytes"].get<std::uint64_t>(), 200u << 20);
}

}   // namespace
}   // namespace gnomon::test
