// SPDX-License-Identifier: Apache-2.0
// Which places of a light triangles hide: against the same arithmetic place by place, and against areas that are known.

#include "area_light/blocked_places.h"

#include <gtest/gtest.h>

#include <bit>
#include <memory>

#include "base/random.h"

namespace gnomon::area_light {
namespace {

LightPolygon square(float side, float height)
{
    const float h = side / 2;
    LightPolygon light;
    light.corner = {glm::vec3(-h, height, -h), glm::vec3(h, height, -h), glm::vec3(h, height, h),
                    glm::vec3(-h, height, h)};
    light.corners = 4;
    light.normal = {0, -1, 0};
    return light;
}

TriangleList list_of(std::initializer_list<std::array<glm::vec3, 3>> triangles)
{
    TriangleList list;
    for (const auto& t : triangles) list.push({t[0], t[1], t[2]});
    list.pad();
    return list;
}

double hidden_share(const glm::vec3& point, const TriangleList& triangles, const LightPlaces& places)
{
    PlaceMask blocked{};
    add_blocked(point, triangles, places, blocked);
    for (std::size_t r = 0; r < blocked.size(); ++r) blocked[r] &= places.inside()[r];
    return static_cast<double>(count_places(blocked)) / places.count();
}

TEST(LightPlaces, FillTheLightEvenly)
{
    const LightPlaces places(square(1, 2));
    EXPECT_EQ(places.count(), k_square_rows * k_row_places);
    for (int cell = 0; cell < 64; ++cell) {
        int count = 0;
        for (int r = 0; r < k_rows; ++r)
            for (int i = 0; i < k_row_places; ++i) {
                const glm::vec2 st = places.at(r, i);
                count += (places.inside()[static_cast<std::size_t>(r)] >> i & 1) &&
                         static_cast<int>(st.x * 8) == cell % 8 && static_cast<int>(st.y * 8) == cell / 8;
            }
        EXPECT_NEAR(count, 64, 4) << "cell " << cell;
    }
    LightPolygon half = square(1, 2);
    half.corners = 3;
    EXPECT_NEAR(LightPlaces(half).count(), k_square_rows * k_row_places / 2, 40);
}

TEST(BlockedPlaces, EqualTheSameTestOfEachPlace)
{
    Random random(7);
    const auto anywhere = [&] {
        return glm::vec3(random.uniform(-1, 1), random.uniform(-0.5f, 2.5f), random.uniform(-1, 1));
    };
    const LightPlaces places(square(1, 2));
    std::uint64_t hidden = 0;
    for (int round = 0; round < 100; ++round) {
        const glm::vec3 point(random.uniform(-1, 1), 0, random.uniform(-1, 1));
        TriangleList list;
        std::vector<std::array<glm::vec3, 3>> triangles;
        const auto count = 1 + random.below(20);
        for (std::uint32_t t = 0; t < count; ++t) {
            triangles.push_back({anywhere(), anywhere(), anywhere()});
            list.push({triangles.back()[0], triangles.back()[1], triangles.back()[2]});
        }
        list.pad();
        PlaceMask blocked{};
        add_blocked(point, list, places, blocked);
        for (int r = 0; r < k_rows; ++r)
            for (int i = 0; i < k_row_places; ++i) {
                bool expected = false;
                for (const auto& t : triangles)
                    expected = expected || blocks_place(point, {t[0], t[1], t[2]}, places, r, i);
                ASSERT_EQ(blocked[static_cast<std::size_t>(r)] >> i & 1, expected ? 1u : 0u)
                    << "round " << round << ", row " << r << ", place " << i;
                hidden += expected;
            }
    }
    EXPECT_GT(hidden, 10000u);
}

TEST(BlockedPlaces, AreTheSameForSeveralPointsAtOnce)
{
    Random random(11);
    const auto anywhere = [&] {
        return glm::vec3(random.uniform(-1, 1), random.uniform(-0.5f, 2.5f), random.uniform(-1, 1));
    };
    const LightPlaces places(square(1, 2));
    int hiding = 0, free = 0;
    for (int round = 0; round < 400; ++round) {
        TriangleList list;
        const auto count = 1 + random.below(round % 4 == 0 ? 40 : 16);
        for (std::uint32_t t = 0; t < count; ++t)
            if (random.below(2) != 0) {
                list.push({anywhere(), anywhere(), anywhere()});
            } else {
                const glm::vec3 at = anywhere(), u = 0.3f * anywhere(), v = 0.3f * anywhere();
                list.push({at, at + u, at + u + v, at + v});
            }
        list.pad();
        // Some points lie in the plane of an entry, so that a quadrilateral is judged by its halves; some behind the
        // light.
        std::vector<glm::vec3> points(1 + random.below(20));
        for (glm::vec3& p : points) p = {random.uniform(-1, 1), random.uniform(-0.2f, 2.4f), random.uniform(-1, 1)};
        points[0] = {list.at(0, 0)[0], list.at(0, 1)[0], list.at(0, 2)[0]};
        const auto of_points = std::make_unique<PlaceMask[]>(points.size());
        const auto hides = std::make_unique<bool[]>(points.size());
        add_blocked(points, list, places, {of_points.get(), points.size()}, {hides.get(), points.size()});
        for (std::size_t k = 0; k < points.size(); ++k) {
            PlaceMask alone{};
            ASSERT_EQ(add_blocked(points[k], list, places, alone), hides[k]) << "round " << round << ", point " << k;
            ASSERT_EQ(alone, of_points[k]) << "round " << round << ", point " << k;
            ++(hides[k] ? hiding : free);
        }
    }
    EXPECT_GT(hiding, 1000);
    EXPECT_GT(free, 100);
}

TEST(BlockedPlaces, CoverTheAreaThatIsHidden)
{
    // Halfway to the light, an occluder hides what is twice as large.
    const LightPlaces places(square(1, 2));
    for (const float edge : {-0.2f, -0.05f, 0.0f, 0.1f, 0.2f}) {
        const TriangleList half_plane = list_of({{glm::vec3(edge, 1, -9), glm::vec3(edge, 1, 9), glm::vec3(-9, 1, 0)}});
        EXPECT_NEAR(hidden_share({0, 0, 0}, half_plane, places), 0.5 + 2.0 * edge, 2e-3) << edge;
    }
    const TriangleList small =
        list_of({{glm::vec3(-0.1f, 1, -0.1f), glm::vec3(0.15f, 1, -0.1f), glm::vec3(-0.1f, 1, 0.2f)}});
    EXPECT_NEAR(hidden_share({0, 0, 0}, small, places), 4 * 0.5 * 0.25 * 0.3, 2e-3);
    // Beyond the light and below the point, nothing is hidden.
    EXPECT_EQ(hidden_share({0, 0, 0},
                           list_of({{glm::vec3(-9, 2.5f, -9), glm::vec3(9, 2.5f, -9), glm::vec3(0, 2.5f, 9)}}), places),
              0);
    EXPECT_EQ(
        hidden_share({0, 0, 0}, list_of({{glm::vec3(-9, -1, -9), glm::vec3(9, -1, -9), glm::vec3(0, -1, 9)}}), places),
        0);
    // A triangle in the light's own plane is where shadow rays end.
    EXPECT_EQ(
        hidden_share({0, 0, 0}, list_of({{glm::vec3(-9, 2, -9), glm::vec3(9, 2, -9), glm::vec3(0, 2, 9)}}), places), 0);
    // A triangle through the light's plane hides what lies behind its lower part: here the plane x = z, from y = 1 up.
    EXPECT_NEAR(
        hidden_share({-0.5f, 0, 0}, list_of({{glm::vec3(0, 1, -9), glm::vec3(0, 1, 9), glm::vec3(0, 30, 0)}}), places),
        0.5, 3e-3);
}

TEST(BlockedPlaces, LeaveNoPlaceOpenBetweenTrianglesThatShareAnEdge)
{
    Random random(11);
    const LightPlaces places(square(1, 2));
    for (int round = 0; round < 200; ++round) {
        // A sheet of triangles around a random inner point, that covers the light as seen from the point.
        TriangleList list;
        const glm::vec3 hub(random.uniform(-0.2f, 0.2f), random.uniform(0.8f, 1.4f), random.uniform(-0.2f, 0.2f));
        constexpr int k_spokes = 23;
        std::array<glm::vec3, k_spokes> rim;
        for (int k = 0; k < k_spokes; ++k) {
            const float angle = 6.2831853f * (static_cast<float>(k) + 0.5f * random.uniform(0, 1)) / k_spokes;
            rim[static_cast<std::size_t>(k)] = {6 * std::cos(angle), random.uniform(0.9f, 1.2f), 6 * std::sin(angle)};
        }
        for (std::size_t k = 0; k < rim.size(); ++k) list.push({hub, rim[k], rim[(k + 1) % rim.size()]});
        list.pad();
        const glm::vec3 point(random.uniform(-0.3f, 0.3f), 0, random.uniform(-0.3f, 0.3f));
        EXPECT_EQ(hidden_share(point, list, places), 1) << round;
    }
}

TEST(BlockedPlaces, AnEdgeThatMovesCoversPlacesOneByOne)
{
    // An edge parallel to a side of the light, in either direction, moved by a 4096th of the light.
    const LightPlaces places(square(1, 2));
    for (const bool turned : {false, true}) {
        int before = -1, most = 0;
        for (int step = -1000; step <= 1000; ++step) {
            const float e = static_cast<float>(step) / 8192.0f;
            const auto at = [&](float x, float z) { return turned ? glm::vec3(z, 1, x) : glm::vec3(x, 1, z); };
            PlaceMask blocked{};
            add_blocked({0, 0, 0}, list_of({{at(e, -9), at(e, 9), at(-9, 0)}}), places, blocked);
            for (std::size_t r = 0; r < blocked.size(); ++r) blocked[r] &= places.inside()[r];
            const int now = count_places(blocked);
            if (before >= 0) most = std::max(most, std::abs(now - before));
            before = now;
        }
        EXPECT_LE(most, 8) << "of 4096; a step of 1/255 would be 16";
    }
}

}   // namespace
}   // namespace gnomon::area_light
