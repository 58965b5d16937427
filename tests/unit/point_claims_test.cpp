// SPDX-License-Identifier: Apache-2.0
// Claims of cache points by threads: one thread evaluates each point per frame, and the others wait for it without
// hanging, whether it succeeds or fails.
#include "irradiance_cache/points/point_claims.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "irradiance_cache/near_field/near_hints.h"

namespace gnomon::irradiance_cache {
namespace {

constexpr AnchorKey k_first = (1ull << 63) | 7, k_second = (1ull << 63) | 8;

TEST(PointClaims, EachPointIsClaimedOncePerFrame)
{
    PointTable table;
    PointClaims a(table), b(table);
    for (std::uint32_t frame = 1; frame < 3; ++frame) {
        a.begin(frame);
        b.begin(frame);
        CachePoint* const point = a.find_or_create(k_first);
        EXPECT_EQ(b.find_or_create(k_first), point);
        EXPECT_EQ(a.find_or_create(k_first), point);
        ASSERT_EQ(a.claimed().size(), 1u);
        EXPECT_EQ(a.claimed()[0], point);
        EXPECT_TRUE(b.claimed().empty());
        a.publish();
        EXPECT_TRUE(a.claimed().empty());
        b.wait({});
    }
    EXPECT_EQ(table.size(), 1u);
}

TEST(PointClaims, WaitEndsWhenTheOtherThreadPublishes)
{
    PointTable table;
    PointClaims a(table), b(table);
    for (std::uint32_t frame = 1; frame < 200; ++frame) {
        a.begin(frame);
        b.begin(frame);
        CachePoint* const point = a.find_or_create(k_first);
        b.find_or_create(k_first);
        std::thread waiter([&] {
            b.wait({});
            EXPECT_EQ(point->count, frame) << "the evaluation is visible to the waiter";
        });
        point->count = frame;
        a.publish();
        waiter.join();
    }
}

TEST(PointClaims, WaitersFailWithTheFailureOfTheClaimingThread)
{
    PointTable table;
    PointClaims a(table), b(table);
    FrameFailure failure;
    a.begin(1);
    b.begin(1);
    a.find_or_create(k_first);
    b.find_or_create(k_second);
    b.find_or_create(k_first);
    b.publish();
    std::thread waiter([&] { EXPECT_THROW(b.wait(failure), std::domain_error); });
    failure.record(std::make_exception_ptr(std::domain_error("first")));
    failure.record(std::make_exception_ptr(std::runtime_error("second")));
    a.abandon();
    waiter.join();
    // The point can be evaluated again in the next frame.
    a.begin(2);
    b.begin(2);
    a.find_or_create(k_first);
    b.find_or_create(k_first);
    ASSERT_EQ(a.claimed().size(), 1u);
    a.publish();
    b.wait({});
}

TEST(PointClaims, DeferredPointsArePublishedAsTheyAre)
{
    PointTable table;
    PointClaims a(table), b(table);
    a.begin(1);
    b.begin(1);
    CachePoint* const kept = a.find_or_create(k_first);
    a.find_or_create(k_second);
    b.find_or_create(k_second);
    a.defer_if([&](const CachePoint& point) { return point.key == k_second; });
    ASSERT_EQ(a.claimed().size(), 1u);
    EXPECT_EQ(a.claimed()[0], kept);
    b.wait({});
}

TEST(NearHints, WaitersReturnWhenAClaimIsAbandoned)
{
    NearHints hints({.radius = 1});
    ASSERT_EQ(hints.claim(5), NearHints::State::unknown);
    std::thread waiter([&] { EXPECT_EQ(hints.wait(5), NearHints::State::claimed); });
    hints.abandon();
    waiter.join();
}

}   // namespace
}   // namespace gnomon::irradiance_cache
