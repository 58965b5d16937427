// SPDX-License-Identifier: Apache-2.0
// --memory from the command line: a frame that needs more is refused with one line and exit code 4, and a limit that
// is kept changes no byte.
#include "run_program.h"

namespace gnomon::test {
namespace {

Outcome make(const std::string& out, const std::string& megabytes, const std::string& scene = "builtin:kinetic")
{
    return run({"render", scene, "-o", out, "--size", "64x48", "--frame", "2", "--memory", megabytes});
}

TEST(MemoryLimitOption, TooLittleEndsWithCode4AndOneLine)
{
    const ScratchFolder folder;
    const Outcome outcome = make(folder / "a.png", "1");
    EXPECT_EQ(outcome.code, 4);
    EXPECT_NE(outcome.err.find("needs more than the limit of 1 MB of memory: the "), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
}

TEST(MemoryLimitOption, ALimitThatIsKeptChangesNoByte)
{
    const ScratchFolder folder;
    for (const char* megabytes : {"0", "1024"}) {
        const Outcome outcome = make(folder / (std::string(megabytes) + ".png"), megabytes, "builtin:cornell");
        ASSERT_EQ(outcome.code, 0) << outcome.err;
    }
    EXPECT_EQ(bytes_of(folder / "0.png"), bytes_of(folder / "1024.png"));
}

TEST(MemoryLimitOption, RefusesValuesOutOfRange)
{
    const ScratchFolder folder;
    for (const char* megabytes : {"-1", "16777217", "much"}) {
        const Outcome outcome = make(folder / "a.png", megabytes);
        EXPECT_EQ(outcome.code, 2) << megabytes;
        EXPECT_NE(outcome.err.find("memory"), std::string::npos) << outcome.err;
    }
}

}   // namespace
}   // namespace gnomon::test
