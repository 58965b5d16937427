// SPDX-License-Identifier: Apache-2.0
#include "image/image_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"
#include "gnomon/compare.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "support.h"

namespace gnomon::image {
namespace {

ImageF even(int channels, float value)
{
    ImageF image(20, 30, channels);
    std::fill(image.data.begin(), image.data.end(), value);
    return image;
}

ImageF noise(std::uint64_t seed, int channels = 3)
{
    ImageF image(40, 30, channels);
    Random random(seed);
    for (float& value : image.data) value = random.uniform();
    return image;
}

TEST(Metrics, OffsetsEqualClosedForm)
{
    // One of three channels differs by 0.25.
    const ImageF b = even(3, 0.5f);
    ImageF a = b;
    for (std::size_t i = 0; i < a.data.size(); i += 3) a.data[i] += 0.25f;
    const double mse = mean_squared_error(a, b);
    EXPECT_DOUBLE_EQ(mse, 0.0625 / 3);
    EXPECT_NEAR(relative_mse(a, b), 0.0625 / (0.25 + 0.01) / 3, 1e-14);
    EXPECT_DOUBLE_EQ(*psnr(mse, 1), 10 * std::log10(48.0));
    EXPECT_DOUBLE_EQ(max_abs_difference(a, b), 0.25);
    EXPECT_DOUBLE_EQ(pixels_different(a, b), 1);
    a = b;
    a.data[7] = 0;
    EXPECT_DOUBLE_EQ(pixels_different(a, b), 1.0 / 600);
}

TEST(Metrics, EqualImagesHaveNoError)
{
    Tasks tasks(1);
    const ImageF a = noise(1);
    EXPECT_EQ(mean_squared_error(a, a), 0);
    EXPECT_EQ(psnr(0, 1), std::nullopt);
    EXPECT_EQ(pixels_different(a, a), 0);
    EXPECT_EQ(ssim(a, a, 1, tasks), 1);
}

TEST(Metrics, NanDiffersFromANumber)
{
    ImageF a = even(1, 0), b = a;
    a.data[3] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_DOUBLE_EQ(pixels_different(a, b), 1.0 / 600);
    EXPECT_EQ(pixels_different(a, a), 0);
    b.data[3] = std::numeric_limits<float>::infinity();
    EXPECT_TRUE(std::isfinite(mean_squared_error(a, b)));
}

// Uniform images have no variance: only the luminance term remains [Wang et al. 2004, eq. 6].
TEST(Ssim, UniformImagesEqualClosedForm)
{
    Tasks tasks(1);
    const double c1 = 1e-4, expected = (2 * 0.25 * 0.75 + c1) / (0.25 * 0.25 + 0.75 * 0.75 + c1);
    EXPECT_NEAR(ssim(even(3, 0.25f), even(3, 0.75f), 1, tasks), expected, 1e-9);
    EXPECT_NEAR(ssim(even(1, 0.25f), even(1, 0.75f), 1, tasks), expected, 1e-9);
}

// An inverted image has the negated covariance, so structure is negative where the means agree.
TEST(Ssim, InvertedImageHasNegativeStructure)
{
    Tasks tasks(1);
    const ImageF a = noise(1);
    ImageF b = a;
    for (float& value : b.data) value = 1 - value;
    EXPECT_LT(ssim(a, b, 1, tasks), -0.8);
}

TEST(Ssim, IsSymmetricAndFallsWithNoise)
{
    Tasks one(1), three(3);
    const ImageF a = noise(1), b = noise(2);
    EXPECT_NEAR(ssim(a, b, 1, one), ssim(b, a, 1, one), 1e-15);
    EXPECT_EQ(ssim(a, b, 1, one), ssim(a, b, 1, three));
    double last = 1;
    for (const float strength : {0.05f, 0.1f, 0.2f, 0.4f}) {
        ImageF noisy = a;
        for (std::size_t i = 0; i < a.data.size(); ++i) noisy.data[i] += strength * (b.data[i] - 0.5f);
        const double likeness = ssim(noisy, a, 1, one);
        EXPECT_LT(likeness, last);
        last = likeness;
    }
}

// Bands of rows are completed in any order, and summed in one.
TEST(Ssim, SameBitsForAnyThreadCount)
{
    Tasks one(1), many(8);
    ImageF a(12, 2000, 1), b(12, 2000, 1);
    Random random(5);
    for (std::size_t i = 0; i < a.data.size(); ++i) {
        a.data[i] = random.uniform();
        // Bands differ much in what they contribute, so that another order rounds differently.
        b.data[i] = std::lerp(a.data[i], random.uniform(), static_cast<float>(i) / static_cast<float>(a.data.size()));
    }
    const double first = ssim(a, b, 1, one);
    for (int round = 0; round < 50; ++round) ASSERT_EQ(ssim(a, b, 1, many), first) << round;
}

// The definition without separable sums, for a single window of the image's size.
TEST(Ssim, SingleWindowEqualsDefinition)
{
    Tasks tasks(1);
    ImageF a(11, 11, 1), b(11, 11, 1);
    Random random(9);
    for (float& value : a.data) value = random.uniform();
    for (float& value : b.data) value = random.uniform();
    double weights = 0, ma = 0, mb = 0;
    const auto w = [](int x, int y) { return std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / (2 * 1.5 * 1.5)); };
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 11; ++x) {
            weights += w(x, y);
            ma += w(x, y) * a.pixel(x, y)[0], mb += w(x, y) * b.pixel(x, y)[0];
        }
    ma /= weights, mb /= weights;
    double va = 0, vb = 0, cov = 0;
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 11; ++x) {
            const double p = a.pixel(x, y)[0] - ma, q = b.pixel(x, y)[0] - mb;
            va += w(x, y) * p * p / weights, vb += w(x, y) * q * q / weights, cov += w(x, y) * p * q / weights;
        }
    const double c1 = 1e-4, c2 = 9e-4;
    const double expected = (2 * ma * mb + c1) * (2 * cov + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
    EXPECT_NEAR(ssim(a, b, 1, tasks), expected, 1e-12);
}

