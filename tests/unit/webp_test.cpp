// SPDX-License-Identifier: Apache-2.0
// WebP images: exact where they are lossless, close where they are not, and refused where they are cut off or too
// large.
#include <gtest/gtest.h>
#include <webp/encode.h>

#include <cstdlib>
#include <fstream>

#include "gnomon/error.h"
#include "io/image/image_file.h"
#include "io/load.h"
#include "support.h"

namespace gnomon {
namespace {

Image8 pattern(int width, int height, int channels)
{
    Image8 image(width, height, channels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < channels; ++c)
                image.pixel(x, y)[c] =
                    static_cast<std::uint8_t>(c == 3 ? 128 + 100 * (x % 2) : 40 + 5 * x + 9 * y + 30 * c);
    return image;
}

std::vector<std::uint8_t> encoded(const Image8& image, bool lossless)
{
    std::uint8_t* bytes = nullptr;
    const int stride = image.width * image.channels;
    const std::uint8_t* const from = image.data.data();
    const std::size_t size = image.channels == 4
                                 ? (lossless ? WebPEncodeLosslessRGBA(from, image.width, image.height, stride, &bytes)
                                             : WebPEncodeRGBA(from, image.width, image.height, stride, 95, &bytes))
                                 : (lossless ? WebPEncodeLosslessRGB(from, image.width, image.height, stride, &bytes)
                                             : WebPEncodeRGB(from, image.width, image.height, stride, 95, &bytes));
    const std::vector<std::uint8_t> result(bytes, bytes + size);
    WebPFree(bytes);
    return result;
}

TEST(WebP, LosslessImagesAreExactAndOthersClose)
{
    for (const int channels : {3, 4}) {
        const Image8 image = pattern(19, 13, channels);
        const Image8 exact = io::decode_image(encoded(image, true), "a.webp");
        ASSERT_EQ(exact.channels, channels);
        EXPECT_EQ(exact.width, 19);
        EXPECT_EQ(exact.height, 13);
        EXPECT_EQ(exact.data, image.data);
        const Image8 lossy = io::decode_image(encoded(image, false), "a.webp");
        ASSERT_EQ(lossy.data.size(), image.data.size());
        double off = 0;
        for (std::size_t i = 0; i < image.data.size(); ++i) off += std::abs(lossy.data[i] - image.data[i]);
        EXPECT_LT(off / static_cast<double>(image.data.size()), 12);
        EXPECT_GT(off, 0);
    }
}

TEST(WebP, CutOffAndOversizedImagesAreRefused)
{
    const std::vector<std::uint8_t> bytes = encoded(pattern(64, 64, 3), true);
    for (const std::size_t size : {std::size_t{13}, std::size_t{20}, bytes.size() / 2, bytes.size() - 1}) {
        const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_THROW(io::decode_image(cut, "a.webp"), InputError) << size;
    }
    io::ImageLimits limits;
    limits.max_pixels = 64 * 64 - 1;
    EXPECT_THROW(io::decode_image(bytes, "a.webp", limits), InputError);
    limits.max_pixels = 64 * 64;
    EXPECT_EQ(io::decode_image(bytes, "a.webp", limits).width, 64);
}

TEST(WebP, TexturesOfGltfFilesMayBeWebP)
{
    const test::ScratchFolder folder;
    const std::vector<std::uint8_t> bytes = encoded(pattern(8, 8, 3), true);
    std::ofstream(folder / "t.webp", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};   // positions, texture coordinates
    std::ofstream(folder / "t.bin", std::ios::binary).write(reinterpret_cast<const char*>(corners), sizeof corners);
    std::ofstream(folder / "scene.gltf")
        << R"({"asset":{"version":"2.0"},"extensionsUsed":["EXT_texture_webp"],)"
           R"("extensionsRequired":["EXT_texture_webp"],"images":[{"uri":"t.webp"}],)"
           R"("textures":[{"extensions":{"EXT_texture_webp":{"source":0}}}],)"
           R"("materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],)"
           R"("buffers":[{"uri":"t.bin","byteLength":60}],"bufferViews":[{"buffer":0,"byteLength":36},)"
           R"({"buffer":0,"byteOffset":36,"byteLength":24}],"accessors":[{"bufferView":0,"componentType":5126,)"
           R"("type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5126,)"
           R"("type":"VEC2","count":3}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},)"
           R"("material":0}]}],"nodes":[{"mesh":0}]})";
    const scene::Scene scene = io::load_gltf(folder / "scene.gltf");
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
    ASSERT_EQ(scene.textures.size(), 1u);
    EXPECT_EQ(scene.textures[0].width(), 8);
    EXPECT_EQ(scene.textures[0].levels().front().pixel(3, 2)[0], 40 + 15 + 18);
}

}   // namespace
}   // namespace gnomon
