// SPDX-License-Identifier: Apache-2.0
#include "base/interruption.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/tasks.h"
#include "gnomon/error.h"

namespace gnomon {
namespace {

TEST(Interruption, WithoutOneNothingStops)
{
    EXPECT_EQ(Interruption::current(), nullptr);
    EXPECT_NO_THROW(interruption_point());
    EXPECT_NO_THROW(report_progress("tracing", 0.5));
}

TEST(Interruption, ARequestStopsALoopOnAllThreads)
{
    for (const int threads : {1, 4}) {
        Tasks tasks(threads);
        Interruption interruption;
        const InterruptionScope scope(&interruption);
        std::atomic<int> bodies = 0;
        EXPECT_THROW(tasks.for_each(100'000,
                                    [&](std::size_t, int) {
                                        EXPECT_EQ(Interruption::current(), &interruption);
                                        if (++bodies == 100) interruption.request();
                                    }),
                     InterruptedError);
        EXPECT_GE(bodies, 100);
        EXPECT_LT(bodies, 200);
    }
    EXPECT_EQ(Interruption::current(), nullptr);
}

TEST(Interruption, ARequestOfAnotherThreadStopsABodyAtItsNextPoint)
{
    Interruption interruption;
    const InterruptionScope scope(&interruption);
    std::thread other([&] { interruption.request(); });
    EXPECT_THROW(while (true) interruption_point(), InterruptedError);
    other.join();
}

TEST(Interruption, ProgressIsCalledWithoutReportsAndByOneThreadAtATime)
{
    Tasks tasks(4);
    std::atomic<int> inside = 0, calls = 0;
    bool overlapped = false;
    Interruption interruption([&](const ProgressStep& step) {
        overlapped = overlapped || ++inside > 1;
        EXPECT_EQ(step.stage, "preparing");
        ++calls;
        --inside;
        return true;
    });
    const InterruptionScope scope(&interruption);
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(100);
    tasks.for_each(4, [&](std::size_t, int) {
        while (std::chrono::steady_clock::now() < end) interruption_point();
    });
    EXPECT_FALSE(overlapped);
    EXPECT_GE(calls, 5);
    EXPECT_LE(calls, 51);   // every 2 ms
}

TEST(Interruption, WithinAStageProgressNeverGoesBack)
{
    std::string seen;
    Interruption interruption([&](const ProgressStep& step) {
        seen += std::string(step.stage) + " " + std::to_string(static_cast<int>(10 * step.done)) + ", ";
        return true;
    });
    const InterruptionScope scope(&interruption);
    for (const double done : {0.1, 0.5, 0.3}) report_progress("tracing", done);
    report_progress("encoding", 0.2);
    EXPECT_EQ(seen, "tracing 1, tracing 5, tracing 5, encoding 2, ");
}

TEST(Interruption, ProgressStopsTheWorkByReturningFalseOrByThrowing)
{
    for (const bool throws : {false, true}) {
        Tasks tasks(4);
        Interruption interruption([&](const ProgressStep&) -> bool {
            if (throws) throw std::out_of_range("mine");
            return false;
        });
        const InterruptionScope scope(&interruption);
        const auto work = [&] {
            tasks.for_each(100, [&](std::size_t i, int) { report_progress("tracing", 0.01 * static_cast<double>(i)); });
        };
        if (throws)
            EXPECT_THROW(work(), std::out_of_range);
        else
            EXPECT_THROW(work(), InterruptedError);
    }
}

TEST(Interruption, StopsWithTheOneAround)
{
    Interruption outer;
    const InterruptionScope outer_scope(&outer);
    Interruption inner;
    const InterruptionScope inner_scope(&inner);
    EXPECT_NO_THROW(interruption_point());
    outer.request();
    EXPECT_THROW(interruption_point(), InterruptedError);
}

// Work with grace goes on for that long after a request, and then stops; what throws is what stopped it.
TEST(Interruption, GraceDelaysAStop)
{
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds k_grace{40};
    Interruption outer([](const ProgressStep&) -> bool { throw std::out_of_range("the host's own"); });
    const InterruptionScope scope(&outer);
    Clock::time_point start;
    const auto work = [&] {
        const InterruptionGrace grace(k_grace);
        start = Clock::now();
        Tasks tasks(2);
        tasks.for_each(2, [&](std::size_t, int) {
            while (Clock::now() - start < 10 * k_grace) interruption_point();
        });
    };
    EXPECT_THROW(work(), std::out_of_range);
    EXPECT_GE(Clock::now() - start, k_grace);
    // Short work ends before, and what follows it stops.
    const auto short_work = [&] {
        const InterruptionGrace grace(10 * k_grace);
        interruption_point();
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        interruption_point();
    };
    EXPECT_NO_THROW(short_work());
    EXPECT_THROW(interruption_point(), std::out_of_range);
}

TEST(Interruption, GraceWithoutAnInterruptionDoesNothing)
{
    const InterruptionGrace grace(std::chrono::milliseconds(0));
    EXPECT_NO_THROW(interruption_point());
}

TEST(Interruption, AScopeOfNoneRunsToItsEnd)
{
    Interruption interruption;
    const InterruptionScope scope(&interruption);
    interruption.request();
    {
        const InterruptionScope whole(nullptr);
        EXPECT_NO_THROW(interruption_point());
        Tasks tasks(2);
        EXPECT_NO_THROW(tasks.for_each(100, [](std::size_t, int) { interruption_point(); }));
    }
    EXPECT_THROW(interruption_point(), InterruptedError);
}

}   // namespace
}   // namespace gnomon
