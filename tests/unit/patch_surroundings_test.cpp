// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

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
    }
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
