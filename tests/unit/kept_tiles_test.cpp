// SPDX-License-Identifier: Apache-2.0
// A tile is dropped if a changed box may touch one of its camera rays, or a segment from what it shows to a light.
#include <gtest/gtest.h>

#include <random>

#include "scene/builtin/builtin.h"
#include "scene/light_reach.h"
#include "scene/view.h"
#include "trace/kept_tiles.h"

namespace gnomon::trace {
namespace {

constexpr int k_side = 32;

struct Room {
    std::shared_ptr<const scene::Scene> scene = std::make_shared<const scene::Scene>(scene::make_cornell());
    scene::SceneState state{scene, 0};
    scene::View view = scene::make_view(state, 0, {200, 130});
};

struct Segment {
    glm::vec3 from, to;
};

// A tile whose camera rays end at random distances, with these rays and the segments to lights.
struct Example {
    Tile place;
    KeptTile tile;
    std::vector<Segment> segments;

    Example(const Room& room, std::mt19937& random, bool misses)
    {
        const auto pick = [&](float low, float high) {
            return std::uniform_real_distribution<float>(low, high)(random);
        };
        const Size size = room.view.size;
        place = tile_at(static_cast<std::size_t>(pick(0, 34.9f)), (size.width + k_side - 1) / k_side, k_side, size);
        tile.misses = misses;
        tile.blocks.resize(16);
        const float distance = pick(0.5f, 4);
        for (int y = 0; y < place.height; ++y)
            for (int x = 0; x < place.width; ++x) {
                glm::vec3 origin, direction;
                float near, far;
                room.view.ray(static_cast<float>(place.x + x) + 0.5f, static_cast<float>(place.y + y) + 0.5f, origin,
                              direction, near, far);
                if (misses && pick(0, 1) < 0.5f) {
                    segments.push_back({origin, origin + 100.0f * direction});
                    continue;
                }
                const glm::vec3 hit = origin + (distance + pick(0, 0.3f)) * direction;
                tile.blocks[static_cast<std::size_t>(y / 8 * 4 + x / 8)].add(hit);
                segments.push_back({origin, hit});
                const scene::LightReach reach(room.scene->lights[0], room.state.light(0));
                segments.push_back({hit, reach.directional() ? hit + 100.0f * reach.place() : reach.place()});
            }
        for (const Box3& block : tile.blocks) tile.hits.add(block);
    }
    bool meets(const Box3& box) const
    {
        return std::ranges::any_of(segments, [&](const Segment& s) {
            float first = 0, last = 1;
            for (int axis = 0; axis < 3; ++axis) {
                const float way = s.to[axis] - s.from[axis];
                const float a = (box.low[axis] - s.from[axis]) / way, b = (box.high[axis] - s.from[axis]) / way;
                first = std::max(first, std::min(a, b)), last = std::min(last, std::max(a, b));
            }
            return first <= last;
        });
    }
};

void expect_found(const Room& room, bool misses)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<float> aside(-0.5f, 0.5f), half(0.01f, 0.25f), along(0, 1);
    int met = 0, missed = 0, in_vain = 0;
    for (int number = 0; number < 400; ++number) {
        const Example example(room, random, misses);
        // Beside one of its segments.
        const Segment& near = example.segments[random() % example.segments.size()];
        const glm::vec3 centre =
            glm::mix(near.from, near.to, std::min(along(random), 4 / glm::distance(near.from, near.to))) +
            glm::vec3(aside(random), aside(random), aside(random));
        const glm::vec3 size(half(random), half(random), half(random));
        const std::vector<Box3> boxes{{centre - size, centre + size}, Box3{}};   // of an object that appeared
        const bool found = may_change(example.tile, example.place, BoxTree(boxes), room.state, room.view, 0);
        const bool meets = example.meets(boxes[0]);
        EXPECT_TRUE(found || !meets) << number;
        met += meets, missed += !meets, in_vain += found && !meets;
    }
    EXPECT_GT(met, 40);
    EXPECT_GT(missed, 40);
    EXPECT_LT(in_vain, missed / 4);
}

TEST(KeptTile, IsDroppedWhereItsRaysOrShadowsMayChange)
{
    expect_found(Room{}, false);
}

TEST(KeptTile, WithABackgroundIsDroppedByWhatMayComeBeforeIt)
{
    expect_found(Room{}, true);
}

TEST(KeptTile, OfAParallelViewIsDroppedLikewise)
{
    Room room;
    room.view.orthographic = true;
    expect_found(room, false);
}

// Rays to anywhere in a sun's disc.
TEST(KeptTile, IsDroppedWhereASunMayBeHidden)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> pick(-1, 1);
    const auto point = [&] { return glm::vec3(pick(random), pick(random), pick(random)); };
    int met = 0, missed = 0;
    for (int number = 0; number < 3000; ++number) {
        const float radius = 0.15f * (1 + pick(random));
        const glm::vec3 to_light = glm::normalize(point()), origin = point();
        Box3 points, blocker;
        for (int i = 0; i < 3; ++i) points.add(origin + 0.1f * point());
        glm::vec3 s, t;
        make_basis(to_light, s, t);
        const float angle = 3.14159f * pick(random), out = radius * std::sqrt(0.5f * (1 + pick(random)));
        const glm::vec3 direction =
            std::cos(out) * to_light + std::sin(out) * (std::cos(angle) * s + std::sin(angle) * t);
        // Half of the boxes lie on such a ray.
        const glm::vec3 on =
            glm::mix(points.low, points.high, 0.5f * (1.0f + point())) + (2 + pick(random)) * direction;
        const bool meets = number % 2 == 0;
        blocker.add(meets ? on : on + 2.0f * point());
        const bool found = visibility::may_shadow(blocker, points, to_light, radius);
        EXPECT_TRUE(found || !meets) << number;
        met += meets, missed += !found;
    }
    EXPECT_GT(met, 1000);
    EXPECT_GT(missed, 700);
}

