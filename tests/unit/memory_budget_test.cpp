// SPDX-License-Identifier: Apache-2.0
// A budget of memory: textures are halved until they fit, the same whenever they are fitted; the rest is refused.
#include "scene/memory_budget.h"

#include <gtest/gtest.h>

#include "gnomon/error.h"

namespace gnomon::scene {
namespace {

Image8 image_of(int side)
{
    Image8 image(side, side, 3);
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint8_t>(i * 37);
    return image;
}

const MemoryBudget::Asker k_asker{"a.gltf", "/textures", "the texture"};

// Adds a texture as importers do.
void add(MemoryBudget& budget, SharedList<Texture>& textures, int side, bool mipmaps = true, std::uint64_t moment = 0)
{
    const MemoryBudget::Expected expected = budget.expect(side, side);
    budget.make_room(moment, textures, k_asker);
    Sampler sampler;
    sampler.mipmaps = mipmaps;
    const auto id = static_cast<TextureId>(textures.size());
    textures.push_back(budget.make(expected, "square", image_of(side), true, sampler));
    budget.made(expected, id);
}

std::uint64_t bytes_of(const SharedList<Texture>& textures)
{
    std::uint64_t sum = 0;
    for (const Texture& texture : textures) sum += texture.bytes();
    return sum;
}

std::vector<int> sides(const SharedList<Texture>& textures)
{
    std::vector<int> result;
    for (const Texture& texture : textures) result.push_back(texture.width());
    return result;
}

TEST(MemoryBudget, HalvesTheLargestTexturesUntilAllFit)
{
    SharedList<Texture> whole, halved;
    MemoryBudget all(1 << 20), some(90'000);
    for (const int side : {64, 16, 128, 64}) add(all, whole, side), add(some, halved, side);
    EXPECT_EQ(sides(whole), (std::vector{64, 16, 128, 64}));
    EXPECT_EQ(all.warning(whole), "");
    EXPECT_EQ(sides(halved), (std::vector{64, 16, 64, 64})) << "three of 21.8 kB and one of 1.4 kB";
    EXPECT_NE(some.warning(halved).find("1 texture was halved"), std::string::npos) << some.warning(halved);
}

TEST(MemoryBudget, AHalvedTextureIsTheNextLevel)
{
    const Texture whole("whole", image_of(64), true, {});
    for (const bool mipmaps : {true, false}) {
        // One is halved before it is made, and one afterwards.
        for (const bool before : {true, false}) {
            SharedList<Texture> textures;
            MemoryBudget budget(before ? 15'000 : 60'000);
            add(budget, textures, 64, mipmaps);
            if (!before) budget.take(45'000, textures, k_asker);
            ASSERT_EQ(textures[0].width(), 32) << before;
            EXPECT_EQ(textures[0].levels()[0].data, whole.levels()[1].data);
            EXPECT_EQ(textures[0].levels().size(), mipmaps ? whole.levels().size() - 1 : 1u);
            EXPECT_EQ(textures[0].sampler().mipmaps, mipmaps);
            EXPECT_NE(budget.warning(textures).find("1 texture was halved"), std::string::npos);
        }
    }
}

TEST(MemoryBudget, HoldsAtEveryMoment)
{
    for (const std::uint64_t bytes : {20'000, 50'000, 100'000, 200'000, 1'000'000}) {
        MemoryBudget budget(bytes);
        SharedList<Texture> textures;
        for (const int side : {64, 128, 16, 32, 128, 64, 1, 256}) {
            const std::uint64_t image = 3ull * static_cast<std::uint64_t>(side) * static_cast<std::uint64_t>(side);
            if (image > bytes) continue;
            add(budget, textures, side, true, image);
            EXPECT_LE(bytes_of(textures) + image, bytes) << side;
        }
    }
}

TEST(MemoryBudget, MakesRoomForWhatIsNeededForAMoment)
{
    MemoryBudget budget(100'000);
    SharedList<Texture> textures;
    add(budget, textures, 64);
    budget.make_room(70'000, textures, k_asker);
    EXPECT_EQ(textures[0].width(), 64);
    budget.make_room(75'000, textures, k_asker);
    EXPECT_EQ(textures[0].width(), 32);
    EXPECT_THROW(budget.make_room(100'001, textures, k_asker), InputError);
    budget.make_room(99'996, textures, k_asker);
    EXPECT_EQ(textures[0].width(), 1);
    EXPECT_THROW(budget.make_room(99'998, textures, k_asker), InputError) << "a texel cannot be halved";
}

TEST(MemoryBudget, HasRoomForWhatFitsBesideAllTextures)
{
    MemoryBudget budget(100'000);
    SharedList<Texture> textures;
    EXPECT_TRUE(budget.has_room(100'000));
    EXPECT_FALSE(budget.has_room(100'001));
    budget.take(10'000, textures, k_asker);
    EXPECT_TRUE(budget.has_room(90'000));
    EXPECT_FALSE(budget.has_room(90'001));
    add(budget, textures, 64);
    EXPECT_TRUE(budget.has_room(90'000 - bytes_of(textures)));
    EXPECT_FALSE(budget.has_room(90'001 - bytes_of(textures)));
    EXPECT_EQ(textures[0].width(), 64);
}

TEST(MemoryBudget, ForgetsTexturesThatAreLeftOut)
{
    MemoryBudget budget(120'000);
    SharedList<Texture> textures;
    budget.left_out(budget.expect(128, 128));
    add(budget, textures, 128);
    EXPECT_EQ(textures[0].width(), 128);
}

TEST(MemoryBudget, RefusesWhatDoesNotFitAndCountsItBesideTextures)
{
    MemoryBudget budget(110'000);
    SharedList<Texture> textures;
    budget.take(60'000, textures, {"a.gltf", "/accessors/1", "the keys"});
    EXPECT_THROW(budget.take(60'000, textures, {"a.gltf", "/accessors/2", "the keys"}), InputError);
    add(budget, textures, 128);   // 87 kB
    EXPECT_EQ(textures[0].width(), 64);
    budget.take(30'000, textures, {"a.gltf", "/accessors/3", "the keys"});
    EXPECT_EQ(textures[0].width(), 32);
}

}   // namespace
}   // namespace gnomon::scene
