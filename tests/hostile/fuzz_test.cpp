// SPDX-License-Identifier: Apache-2.0
// The seeds of fuzzing are accepted, and inputs that once failed are refused or read as they should be.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "base/random.h"
#include "fuzz/targets.h"

namespace gnomon::fuzz {
namespace {

class FuzzTarget : public testing::TestWithParam<Target> {};

TEST_P(FuzzTarget, AcceptsSeeds)
{
    int number = 0;
    for (const Bytes& seed : GetParam().seeds()) {
        EXPECT_EQ(GetParam().run(seed), "") << "seed " << number;
        ++number;
    }
}

TEST_P(FuzzTarget, ReadsOrRefusesChangedSeeds)
{
    Random random(5);
    int refused = 0;
    for (const Bytes& seed : GetParam().seeds())
        for (int round = 0; round < 40; ++round) {
            Bytes bytes = seed;
            for (std::uint32_t i = 0; i <= random.below(3); ++i)
                bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] =
                    static_cast<std::uint8_t>(random.below(256));
            if (GetParam().repair) GetParam().repair(bytes);
            refused += !GetParam().run(bytes).empty();
        }
    EXPECT_GT(refused, 0);
}

// --- Regressions found by fuzzing

std::string outcome(const char* target, const std::string& bytes)
{
    return find_target(target)->run(Bytes(bytes.begin(), bytes.end()));
}

TEST(FuzzRegression, WarningsHaveNoControlCharacters)
{
    EXPECT_EQ(outcome("aff", "f 1 1 1 1 0 1 0 1\nx i\x1b[31m { p 3 0 0 0 1 0 0 0 1 0 }"), "");
}

TEST(FuzzRegression, ClaimedPngChunkSizesAllocateNoMemory)
{
    // A chunk of 1.4 GB of Exif without data: libpng would have allocated the memory first.
    const std::string header("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x09\0\0\0\x05\x08\x02\0\0\0\x18\x31\x51\x3c", 33);
    const std::string chunk("\x55\0\0\x19\x65XIf\xca\x79\x97\x04", 12);
    for (const std::size_t size : {8u, 11u, 12u})
        EXPECT_EQ(outcome("png", header + chunk.substr(0, size)),
                  "input:byte 33: a PNG chunk needs 1426063385 bytes and a checksum, but " + std::to_string(size - 8) +
                      " bytes are left");
}

TEST(FuzzRegression, RefusesOverflowingNumbersInConfigFiles)
{
    EXPECT_NE(outcome("config", std::string("\0{\"out\":2e308}", 14)),
              "");   // valid in JSON, but out of range for a double
}

TEST(FuzzRegression, RefusesARepeatedOptionWithoutAValue)
{
    EXPECT_NE(outcome("options", "bench\nshadow-textures\n--objects\n--objects\n3"), "");   // this was an endless loop
}

// What a process leaves behind that ends in the middle is removed by the next one.
TEST(FuzzFolders, OfEndedProcessesAreRemoved)
{
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        outcome("ply", "ply");
        outcome("gltf", "{}");
        _exit(9);   // destructors do not run
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    const auto left = [&] {
        int count = 0;
        for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
            count += entry.path().filename().string().starts_with("gnomon-fuzz-" + std::to_string(child) + "-") ? 1 : 0;
        return count;
    };
    EXPECT_EQ(left(), 1);
    remove_left_folders();
    EXPECT_EQ(left(), 0);
}

INSTANTIATE_TEST_SUITE_P(Each, FuzzTarget, testing::ValuesIn(targets().begin(), targets().end()),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

}   // namespace
}   // namespace gnomon::fuzz
