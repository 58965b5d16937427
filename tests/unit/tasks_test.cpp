// SPDX-License-Identifier: Apache-2.0
#include "base/tasks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "sanitized.h"

namespace gnomon {
namespace {

// None of these tests locks or uses atomics: the ordering that for_each guarantees must suffice, and ThreadSanitizer
// checks it.

TEST(Tasks, EveryIndexRunsOnceAndSeesEarlierLoops)
{
    for (const int threads : {1, 2, 3, 8}) {
        Tasks tasks(threads);
        std::vector<int> before(1000, 0), now(1000, 0);
        for (int loop = 1; loop <= 5; ++loop) {
            // Each body reads a value that another body of the previous loop wrote.
            tasks.for_each(now.size(), [&](std::size_t i, int) { now[i] = before[now.size() - 1 - i] + 1; });
            EXPECT_EQ(now, std::vector<int>(now.size(), loop)) << threads << " threads";
            std::swap(before, now);
        }
    }
}

TEST(Tasks, EachWorkerRunsOneBodyAtATime)
{
    Tasks tasks(4);
    std::vector<std::size_t> sums(4, 0);
    for (int loop = 0; loop < 50; ++loop) {
        tasks.for_each(200, [&](std::size_t i, int worker) {
            ASSERT_GE(worker, 0);
            ASSERT_LT(worker, tasks.threads());
            sums[static_cast<std::size_t>(worker)] += i;
        });
    }
    EXPECT_EQ(std::accumulate(sums.begin(), sums.end(), std::size_t{0}), std::size_t{50} * (199 * 200 / 2));
}

TEST(Tasks, ConcurrentCallersAreIndependent)
{
    Tasks tasks(3);
    std::vector<int> first(500, 0), second(500, 0);
    const auto fill = [&](std::vector<int>& runs) {
        for (int loop = 0; loop < 20; ++loop) tasks.for_each(runs.size(), [&](std::size_t i, int) { ++runs[i]; });
    };
    {
        std::jthread other([&] { fill(second); });
        fill(first);
    }
    EXPECT_EQ(first, std::vector<int>(500, 20));
    EXPECT_EQ(second, first);
}

TEST(Tasks, ExceptionReachesTheCallerAfterFinishedWork)
{
    Tasks tasks(3);
    std::vector<int> runs(64, 0);
    for (int loop = 1; loop <= 20; ++loop) {
        EXPECT_THROW(tasks.for_each(runs.size(),
                                    [&](std::size_t i, int) {
                                        ++runs[i];
                                        if (i == 7) throw std::runtime_error("seven");
                                    }),
                     std::runtime_error);
        EXPECT_EQ(runs[7], loop);
    }
}

#if defined(GNOMON_SANITIZED_THREAD)
// The ordering annotations of for_each and the suppressions for oneTBB must not hide a race between two of its bodies.
template <class Touch>
void race(const Touch& touch)
{
    Tasks tasks(2);
    std::atomic<int> arrived = 0;
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    tasks.for_each(2, [&](std::size_t, int) {
        arrived.fetch_add(1, std::memory_order_relaxed);   // relaxed: orders nothing
        while (arrived.load(std::memory_order_relaxed) < 2 && std::chrono::steady_clock::now() < patience)
            std::this_thread::yield();
        touch();
    });
    std::exit(0);
}

TEST(TasksDeathTest, ThreadSanitizerDetectsRacesBetweenBodies)
{
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    int shared = 0;
    EXPECT_EXIT(race([&] { ++shared; }), testing::ExitedWithCode(66), "ThreadSanitizer: data race");
    // Also through a function of the C library.
    std::vector<char> bytes(4096);
    EXPECT_EXIT(race([&] { std::fill(bytes.begin(), bytes.end(), '\1'); }), testing::ExitedWithCode(66),
                "ThreadSanitizer: data race(.|\n)*memset");
}
#endif

}   // namespace
}   // namespace gnomon
