// SPDX-License-Identifier: Apache-2.0
// Which cache points are dropped when their table is full.
#include "irradiance_cache/points/point_table.h"

#include <gtest/gtest.h>

namespace gnomon::irradiance_cache {
namespace {

constexpr int k_points = 1000;   // of each frame

// A table with the points of frames 1 to `frames`, of which each saw others.
std::unique_ptr<PointTable> table_of(int frames)
{
    auto table = std::make_unique<PointTable>();
    for (int frame = 1; frame <= frames; ++frame)
        for (int i = 0; i < k_points; ++i)
            table->find_or_create(static_cast<AnchorKey>(frame * k_points + i)).ready =
                static_cast<std::uint32_t>(frame);
    return table;
}

std::size_t left(int frames, const PointTable::Memory& memory)
{
    const auto table = table_of(frames);
    std::size_t count = 0;
    table->drop_unseen(static_cast<std::uint32_t>(frames), memory, [&](const CachePoint& point) {
        EXPECT_LT(point.ready.load(), static_cast<std::uint32_t>(frames)) << "the last frame's points stay";
        ++count;
    });
    EXPECT_EQ(table->size() + count, static_cast<std::size_t>(frames * k_points));
    return table->size();
}

TEST(PointTable, KeepsTwiceAFramesPointsAndFourTimesWhereMemoryIsAmple)
{
    constexpr std::size_t k_frame = k_points * sizeof(CachePoint);
    // Three frames are more than twice the last one, and less than four times.
    EXPECT_EQ(left(3, {0, 8 * k_frame}), 3u * k_points);
    EXPECT_EQ(left(3, {0, 0}), 1u * k_points);
    EXPECT_EQ(left(3, {0, 2 * k_frame}), 1u * k_points);
    // A quarter of four times is free again.
    EXPECT_EQ(left(6, {0, 8 * k_frame}), 2u * k_points);
    // Memory that was asked for is used in any case.
    EXPECT_EQ(left(6, {8 * k_frame, 0}), 6u * k_points);
}

}   // namespace
}   // namespace gnomon::irradiance_cache
