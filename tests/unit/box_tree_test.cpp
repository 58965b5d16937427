// SPDX-License-Identifier: Apache-2.0
// BoxTree against a linear search of all boxes while they move, appear and vanish; and its cost.
#include "base/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.h"

namespace gnomon {
namespace {

glm::vec3 anywhere(Random& random, float reach)
{
    const float x = random.uniform(-reach, reach), y = random.uniform(-reach, reach);
    return {x, y, random.uniform(-reach, reach)};
}

Box3 random_box(Random& random, float reach, float size)
{
    const glm::vec3 low = anywhere(random, reach);
    return {low, low + glm::abs(anywhere(random, size))};
}

bool overlap(const Box3& a, const Box3& b)
{
    return glm::all(glm::lessThanEqual(a.low, b.high)) && glm::all(glm::lessThanEqual(b.low, a.high));
}

std::vector<std::uint32_t> found_in(const BoxTree& tree, const Box3& query, std::size_t* looked_at = nullptr)
{
    std::vector<std::uint32_t> found;
    const std::size_t count = tree.find([&](const Box3& box) { return overlap(box, query); },
                                        [&](std::uint32_t index) { found.push_back(index); });
    if (looked_at) *looked_at += count;
    std::sort(found.begin(), found.end());
    return found;
}

std::vector<std::uint32_t> found_one_by_one(const std::vector<Box3>& boxes, const Box3& query)
{
    std::vector<std::uint32_t> found;
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
        if (!boxes[i].empty() && overlap(boxes[i], query)) found.push_back(i);
    return found;
}

TEST(BoxTree, EqualsALinearSearchOfAllBoxes)
{
    for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 100u, 1000u}) {
        Random random(count + 1);
        std::vector<Box3> boxes(count);
        for (Box3& box : boxes)
            if (random.below(5) != 0) box = random_box(random, 10, 1);
        BoxTree tree(boxes);
        ASSERT_EQ(tree.size(), count);
        std::size_t sum = 0;
        for (int round = 0; round < 40; ++round) {
            for (int query = 0; query < 20; ++query) {
                const Box3 where = random_box(random, 10, query % 2 ? 1.0f : 6.0f);
                const auto found = found_in(tree, where);
                EXPECT_EQ(found, found_one_by_one(boxes, where));
                sum += found.size();
            }
            for (std::size_t moves = 0; moves < count / 3; ++moves) {
                const std::uint32_t index = random.below(static_cast<std::uint32_t>(count));
                boxes[index] = random.below(6) == 0 ? Box3{} : random_box(random, 10, 1);
                tree.move(index, boxes[index]);
                EXPECT_EQ(tree[index].low, boxes[index].low);
            }
        }
        EXPECT_GE(sum, count >= 7 ? 1u : 0u);
    }
}

TEST(BoxTree, VisitsNearbyNodesOnly)
{
    // Boxes in a square, sixteen times as many each time: a query that finds a few of them visits only a few more
    // nodes.
    for (const int side : {16, 64, 256}) {
        std::vector<Box3> boxes;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const glm::vec3 low(x, y, 0);
                boxes.push_back({low, low + 0.5f});
            }
        const BoxTree tree(boxes);
        const glm::vec3 at(0.4f * static_cast<float>(side), 0.7f * static_cast<float>(side), 0);
        std::size_t looked_at = 0;
        const auto found = found_in(tree, {at, at + 2.2f}, &looked_at);
        EXPECT_GE(found.size(), 4u);
        EXPECT_LE(looked_at, 100u) << side * side << " boxes";
    }
}

TEST(BoxTree, StaysBalancedWhileEverythingMoves)
{
    // Everything starts at one place and ends far apart, one box after the other.
    Random random(3);
    constexpr std::uint32_t k_count = 4096;
    std::vector<Box3> boxes(k_count, Box3{glm::vec3(0), glm::vec3(0.1f)});
    BoxTree tree(boxes);
    for (int round = 0; round < 3; ++round)
        for (std::uint32_t i = 0; i < k_count; ++i) {
            boxes[i] = random_box(random, 100, 1);
            tree.move(i, boxes[i]);
        }
    std::size_t looked_at = 0;
    for (int query = 0; query < 50; ++query) {
        const Box3 where = random_box(random, 90, 2);
        EXPECT_EQ(found_in(tree, where, &looked_at), found_one_by_one(boxes, where));
    }
    EXPECT_LE(looked_at, 50u * 100);
}

}   // namespace
}   // namespace gnomon
