// SPDX-License-Identifier: Apache-2.0
// The sky as a set of directions.
#include "irradiance_cache/points/sky_light.h"

#include <gtest/gtest.h>

#include <random>

namespace gnomon {
namespace {

using irradiance_cache::DividedDirection;
using irradiance_cache::k_sky_directions;
using irradiance_cache::SkyLight;
using irradiance_cache::SkyMask;

scene::Background blue_sky()
{
    scene::Background sky;
    sky.kind = scene::Background::Kind::sky;
    return sky;
}

TEST(SkyLight, OpenSurfaceReceivesFullSkyIrradiance)
{
    const scene::Background background = blue_sky();
    const SkyLight sky(background);
    ASSERT_TRUE(sky.any());
    for (const glm::vec3 normal :
         {glm::vec3(0, 1, 0), glm::vec3(1, 0, 0), glm::vec3(0, -1, 0), glm::normalize(glm::vec3(1, 2, -3))}) {
        glm::vec3 irradiance(0);
        for (std::size_t i = 0; i < k_sky_directions; ++i)
            irradiance += sky.light(i) * std::max(0.0f, glm::dot(sky.direction(i), normal));
        glm::dvec3 expected(0);
        constexpr int k_rows = 500, k_columns = 200;
        for (int row = 0; row < k_rows; ++row)
            for (int column = 0; column < k_columns; ++column) {
                const double up = 1 - (2 * row + 1.0) / k_rows, angle = 2 * k_pi * column / k_columns;
                const double across = std::sqrt(1 - up * up);
                const glm::vec3 d(glm::dvec3(across * std::cos(angle), up, across * std::sin(angle)));
                expected += glm::dvec3(background.radiance(d) * std::max(0.0f, glm::dot(d, normal))) *
                            (4 * k_pi / (k_rows * k_columns));
            }
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(static_cast<double>(irradiance[c]) / expected[c], 1, 0.02) << normal.x << " " << normal.y;
    }
}

// What a point sees through an opening of 30 degrees, which is as wide as a courtyard from an arcade, over all
// openings.
TEST(SkyLight, DirectionsResolveAnOpeningOfThirtyDegrees)
{
    const SkyLight sky(blue_sky());
    const float least = std::cos(static_cast<float>(k_pi / 12));
    const double expected = 0.5 * (1 - static_cast<double>(least)) * static_cast<double>(k_sky_directions);
    double square = 0;
    constexpr int k_rows = 40, k_columns = 40;
    for (int row = 0; row < k_rows; ++row)
        for (int column = 0; column < k_columns; ++column) {
            const double up = (row + 0.5) / k_rows, angle = 2 * k_pi * (column + 0.5 * (row % 2)) / k_columns;
            const double across = std::sqrt(1 - up * up);
            const glm::vec3 middle(glm::dvec3(across * std::cos(angle), up, across * std::sin(angle)));
            int seen = 0;
            for (std::size_t i = 0; i < k_sky_directions; ++i) seen += glm::dot(sky.direction(i), middle) >= least;
            square += std::pow(seen / expected - 1, 2);
        }
    EXPECT_LT(std::sqrt(square / (k_rows * k_columns)), 0.12);   // with 128 directions, .32
}

TEST(SkyLight, ExcludesTheSun)
{
    scene::Background sunny = blue_sky();
    sunny.sun_direction = glm::vec3(0, 1, 0);
    sunny.sun_radiance = glm::vec3(1e5f);
    const SkyLight with(sunny), without(blue_sky());
    for (std::size_t i = 0; i < k_sky_directions; ++i) EXPECT_EQ(with.light(i), without.light(i));
}

TEST(SkyLight, PlainColourGivesNoLight)
{
    scene::Background grey;
    grey.color = glm::vec3(0.5f);
    EXPECT_FALSE(SkyLight(grey).any());
}

TEST(SkyLight, ConeContainsAllDirectionsThatMeetTheSphere)
{
    const SkyLight sky(blue_sky());
    std::mt19937 random(5);
    const auto number = [&] { return static_cast<float>(random() % 2000) / 500 - 2; };
    std::size_t in = 0;
    for (int round = 0; round < 500; ++round) {
        const glm::vec3 at(number(), number(), number());
        const float radius = 0.05f + std::abs(number()) / 2;
        const SkyMask mask = sky.towards(at, radius);
        for (std::size_t i = 0; i < k_sky_directions; ++i) {
            const glm::dvec3 d(sky.direction(i)), c(at);
            const double along = std::max(0.0, glm::dot(c, d));
            const double off = glm::length(c - along * d) - static_cast<double>(radius);
            const bool marked = (mask.bits[i / 64] >> (i % 64)) & 1;
            in += marked;
            if (std::abs(off) > 1e-4) {
                EXPECT_EQ(marked, off < 0) << round << " " << i;
            }
        }
    }
    EXPECT_GT(in, 1000u);
}

// An opening of some degrees somewhere: what a point sees of it with divided directions, relative to the truth.
struct Seen {
    double mean = 0, error = 0;   // of many openings
};
Seen divided(double degrees, bool take_back)
{
    const SkyLight sky(blue_sky(), k_sky_directions, 8);
    const float least = std::cos(static_cast<float>(degrees * k_pi / 360));
    const double truth = 0.5 * (1 - static_cast<double>(least));
    SkyMask all;
    for (std::size_t i = 0; i < k_sky_directions; ++i) all.set(i);
    Seen result;
    constexpr int k_rows = 40, k_columns = 40;
    for (int row = 0; row < k_rows; ++row)
        for (int column = 0; column < k_columns; ++column) {
            const double up = (2 * row + 1.0) / k_rows - 1, angle = 2 * k_pi * (column + 0.5 * (row % 2)) / k_columns;
            const double across = std::sqrt(1 - up * up);
            const glm::vec3 middle(glm::dvec3(across * std::cos(angle), up, across * std::sin(angle)));
            const auto is_seen = [&](const glm::vec3& direction) { return glm::dot(direction, middle) >= least; };
            SkyMask seen;
            for (std::size_t i = 0; i < k_sky_directions; ++i)
                if (is_seen(sky.direction(i))) seen.set(i);
            std::vector<DividedDirection> parts;
            sky.edges(all, seen).for_each([&](std::size_t i) {
                unsigned bits = 0;
                for (std::size_t k = 0; k < sky.parts(i).size(); ++k)
                    if (is_seen(sky.parts(i)[k].direction)) bits |= 1u << k;
                parts.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(bits)});
            });
            if (take_back) sky.take_back(all, seen, parts);
            double sum = 0;
            for (const DividedDirection& d : parts) sum += __builtin_popcount(d.seen), seen.reset(d.direction);
            seen.for_each([&](std::size_t i) { sum += static_cast<double>(sky.parts(i).size()); });
            const double ratio = sum / (8.0 * k_sky_directions) / truth;
            result.mean += ratio, result.error += (ratio - 1) * (ratio - 1);
        }
    constexpr double k_count = k_rows * k_columns;
    return {result.mean / k_count, std::sqrt(result.error / k_count)};
}