TEST(KeptTile, StaysIfNothingChanged)
{
    const Room room;
    std::mt19937 random(3);
    const Example example(room, random, true);
    EXPECT_FALSE(may_change(example.tile, example.place, BoxTree(std::vector<Box3>{}), room.state, room.view, 0));
    EXPECT_FALSE(may_change(example.tile, example.place, BoxTree(std::vector<Box3>(2)), room.state, room.view, 0));
}

struct FakeMemory final : IndirectLight::Remembered {
    explicit FakeMemory(std::size_t of) : size(of) {}
    std::size_t bytes() const override { return size; }
    std::size_t size;
};

// What bounced light remembers counts towards the limit, and an eighth of it is left for that.
TEST(KeptTiles, LimitWhatBouncedLightRemembers)
{
    KeptTiles tiles;
    tiles.limit(1000);
    KeptTile a, b, c;
    tiles.remember(a, std::make_unique<FakeMemory>(600));
    EXPECT_EQ(tiles.bytes(), 600u);
    EXPECT_TRUE(tiles.take());
    tiles.remember(b, std::make_unique<FakeMemory>(300));
    EXPECT_FALSE(tiles.take());
    tiles.remember(a, std::make_unique<FakeMemory>(700));
    EXPECT_EQ(tiles.bytes(), 1000u);
    EXPECT_EQ(a.bounced->bytes(), 700u);
    tiles.remember(c, std::make_unique<FakeMemory>(1));
    EXPECT_FALSE(c.bounced);
    tiles.remember(b, nullptr);
    EXPECT_FALSE(b.bounced);
    EXPECT_EQ(tiles.bytes(), 700u);
    const std::size_t without = KeptTile{}.bytes();
    EXPECT_EQ(a.bytes(), without + 700);
}

}   // namespace
}   // namespace gnomon::trace
