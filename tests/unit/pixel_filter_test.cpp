// SPDX-License-Identifier: Apache-2.0
// Samples become pixels by weights that sum to 1, whatever the tiles, and bright ones count less.
#include "image/pixel_filter.h"

#include <gtest/gtest.h>

#include <vector>

namespace gnomon::image {
namespace {

constexpr PixelFilter k_filters[] = {PixelFilter::box, PixelFilter::gaussian, PixelFilter::blackman_harris};

std::vector<float> resolved(const SampleSums& sums, Size size, std::size_t tiles)
{
    const auto channels = static_cast<std::size_t>(sums.channels());
    std::vector<float> image(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) * channels);
    for (std::size_t tile = 0; tile < tiles; ++tile)
        sums.resolve(tile, [&](int x, int y, const float* values) {
            const auto at =
                (static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + static_cast<std::size_t>(x)) *
                channels;
            for (std::size_t c = 0; c < channels; ++c) image[at + c] = values[c];
        });
    return image;
}

// Adds a sample at every pixel's centre to sums in tiles of `side` pixels.
std::vector<float> filtered(PixelFilter filter, Size size, int side, const std::vector<float>& gray)
{
    SampleSums sums(size, side, 3, k_infinity);
    const SampleWeights weights = sample_weights(filter, glm::vec2(0.5f));
    const int columns = (size.width + side - 1) / side, rows = (size.height + side - 1) / side;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            const float v = gray[static_cast<std::size_t>(y * size.width + x)];
            const float values[3] = {v, v, v};
            sums.add(static_cast<std::size_t>(y / side * columns + x / side), x % side, y % side, weights, 1, values);
        }
    return resolved(sums, size, static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
}

TEST(PixelFilter, WeightsFallFromTheCentreAndAreNeverNegative)
{
    for (const PixelFilter filter : k_filters) {
        float last = filter_weight(filter, 0);
        EXPECT_GT(last, 0);
        for (float d = 0; d < 2; d += 0.01f) {
            const float w = filter_weight(filter, d);
            EXPECT_GE(w, 0);
            EXPECT_LE(w, last + 1e-6f);
            EXPECT_EQ(w, filter_weight(filter, -d));
            last = w;
        }
        EXPECT_EQ(filter_weight(filter, k_filter_radius), 0);
    }
}

TEST(PixelFilter, EvenImageStaysEven)
{
    const Size size{7, 5};
    for (const PixelFilter filter : k_filters)
        for (const float v : filtered(filter, size, 4, std::vector<float>(35, 0.5f))) EXPECT_NEAR(v, 0.5f, 1e-6f);
}

TEST(PixelFilter, BoxKeepsPixelsApart)
{
    const Size size{4, 1};
    const std::vector<float> image = filtered(PixelFilter::box, size, 2, {0, 1, 0, 3});
    EXPECT_EQ(image[0], 0);
    EXPECT_EQ(image[3], 1);
    EXPECT_EQ(image[6], 0);
    EXPECT_EQ(image[9], 3);
}

TEST(PixelFilter, BrightPixelReachesItsNeighboursAcrossTiles)
{
    const Size size{5, 5};
    std::vector<float> gray(25, 0);
    gray[12] = 1;
    const std::vector<float> one_tile = filtered(PixelFilter::blackman_harris, size, 8, gray);
    const float beside =
        filter_weight(PixelFilter::blackman_harris, 1) / filter_weight(PixelFilter::blackman_harris, 0);
    const float sum = 1 + 2 * beside;
    EXPECT_NEAR(one_tile[12 * 3], 1 / (sum * sum), 1e-6f);
    EXPECT_NEAR(one_tile[11 * 3], beside / (sum * sum), 1e-6f);
    EXPECT_EQ(one_tile[10 * 3], 0);
    for (const int side : {1, 2, 3, 4}) {
        const std::vector<float> tiled = filtered(PixelFilter::blackman_harris, size, side, gray);
        for (std::size_t i = 0; i < tiled.size(); ++i) EXPECT_NEAR(tiled[i], one_tile[i], 1e-6f) << side;
    }
}

TEST(PixelFilter, SamplesOfAPixelStandForItsArea)
{
    // The left pixel has one sample, the right one two.
    SampleSums sums({2, 1}, 2, 4, k_infinity);
    const SampleWeights centre = sample_weights(PixelFilter::box, glm::vec2(0.5f));
    const float dark[4] = {0, 0, 0, 0}, bright[4] = {1, 1, 1, 8};
    sums.add(0, 0, 0, centre, 1, bright);
    sums.add(0, 1, 0, centre, 0.5f, bright);
    sums.add(0, 1, 0, centre, 0.5f, dark);
    const std::vector<float> image = resolved(sums, {2, 1}, 1);
    EXPECT_EQ(image[0], 1);
    EXPECT_EQ(image[4], 0.5f);
    EXPECT_EQ(image[7], 4);

    // A filter that reaches the neighbour weighs both pixels alike, however many samples they have.
    SampleSums one({2, 1}, 2, 4, k_infinity), two({2, 1}, 2, 4, k_infinity);
    const SampleWeights wide = sample_weights(PixelFilter::blackman_harris, glm::vec2(0.5f));
    for (SampleSums* to : {&one, &two}) to->add(0, 0, 0, wide, 1, bright);
    one.add(0, 1, 0, wide, 1, dark);
    for (int i = 0; i < 2; ++i) two.add(0, 1, 0, wide, 0.5f, dark);
    const std::vector<float> expected = resolved(one, {2, 1}, 1), weighed = resolved(two, {2, 1}, 1);
    ASSERT_GT(expected[4], 0);
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(weighed[i], expected[i], 1e-6f) << i;
}

// A pixel's only sample is spread as far as many samples of it are: sum and second moment of the weights are those of
// the filter, seen from samples all over a pixel.
TEST(PixelFilter, LoneSamplesAreBlurredAsManyAre)
{
    constexpr int k_samples = 400;
    for (const PixelFilter filter : k_filters) {
        // Of many: the mean of the weights, and of the squared distance between sample and pixel.
        double sum = 0, square = 0;
        for (int i = 0; i < k_samples; ++i) {
            const float at = (static_cast<float>(i) + 0.5f) / k_samples;
            const SampleWeights weights = sample_weights(filter, {at, 0.5f});
            for (int k = 0; k < 3; ++k) {
                const double away = static_cast<double>(at) - (k - 1) - 0.5;
                sum += static_cast<double>(weights.across[k]) / k_samples;
                square += static_cast<double>(weights.across[k]) * away * away / k_samples;
            }
        }
        if (filter == PixelFilter::box) square = 0;   // a pixel apart from its neighbours stays so
        const SampleWeights lone = lone_sample_weights(filter);
        for (const float* const weights : {lone.across, lone.down}) {
            EXPECT_NEAR(static_cast<double>(weights[0] + weights[1] + weights[2]), sum, 2e-3);
            EXPECT_NEAR(static_cast<double>(weights[0] + weights[2]), square, 2e-3);
            EXPECT_EQ(weights[0], weights[2]);
        }
    }
}

// Places of evenly spread numbers have the filter's mean, its second moment, and its density.
TEST(PixelFilter, PlacesAreAsDenseAsTheFilterHasWeight)
{
    constexpr int k_places = 1000;
    for (const PixelFilter filter : k_filters) {
        double mean = 0, square = 0, weight = 0, of_weight = 0;
        for (int i = 0; i < k_places; ++i) {
            const double place = static_cast<double>(filter_place(filter, (static_cast<float>(i) + 0.5f) / k_places));
            mean += place / k_places, square += place * place / k_places;
            const double along = k_filter_radius * (2 * (i + 0.5) / k_places - 1);
            const auto here = static_cast<double>(filter_weight(filter, static_cast<float>(along)));
            weight += here, of_weight += here * along * along;
        }
        EXPECT_NEAR(mean, 0, 1e-4);
        EXPECT_NEAR(square, of_weight / weight, 1e-3);
        EXPECT_GE(filter_place(filter, 0), -k_filter_radius);
        EXPECT_LE(filter_place(filter, 1), k_filter_radius);
    }
    EXPECT_EQ(filter_place(PixelFilter::box, 0.75f), 0.25f);
}

TEST(PixelFilter, LightAboveWhiteCountsLess)
{
    // One of four samples shows an emitter 30 times as bright as white. Its edge becomes a step below white.
    SampleSums sums({1, 1}, 1, 4, 1);
    const SampleWeights centre = sample_weights(PixelFilter::box, glm::vec2(0.5f));
    const float bright[4] = {30, 30, 30, 1}, dark[4] = {0, 0, 0, 0};
    EXPECT_EQ(sums.add(0, 0, 0, centre, 0.25f, bright), 1.0f / 30);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(sums.add(0, 0, 0, centre, 0.25f, dark), 1);
    const std::vector<float> image = resolved(sums, {1, 1}, 1);
    EXPECT_LT(image[0], 0.5f);
    EXPECT_GT(image[0], 0.25f);
    EXPECT_EQ(image[3], 0.25f);   // coverage is not light
}

// An image in the memory of another, larger one, with more channels.
TEST(PixelFilter, NothingIsLeftOfTheImageBefore)
{
    const SampleWeights wide = sample_weights(PixelFilter::gaussian, glm::vec2(0.3f, 0.6f));
    const float values[5] = {3, 2, 1, 0.5f, 7};
    SampleSums used({9, 7}, 4, 5, 1), fresh({6, 5}, 4, 3, k_infinity);
    for (std::size_t tile = 0; tile < 6; ++tile) used.add(tile, 2, 2, wide, 1, values);
    used.begin({6, 5}, 4, 3, k_infinity);
    for (std::size_t tile = 0; tile < 4; ++tile) used.clear(tile);
    for (SampleSums* sums : {&used, &fresh})
        for (std::size_t tile = 0; tile < 4; ++tile) sums->add(tile, 1, 0, wide, 1, values);
    EXPECT_EQ(resolved(used, {6, 5}, 4), resolved(fresh, {6, 5}, 4));
}

}   // namespace
}   // namespace gnomon::image
