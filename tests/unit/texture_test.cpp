// SPDX-License-Identifier: Apache-2.0
#include "scene/texture.h"

#include <gtest/gtest.h>

namespace gnomon::scene {
namespace {

// Four texels: black, red / green, white.
Image8 four_texels()
{
    Image8 image(2, 2, 3);
    const std::uint8_t bytes[] = {0, 0, 0, 255, 0, 0, 0, 255, 0, 255, 255, 255};
    std::copy(std::begin(bytes), std::end(bytes), image.data.begin());
    return image;
}

TEST(Texture, RowZeroIsTheTop)
{
    Sampler sampler;
    sampler.magnify = Filter::nearest;
    const Texture texture("t", four_texels(), true, sampler);
    EXPECT_EQ(glm::vec3(texture.sample({0.75f, 0.25f}, 0)), glm::vec3(1, 0, 0));
    EXPECT_EQ(glm::vec3(texture.sample({0.25f, 0.75f}, 0)), glm::vec3(0, 1, 0));
}

TEST(Texture, RepeatsFarFromTheOrigin)
{
    const Texture texture("t", four_texels(), true, {});
    for (const glm::vec2 uv : {glm::vec2(0.25f, 0.25f), glm::vec2(0.5f, 0.125f), glm::vec2(0.875f, 0.625f)}) {
        const glm::vec4 here = texture.sample(uv, 0);
        EXPECT_EQ(here, texture.sample(uv + glm::vec2(328, -196), 0));
        EXPECT_EQ(here, texture.sample(uv + glm::vec2(-1, 1), 0));
    }
}

TEST(Texture, HonoursWrapModes)
{
    Sampler sampler;
    sampler.magnify = Filter::nearest;
    sampler.wrap_u = Wrap::clamp;
    sampler.wrap_v = Wrap::mirror;
    const Texture texture("t", four_texels(), true, sampler);
    EXPECT_EQ(glm::vec3(texture.sample({7.0f, 0.25f}, 0)), glm::vec3(1, 0, 0));    // clamped to the right column
    EXPECT_EQ(glm::vec3(texture.sample({7.0f, -0.25f}, 0)), glm::vec3(1, 0, 0));   // mirrored at the top
    EXPECT_EQ(glm::vec3(texture.sample({7.0f, 1.75f}, 0)), glm::vec3(1, 0, 0));    // mirrored at the bottom
}

TEST(Texture, FiltersInLinearLight)
{
    const Texture texture("t", four_texels(), true, {});
    // Between a black and a red texel lies half of red in linear light, not in sRGB.
    EXPECT_NEAR(texture.sample({0.5f, 0.25f}, 0).x, 0.5f, 1e-6f);
    // The coarsest level is the mean of all texels, to the precision of 8 bits.
    EXPECT_NEAR(texture.sample({0.3f, 0.9f}, 1000).y, 0.5f, 0.005f);
}

TEST(Texture, TransparentColourDoesNotBleed)
{
    Image8 image(2, 1, 4);
    const std::uint8_t bytes[] = {255, 0, 0, 0, 0, 255, 0, 255};
    std::copy(std::begin(bytes), std::end(bytes), image.data.begin());
    const Texture texture("t", image, true, {});
    const glm::vec4 coarse = texture.sample({0.5f, 0.5f}, 100);
    EXPECT_EQ(coarse.x, 0.0f);
    EXPECT_EQ(coarse.y, 1.0f);
    EXPECT_NEAR(coarse.w, 0.5f, 0.003f);
}

TEST(Texture, SurvivesNonFiniteCoordinates)
{
    const Texture texture("t", four_texels(), true, {});
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const glm::vec2 uv : {glm::vec2(nan, 0), glm::vec2(0, k_infinity), glm::vec2(1e30f, -1e30f)})
        for (const float footprint : {0.0f, 3.0f, k_infinity, nan})
            EXPECT_TRUE(is_finite(glm::vec3(texture.sample(uv, footprint))));
}

TEST(TextureUse, TransformsAsGltfSpecifies)
{
    TextureUse use;
    use.offset = {0.1f, 0.2f};
    use.scale = {2, 3};
    use.rotation = static_cast<float>(k_pi / 2);
    const glm::vec2 uv = use.apply({1, 0});
    EXPECT_NEAR(uv.x, 0.1f, 1e-6f);
    EXPECT_NEAR(uv.y, 0.2f - 2, 1e-6f);
}

}   // namespace
}   // namespace gnomon::scene
