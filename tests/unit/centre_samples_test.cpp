// SPDX-License-Identifier: Apache-2.0
// The pixels that need more samples, compared row by row, against a pixel by itself.
#include "shading/centre_samples.h"

#include <gtest/gtest.h>

#include "base/random.h"

namespace gnomon::shading {
namespace {

glm::vec3 color_at(const ImageF& image, int x, int y)
{
    const float* const c = image.pixel(x, y);
    return {c[0], c[1], c[2]};
}

// Compares a pixel with each pair of opposite neighbours.
bool needs_more(const CentreSamples& samples, int x, int y, const ImageF& color, const RefineOptions& options)
{
    const CentreSample& own = samples.at(x, y);
    const glm::vec3 here = shown(color_at(color, x, y), options.exposure);
    for (const glm::ivec2& way : {glm::ivec2(1, 0), glm::ivec2(0, 1), glm::ivec2(1, 1), glm::ivec2(1, -1)}) {
        glm::vec3 light[2];
        int same = 0;
        for (const glm::ivec2& at : {glm::ivec2(x, y) - way, glm::ivec2(x, y) + way}) {
            if (!samples.inside(at.x, at.y)) continue;
            const CentreSample& other = samples.at(at.x, at.y);
            const glm::vec3 there = color_at(color, at.x, at.y);
            if (same_surface(own, other, options))
                light[same++] = shown(relit(there, other, own.reflectance), options.exposure);
            else if (difference(here, shown(there, options.exposure)) > options.edge)
                return true;
        }
        if (same == 2 && 2 * difference(here, 0.5f * (light[0] + light[1])) > options.light) return true;
        if (same == 1 && difference(here, light[0]) > 2 * options.light) return true;
    }
    return false;
}

// Patches of surfaces in light that changes from step to step; some are textured, some mirror.
void fill(std::uint64_t seed, CentreSamples& samples, ImageF& color)
{
    Random random(seed, 0);
    const int patch = 2 + static_cast<int>(random.next() % 9);
    const float step = 0.4f * random.uniform();
    for (int y = 0; y < color.height; ++y)
        for (int x = 0; x < color.width; ++x) {
            Random of_patch(seed + 1, static_cast<std::uint64_t>(y / patch * 1000 + x / patch));
            CentreSample& sample = samples.at(x, y);
            const std::uint32_t kind = of_patch.next() % 6;
            if (kind > 0) {
                sample.object = of_patch.next() % 3, sample.material = 0, sample.width = 0.02f;
                sample.position = {0.01f * static_cast<float>(x), 0.01f * static_cast<float>(y), kind == 1 ? 1 : 0};
                sample.normal = {0, 0, 1};
                if (kind == 2) sample.normal = {0.8f, 0, 0.6f};
                if (kind == 3) sample.reflectance = glm::vec3(random.uniform());
                if (kind == 4 && random.uniform() < 0.2f)
                    sample.apart = true, sample.mirrored = glm::vec3(0.1f * random.uniform());
            }
            const glm::vec3 light =
                (kind == 0 ? 0.0f : 0.5f + step * random.uniform()) * sample.reflectance + sample.mirrored;
            for (int c = 0; c < 3; ++c) color.pixel(x, y)[c] = light[c];
        }
}

TEST(CentreSamples, RowsTogetherFindThePixelsThatEachFindsByItself)
{
    RefineOptions options;
    int found = 0, all = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const Size size{1 + static_cast<int>(seed % 37), 1 + static_cast<int>(seed * 7 % 29)};
        CentreSamples samples(size);
        ImageF color(size.width, size.height, 3);
        fill(seed, samples, color);
        options.exposure = 0.5f + 0.1f * static_cast<float>(seed % 10);
        for (const int rows : {1, 5, 100})
            for (int begin = 0; begin < size.height; begin += rows) {
                const int end = std::min(begin + rows, size.height);
                std::vector<std::uint8_t> more(static_cast<std::size_t>((end - begin) * size.width));
                samples.find_more(begin, end, color, options, more);
                for (int y = begin; y < end; ++y)
                    for (int x = 0; x < size.width; ++x) {
                        const bool by_itself = needs_more(samples, x, y, color, options);
                        ASSERT_EQ(more[static_cast<std::size_t>((y - begin) * size.width + x)] != 0, by_itself)
                            << "seed " << seed << ", pixel " << x << ", " << y << ", " << rows << " rows at a time";
                        found += by_itself ? 1 : 0, ++all;
                    }
            }
    }
    // Some are found, and some are not.
    EXPECT_GT(found, all / 10);
    EXPECT_LT(found, all - all / 10);
}

TEST(CentreSamples, ATextureOfOneReflectanceDoesNotVary)
{
    CentreSamples samples({3, 3});
    ImageF color(3, 3, 3);
    for (int i = 0; i < 9; ++i) {
        samples.at(i % 3, i / 3).textured = true;
        for (int c = 0; c < 3; ++c) color.pixel(i % 3, i / 3)[c] = 0.3f;
    }
    EXPECT_FALSE(samples.varies(1, 1, color, {}));
    samples.at(2, 2).reflectance = glm::vec3(0.5f);
    EXPECT_TRUE(samples.varies(1, 1, color, {}));
}

}   // namespace
}   // namespace gnomon::shading
