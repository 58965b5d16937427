// SPDX-License-Identifier: Apache-2.0
// --indirect-memory from outside: how much is remembered changes no byte of a picture.
#include "run_program.h"

namespace gnomon::test {
namespace {

Outcome make(const std::string& out, const std::string& megabytes)
{
    return run({"render", "builtin:cornell", "-o", out, "--size", "288x256", "--frames", "5-8", "--indirect-memory",
                megabytes});
}

TEST(IndirectMemory, SameBytesWithTheLeast)
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

TEST(IndirectMemory, OutOfRangeIsUsage)
{
    const ScratchFolder folder;
    for (const char* megabytes : {"0", "65537", "-3", "many"}) {
        const Outcome outcome = make(folder / "none-{frame:04}.png", megabytes);
        EXPECT_EQ(outcome.code, 2) << megabytes;
        EXPECT_NE(outcome.err.find("indirect-memory"), std::string::npos) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(folder / "none-0005.png"));
    }
}

}   // namespace
}   // namespace gnomon::test
