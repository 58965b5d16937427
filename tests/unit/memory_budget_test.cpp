// SPDX-License-Identifier: Apache-2.0
// A budget of memory: textures are halved until they fit, the same whenever they are fitted; the rest is refused.
#include "scene/memory_budget.h"

#include <gtest/gtest.h>

#include "gnomon/error.h"

namespace gnomon::scene {
namespace {

Texture square(int side, bool mipmaps = true)
{
    Image8 image(side, side, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint8_t>(i * 37);
    Sampler sampler;
    sampler.mipmaps = mipmaps;
    return {"square", image, true, sampler};
}

std::vector<int> sides(const SharedList<Texture>& textures)
{
    std::vector<int> result;
    for (const Texture& texture : textures) result.push_back(texture.width());
    return result;
}

TEST(MemoryBudget, HalvesTheLargestTexturesUntilAllFit)
{
    SharedList<Texture> textures;
    for (const int side : {64, 16, 128, 64}) textures.push_back(square(side));
    MemoryBudget all(1 << 20), some(70'000);
    all.fit(textures);
    EXPECT_EQ(sides(textures), (std::vector{64, 16, 128, 64}));
    EXPECT_EQ(all.warning(textures), "");
    SharedList<Texture> copy = textures;
    some.fit(copy);
    EXPECT_EQ(sides(copy), (std::vector{64, 16, 64, 64})) << "three of 21.8 kB and one of 1.4 kB";
}

TEST(MemoryBudget, AHalvedTextureIsTheNextLevel)
{
    for (const bool mipmaps : {true, false}) {
        SharedList<Texture> textures;
        textures.push_back(square(64, mipmaps));
        const Texture whole = square(64);
        MemoryBudget budget(6000);
        budget.fit(textures);
        ASSERT_EQ(textures[0].width(), 32);
        EXPECT_EQ(textures[0].levels()[0].data, whole.levels()[1].data);
        EXPECT_EQ(textures[0].levels().size(), mipmaps ? whole.levels().size() - 1 : 1u);
        EXPECT_EQ(textures[0].sampler().mipmaps, mipmaps);
        EXPECT_NE(budget.warning(textures).find("1 texture was halved"), std::string::npos) << budget.warning(textures);
    }
}

TEST(MemoryBudget, DoesNotDependOnWhenTexturesAreFitted)
{
    for (std::uint64_t bytes : {0, 100, 3'000, 20'000, 50'000, 100'000, 200'000}) {
        MemoryBudget at_once(bytes), by_one(bytes);
        SharedList<Texture> a, b;
        for (const int side : {64, 128, 16, 32, 128, 64, 1, 256}) {
            a.push_back(square(side)), b.push_back(square(side));
            by_one.fit(b);
        }
        at_once.fit(a);
        EXPECT_EQ(sides(a), sides(b)) << bytes;
        std::uint64_t sum = 0;
        for (const Texture& texture : a) sum += texture.bytes();
        EXPECT_LE(sum, std::max<std::uint64_t>(bytes, 8 * 4));
    }
}

TEST(MemoryBudget, RefusesWhatDoesNotFitAndCountsItBesideTextures)
{
    MemoryBudget budget(100'000);
    budget.take(60'000, "a.gltf", "/accessors/1", "the keys");
    EXPECT_THROW(budget.take(50'000, "a.gltf", "/accessors/2", "the keys"), InputError);
    SharedList<Texture> textures;
    textures.push_back(square(128));   // 87 kB
    budget.fit(textures);
    EXPECT_EQ(textures[0].width(), 64);
}

}   // namespace
}   // namespace gnomon::scene
