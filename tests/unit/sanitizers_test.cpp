// SPDX-License-Identifier: Apache-2.0
// In a build with a sanitizer, the sanitizer ends a process that makes a mistake: without that, runs under it show
// nothing. ThreadSanitizer: tasks_test.cpp.
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>
#include <memory>

#include "sanitized.h"

namespace gnomon {
namespace {

#if defined(GNOMON_SANITIZED) && !defined(GNOMON_SANITIZED_THREAD)

// Values that the compiler cannot know.
template <class T>
T unknown(T value)
{
    volatile T hidden = value;
    return hidden;
}

TEST(SanitizersDeathTest, UseOfFreedMemoryIsFound)
{
    EXPECT_DEATH(
        {
            auto memory = std::make_unique<int[]>(unknown<std::size_t>(8));
            volatile int* const left = memory.get();
            memory.reset();
            std::exit(left[unknown(3)] == 1 ? 1 : 0);
        },
        "AddressSanitizer: heap-use-after-free");
}

TEST(SanitizersDeathTest, ReadingBeyondAnArrayIsFound)
{
    EXPECT_DEATH(
        {
            const auto memory = std::make_unique<int[]>(unknown<std::size_t>(8));
            volatile const int* const begin = memory.get();
            std::exit(begin[unknown(8)] == 1 ? 1 : 0);
        },
        "AddressSanitizer: heap-buffer-overflow");
}

TEST(SanitizersDeathTest, OverflowOfAnIntegerIsFound)
{
    EXPECT_DEATH(
        {
            const int most = unknown(std::numeric_limits<int>::max());
            std::exit(unknown(most + unknown(1)) == 0 ? 1 : 0);
        },
        "runtime error: signed integer overflow");
}

TEST(SanitizersDeathTest, LostMemoryIsFound)
{
    EXPECT_DEATH(
        {
            static int* volatile kept = nullptr;
            for (int i = 0; i < 64; ++i) kept = new int[unknown<std::size_t>(1000)];
            std::exit(kept ? 0 : 1);
        },
        "LeakSanitizer: detected memory leaks");
}

#else

TEST(SanitizersDeathTest, NeedASanitizer)
{
    GTEST_SKIP() << "a build without AddressSanitizer";
}

#endif

}   // namespace
}   // namespace gnomon
