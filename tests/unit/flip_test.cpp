// SPDX-License-Identifier: Apache-2.0
#include "image/flip.h"

#include <gtest/gtest.h>

#include "base/math.h"
#include "base/random.h"

namespace gnomon::image {
namespace {

ImageF even(int width, int height, const glm::vec3& color)
{
    ImageF image(width, height, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = color[static_cast<int>(i % 3)];
    return image;
}

ImageF noise(int width, int height, std::uint64_t seed, float low = 0, float high = 1)
{
    ImageF image(width, height, 3);
    Random random(seed);
    for (float& value : image.data) value = random.uniform(low, high);
    return image;
}

double flip_of(const ImageF& a, const ImageF& b)
{
    Tasks tasks(1);
    return mean_of(flip_ldr(a, b, tasks));
}

TEST(Flip, EqualImagesHaveNoError)
{
    Tasks tasks(2);
    const ImageF image = noise(50, 70, 1);
    for (const float error : flip_ldr(image, image, tasks).data) ASSERT_EQ(error, 0.0f);
    for (const float error : flip_hdr(image, image, tasks).data) ASSERT_EQ(error, 0.0f);
}

// Uniform images have no features and are not changed by blurring, so the paper's formulas have a closed form. Black
// and white: HyAB = 100. The largest difference, green and blue, with L* a* b* of (87.73, -86.18, 83.18) and (32.30,
// 79.19, -107.86), after Hunt: 55.44 + |(-101.18, 107.81)| = 203.3. In powers of 0.7: 25.12 and 41.28; the knee is at
// 0.4 * 41.28 = 16.51, so the error is 0.95 + 0.05 * (25.12 - 16.51) / (41.28 - 16.51) = 0.9674.
TEST(Flip, BlackAndWhiteEqualClosedForm)
{
    EXPECT_NEAR(flip_of(even(40, 33, glm::vec3(0)), even(40, 33, glm::vec3(1))), 0.9674, 2e-4);
}

TEST(Flip, GreenAndBlueHaveTheGreatestError)
{
    EXPECT_NEAR(flip_of(even(40, 33, {0, 1, 0}), even(40, 33, {0, 0, 1})), 1.0, 1e-5);
}

// Below the knee: greys of lightness 50 and 60 (Y = 0.18419 and 0.28123): 10^0.7 = 5.012 -> 0.95 * 5.012 / 16.51.
TEST(Flip, GreysEqualClosedForm)
{
    EXPECT_NEAR(flip_of(even(40, 33, glm::vec3(0.184187f)), even(40, 33, glm::vec3(0.281233f))), 0.2884, 2e-4);
}

TEST(Flip, IsSymmetric)
{
    Tasks tasks(1);
    const ImageF a = noise(60, 45, 1), b = noise(60, 45, 2);
    EXPECT_EQ(flip_ldr(a, b, tasks).data, flip_ldr(b, a, tasks).data);
}

TEST(Flip, ErrorsStayInRangeAndGrowWithNoise)
{
    const ImageF base = even(64, 64, glm::vec3(0.4f));
    double last = 0;
    for (const float strength : {0.05f, 0.1f, 0.2f, 0.4f}) {
        ImageF noisy = base;
        Random random(5);
        for (float& value : noisy.data) value += random.uniform(-strength, strength);
        const double error = flip_of(noisy, base);
        EXPECT_GT(error, last * 1.2);
        EXPECT_LT(error, 1);
        last = error;
    }
}

// A moved edge changes the error near itself only: the filters reach 10 pixels.
TEST(Flip, ErrorsAreLocal)
{
    Tasks tasks(1);
    ImageF a = even(90, 40, glm::vec3(0.2f)), b = a;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 90; ++x)
            for (int c = 0; c < 3; ++c) {
                if (x >= 45) a.pixel(x, y)[c] = 0.8f;
                if (x >= 47) b.pixel(x, y)[c] = 0.8f;
            }
    const ImageF map = flip_ldr(a, b, tasks);
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 90; ++x) {
            const float error = map.pixel(x, y)[0];
            ASSERT_TRUE(error < 1e-3f || (x >= 34 && x <= 57)) << x << ' ' << error;
            ASSERT_TRUE(error > 0.3f || (x != 45 && x != 46)) << x << ' ' << error;
        }
}

TEST(Flip, SameForAnyThreadCount)
{
    Tasks one(1), three(3);
    const ImageF a = noise(70, 101, 1, 0, 20), b = noise(70, 101, 2, 0, 20);
    EXPECT_EQ(flip_ldr(a, b, one).data, flip_ldr(a, b, three).data);
    EXPECT_EQ(flip_hdr(a, b, one).data, flip_hdr(a, b, three).data);
}

// The curve reaches 0.85 at x: (0.9036 - 0.85 * 0.8748) x^2 + (0.018 - 0.85 * 0.354) x - 0.85 * 0.14 = 0, x = 2.1189.
TEST(Flip, ExposuresRangeFromBrightestToMedian)
{
    ImageF reference = even(10, 10, glm::vec3(0.5f));
    reference.pixel(3, 3)[0] = reference.pixel(3, 3)[1] = reference.pixel(3, 3)[2] = 64;
    const FlipExposures range = flip_exposures(reference);
    EXPECT_NEAR(range.first, std::log2(2.1189 / 64), 1e-3);
    EXPECT_NEAR(range.last, std::log2(2.1189 / 0.5), 1e-3);
    EXPECT_EQ(range.count, 7);
    EXPECT_EQ(flip_exposures(even(4, 4, glm::vec3(0))).count, 2);
}

// Differences that are too bright for one exposure are found in another.
TEST(Flip, HdrFindsDifferencesThatLdrClips)
{
    Tasks tasks(2);
    ImageF reference = even(40, 40, glm::vec3(0.2f)), test = reference;
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 40; ++x)
            for (int c = 0; c < 3; ++c) reference.pixel(x, y)[c] = 50, test.pixel(x, y)[c] = 25;
    EXPECT_EQ(mean_of(flip_ldr(test, reference, tasks)), 0);
    EXPECT_GT(flip_hdr(test, reference, tasks).pixel(20, 5)[0], 0.2f);
}

TEST(Flip, HeatMapRangesFromBlackToPaleYellow)
{
    ImageF map(3, 1, 1);
    map.data = {0, 0.5f, 1};
    const Image8 heat = heat_map(map);
    EXPECT_EQ(heat.data, (std::vector<std::uint8_t>{0, 0, 4, 181, 54, 122, 252, 253, 191}));
}

}   // namespace
}   // namespace gnomon::image
