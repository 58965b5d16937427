// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "patches/surroundings.h"
#include "scene/environment.h"

namespace gnomon::patches {
namespace {

// Cells of an image, 11 degrees wide, have the image's radiance in their directions.
TEST(PatchSurroundings, HaveTheRadianceOfTheImage)
{
    ImageF image(128, 64, 3);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const glm::vec3 d = scene::Environment::direction_at((x + 0.5) / image.width, (y + 0.5) / image.height);
            for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = 1 + d[c];
        }
    scene::Background background;
    background.kind = scene::Background::Kind::image;
    background.environment = std::make_shared<const scene::Environment>(image);
    const Surroundings surroundings(background);
    EXPECT_TRUE(surroundings.any());
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        const glm::vec3 d =
            glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) + 1e-3f);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(surroundings.radiance(d)[c], 1 + d[c], 0.15f) << i << ' ' << c;
        // The integral of (1 + d) times the cosine.
        for (int c = 0; c < 3; ++c) {
            const auto pi = static_cast<float>(k_pi), truth = pi + 2 * pi / 3 * d[c];
            EXPECT_NEAR(surroundings.irradiance_beside_spots(d)[c], truth, 0.01f * pi) << i << ' ' << c;
        }
    }
}

// The cell of a direction is found from rough angles, unless that is uncertain.
TEST(PatchSurroundings, KnowTheCellOfEachDirection)
{
    constexpr int k_columns = 32, k_rows = 16;
    ImageF image(k_columns, k_rows, 3);
    for (int y = 0; y < k_rows; ++y)
        for (int x = 0; x < k_columns; ++x) image.pixel(x, y)[0] = static_cast<float>(k_columns * y + x);
    scene::Background background;
    background.kind = scene::Background::Kind::image;
    background.environment = std::make_shared<const scene::Environment>(image);
    const Surroundings surroundings(background);
    const auto expect_cell = [&](const glm::vec3& d) {
        const double u = 0.5 + std::atan2(static_cast<double>(d.x), -static_cast<double>(d.z)) / (2 * k_pi),
                     v = std::acos(std::clamp(static_cast<double>(d.y), -1.0, 1.0)) / k_pi;
        const int column = std::min(static_cast<int>(u * k_columns), k_columns - 1),
                  row = std::min(static_cast<int>(v * k_rows), k_rows - 1);
        EXPECT_NEAR(surroundings.radiance(d).x, static_cast<float>(k_columns * row + column), 0.01f)
            << d.x << ' ' << d.y << ' ' << d.z;
    };
    Random random(3);
    for (int i = 0; i < 20000; ++i)
        expect_cell(glm::normalize(glm::vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)) +
                                   glm::vec3(1e-4f)));
    // At the ends of cells, and next to them.
    for (int x = 0; x <= k_columns; ++x)
        for (int y = 0; y <= k_rows; ++y)
            for (const double off : {-1e-4, -1e-6, 0.0, 1e-6, 1e-4})
                expect_cell(
                    scene::Environment::direction_at(std::clamp(static_cast<double>(x) / k_columns + off, 0.0, 1.0),
                                                     std::clamp(static_cast<double>(y) / k_rows + off, 0.0, 1.0)));
    for (const glm::vec3& axis : {glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)})
        expect_cell(axis);
}

TEST(PatchSurroundings, OfOneColourGiveNoLight)
{
    scene::Background grey;
    grey.color = glm::vec3(0.5f);
    EXPECT_FALSE(Surroundings(grey).any());
    EXPECT_EQ(Surroundings(grey).radiance({0, 1, 0}), glm::vec3(0));
}

}   // namespace
}   // namespace gnomon::patches
