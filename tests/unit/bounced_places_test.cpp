// SPDX-License-Identifier: Apache-2.0
// Places that share the bounced light of what mirrors show.
#include "trace/bounced_places.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace gnomon::trace {
namespace {

constexpr float k_width = 0.01f;
const float k_reach = BouncedPlacesOptions{}.reach * k_width;

BouncedPlace place_at(const glm::vec3& position, float light = 1)
{
    BouncedPlace place;
    place.position = position, place.width = k_width, place.irradiance = glm::vec3(light);
    place.normal = place.plane = {0, 1, 0};
    return place;
}

TEST(BouncedPlaces, FindsTheNearestOnTheSameSurface)
{
    BouncedPlaces places;
    places.begin({});
    // Light grows along x. A second surface, below the first one, is brighter.
    Random random(5);
    std::vector<BouncedPlace> made;
    for (int i = 0; i < 400; ++i) {
        const glm::vec3 at(random.uniform(-1, 1), 0, random.uniform(-1, 1));
        made.push_back(place_at(at, 2 + at.x));
        made.push_back(place_at(at - glm::vec3(0, 0.3f * k_reach, 0), 50));
        made.push_back(made.front()), made.back().normal = {1, 0, 0}, made.back().irradiance = glm::vec3(70);
        made.push_back(made.front()), made.back().object = 1, made.back().irradiance = glm::vec3(90);
    }
    places.add(made);
    for (int i = 0; i < 100; ++i) {
        const glm::vec3 at(random.uniform(-0.9f, 0.9f), 0, random.uniform(-0.9f, 0.9f));
        const auto found = places.find(place_at(at));
        ASSERT_TRUE(found);
        EXPECT_NEAR(found->mean.x, 2 + at.x, 0.5f * k_reach);
        EXPECT_LE(found->low.x, found->mean.x);
        EXPECT_LE(found->mean.x, found->high.x);
        EXPECT_LT(found->high.x - found->low.x, 2 * k_reach);
    }
    places.begin({});
    EXPECT_FALSE(places.find(place_at({0, 0, 0})));
}

TEST(BouncedPlaces, ALonePlaceMustBeNear)
{
    BouncedPlaces places;
    places.begin({});
    places.add(std::vector{place_at({0, 0, 0}, 3)});
    const float near = BouncedPlacesOptions{}.lone * k_reach;
    EXPECT_TRUE(places.find(place_at({0.9f * near, 0, 0})));
    EXPECT_FALSE(places.find(place_at({1.1f * near, 0, 0})));
    // With a second one, the same place is near enough.
    places.add(std::vector{place_at({k_reach, 0, 0}, 5)});
    const auto found = places.find(place_at({1.2f * near, 0, 0}));
    ASSERT_TRUE(found);
    EXPECT_EQ(found->low.x, 3);
    EXPECT_EQ(found->high.x, 5);
}

TEST(BouncedPlaces, ThinsWhatIsDense)
{
    BouncedPlaces places;
    places.begin({});
    Random random(6);
    std::vector<BouncedPlace> made;
    for (int i = 0; i < 100000; ++i)
        made.push_back(place_at({random.uniform(-1, 1), 0, random.uniform(-1, 1)}, random.uniform(1, 2)));
    places.add(made);
    EXPECT_LT(places.bytes(), std::size_t{100000});
    EXPECT_TRUE(places.find(place_at({0.1f, 0, 0.2f})));
}

TEST(BouncedPlaces, RefusesWidthsThatAreNotPositiveAndFinite)
{
    BouncedPlaces places;
    places.begin({});
    for (const float width : {0.0f, -1.0f, k_infinity, std::numeric_limits<float>::quiet_NaN()}) {
        BouncedPlace place = place_at({0, 0, 0});
        place.width = width;
        places.add(std::vector{place});
        EXPECT_FALSE(places.find(place));
    }
    EXPECT_TRUE(places.empty());
}

TEST(BouncedPlaces, KnowsWhatMoves)
{
    BouncedPlaces places;
    places.begin(std::vector<std::uint32_t>{3, 70});
    for (const std::uint32_t object : {0u, 3u, 69u, 70u, 71u, 1000u})
        EXPECT_EQ(places.moves(object), object == 3 || object == 70) << object;
}

}   // namespace
}   // namespace gnomon::trace