TEST(SkyLight, DividedDirectionsResolveAnOpeningOfTwentyDegrees)
{
    const Seen seen = divided(20, true);
    EXPECT_NEAR(seen.mean, 1, 0.01);
    EXPECT_LT(seen.error, 0.04);   // undivided: .17
}

TEST(SkyLight, SmallOpeningsKeepTheirLightOnAverage)
{
    for (const double degrees : {3.0, 5.0, 7.0, 9.0, 12.0, 15.0})
        EXPECT_NEAR(divided(degrees, true).mean, 1, 0.08) << degrees;
    EXPECT_LT(divided(5, false).mean, 0.5);
}

TEST(SkyLight, PartsBringTheLightOfTheirDirection)
{
    const SkyLight sky(blue_sky(), k_sky_directions, 8), whole(blue_sky());
    EXPECT_FALSE(whole.divides());
    glm::dvec3 sum(0), sum_whole(0);
    for (std::size_t i = 0; i < k_sky_directions; ++i) {
        glm::vec3 parts(0);
        for (const SkyLight::Part& part : sky.parts(i)) {
            parts += part.light;
            // It is nearer to no other direction.
            for (std::size_t k = 0; k < k_sky_directions; ++k)
                ASSERT_GE(glm::dot(part.direction, sky.direction(i)),
                          glm::dot(part.direction, sky.direction(k)) - 1e-6f);
        }
        EXPECT_EQ(parts, sky.light(i));
        sum += glm::dvec3(parts), sum_whole += glm::dvec3(whole.light(i));
    }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / sum_whole[c], 1, 1e-3);
}

TEST(SkyLight, ConeOfPartsContainsAllWhosePartsMeetTheSphere)
{
    const SkyLight sky(blue_sky(), k_sky_directions, 8);
    std::mt19937 random(6);
    const auto number = [&] { return static_cast<float>(random() % 2000) / 500 - 2; };
    std::size_t in = 0;
    for (int round = 0; round < 100; ++round) {
        const glm::vec3 at(number(), number(), number());
        const float radius = 0.05f + std::abs(number()) / 2;
        const SkyMask mask = sky.towards(at, radius, true);
        for (std::size_t i = 0; i < k_sky_directions; ++i)
            for (const SkyLight::Part& part : sky.parts(i)) {
                const float along = std::max(0.0f, glm::dot(at, part.direction));
                if (glm::length(at - along * part.direction) > radius - 1e-4f) continue;
                EXPECT_TRUE(mask.test(i)) << round << ' ' << i;
                in += mask.test(i);
            }
    }
    EXPECT_GT(in, 1000u);
}

}   // namespace
}   // namespace gnomon