TEST(Ssim, AcceptsImagesSmallerThanAWindow)
{
    Tasks tasks(1);
    ImageF a(3, 1, 3), b(3, 1, 3);
    for (float& value : a.data) value = 0.25f;
    for (float& value : b.data) value = 0.75f;
    EXPECT_NEAR(ssim(a, b, 1, tasks), (2 * 0.25 * 0.75 + 1e-4) / (0.25 * 0.25 + 0.75 * 0.75 + 1e-4), 1e-9);
}

TEST(Compare, ComparesEncodedAndLinearImages)
{
    const test::ScratchFolder scratch;
    Image8 gray(16, 16, 3), other = gray;
    std::fill(gray.data.begin(), gray.data.end(), std::uint8_t{128});
    std::fill(other.data.begin(), other.data.end(), std::uint8_t{77});
    io::write_png(scratch / "a.png", gray);
    io::write_png(scratch / "b.png", other);
    const CompareResult pngs = compare(scratch / "a.png", scratch / "b.png");
    EXPECT_NEAR(pngs.rmse, 0.2, 1e-6);   // of bytes / 255
    EXPECT_NEAR(*pngs.psnr, 10 * std::log10(25.0), 1e-4);
    EXPECT_NEAR(pngs.max_abs, 0.2, 1e-6);
    EXPECT_EQ(pngs.pixels_different, 1);

    // The same radiance as OpenEXR: no difference except rounding.
    io::ExrLayer layer{"", {"R", "G", "B"}, std::vector<float>(16 * 16 * 3, linear_from_srgb8()[128])};
    io::write_exr(scratch / "a.exr", {16, 16}, std::span(&layer, 1));
    const CompareResult mixed = compare(scratch / "a.png", scratch / "a.exr");
    EXPECT_LT(mixed.max_abs, 1e-6);
    EXPECT_LT(*mixed.flip, 1e-3);
    const CompareResult same = compare(scratch / "a.exr", scratch / "a.exr");
    EXPECT_EQ(same.psnr, std::nullopt);
    EXPECT_EQ(*same.flip, 0);
    EXPECT_EQ(*same.ssim, 1);
}

TEST(Compare, ChecksLayersAndSizesAndWritesHeatMap)
{
    const test::ScratchFolder scratch;
    std::vector<io::ExrLayer> layers{{"", {"R", "G", "B"}, std::vector<float>(16 * 8 * 3, 0.5f)},
                                     {"depth", {"Z"}, std::vector<float>(16 * 8, 2.0f)},
                                     {"shadow", {"L0", "L1"}, std::vector<float>(16 * 8 * 2, 1.0f)}};
    io::write_exr(scratch / "a.exr", {16, 8}, layers);
    layers[1].data[0] = 6;
    layers[2].data[1] = 0;   // L1 of the first pixel
    io::write_exr(scratch / "b.exr", {16, 8}, layers);
    const auto layer = [&](const char* name) {
        CompareOptions options;
        options.layer = name;
        return compare(scratch / "a.exr", scratch / "b.exr", options);
    };
    EXPECT_EQ(layer("").rmse, 0);
    EXPECT_DOUBLE_EQ(layer("depth").rmse, std::sqrt(16.0 / 128));
    EXPECT_DOUBLE_EQ(layer("shadow").pixels_different, 1.0 / 128);
    EXPECT_EQ(layer("shadow").flip, std::nullopt);
    EXPECT_EQ(layer("shadow.L0").max_abs, 0);
    EXPECT_EQ(layer("shadow.L1").max_abs, 1);
    EXPECT_THROW(layer("albedo"), UsageError);

    CompareOptions options;
    options.heatmap = scratch / "heat.png";
    compare(scratch / "a.exr", scratch / "b.exr", options);
    EXPECT_TRUE(io::is_whole_png(scratch / "heat.png", 16, 8));

    io::write_png(scratch / "c.png", Image8(15, 8, 3));
    EXPECT_THROW(compare(scratch / "a.exr", scratch / "c.png"), UsageError);
}

}   // namespace
}   // namespace gnomon::image
