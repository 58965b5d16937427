// SPDX-License-Identifier: Apache-2.0
// Layers converted into memory of the caller's: formats, strides, and every misuse.
#include "api/outputs.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "base/half.h"
#include "gnomon/gnomon.h"

namespace gnomon {
namespace {

constexpr Size k_size{37, 22};
constexpr std::size_t k_pixels = 37 * 22;
constexpr std::byte k_untouched{0xa5};

class Outputs : public testing::Test {
 protected:
    static void SetUpTestSuite()
    {
        RenderOptions options;
        options.size = k_size;
        options.layers = options.ids = options.motion = true;
        options.indirect = Indirect::off;
        frame_ = new Frame(Renderer(options).render(load("builtin:cornell"), 3));
    }
    static void TearDownTestSuite() { delete frame_; }
    static const Frame& frame() { return *frame_; }
    static void write(const std::vector<Output>& outputs, int threads = 2)
    {
        Tasks tasks(threads);
        write_outputs(frame(), outputs, tasks);
    }
    // The message of the error; empty if there is none.
    static std::string refusal(const Output& output)
    {
        try {
            write({output});
            return {};
        } catch (const UsageError& error) {
            return error.what();
        }
    }

 private:
    static inline Frame* frame_ = nullptr;
};

TEST_F(Outputs, FloatsAreTheLayersBytes)
{
    std::vector<float> color(3 * k_pixels), depth(k_pixels), green(k_pixels);
    std::vector<std::uint32_t> ids(2 * k_pixels), materials(k_pixels);
    write({{"", PixelFormat::f32, color.data(), 0, 0, color.size() * 4},
           {"depth", PixelFormat::f32, depth.data(), 0, 0, depth.size() * 4},
           {"albedo.G", PixelFormat::f32, green.data(), 0, 0, green.size() * 4},
           {"id", PixelFormat::u32, ids.data(), 0, 0, ids.size() * 4},
           {"id.material", PixelFormat::u32, materials.data(), 0, 0, materials.size() * 4}});
    EXPECT_EQ(color, frame().layers[0].copy());
    EXPECT_EQ(depth, frame().layer("depth")->copy());
    const std::span<const std::uint32_t> own = frame().layer("id")->ids();
    EXPECT_TRUE(std::equal(ids.begin(), ids.end(), own.begin(), own.end()));
    for (int y = 0; y < k_size.height; ++y)
        for (int x = 0; x < k_size.width; ++x) {
            const auto at = static_cast<std::size_t>(y * k_size.width + x);
            EXPECT_EQ(green[at], frame().layer("albedo")->value(x, y, 1));
            EXPECT_EQ(materials[at], frame().layer("id")->id(x, y, 1));
        }
}

TEST_F(Outputs, HalvesAndBytesOfAnyThreadCount)
{
    for (const int threads : {1, 3}) {
        std::vector<std::uint16_t> half(3 * k_pixels);
        std::vector<std::uint8_t> shown(4 * k_pixels);
        write({{"", PixelFormat::f16, half.data(), 0, 0, half.size() * 2},
               {"", PixelFormat::rgba8, shown.data(), 0, 0, shown.size()}},
              threads);
        const std::vector<float> color = frame().layers[0].copy();
        const std::vector<std::uint8_t> rgb = frame().to_srgb8();
        for (std::size_t i = 0; i < color.size(); ++i) {
            ASSERT_EQ(half[i], half_from_float(color[i]));
            ASSERT_EQ(shown[i / 3 * 4 + i % 3], rgb[i]);
        }
        for (std::size_t i = 0; i < k_pixels; ++i) ASSERT_EQ(shown[4 * i + 3], 255);
    }
}

// Colour and depth interleaved in one structure with padding, rows with padding, the lowest row first, unaligned.
TEST_F(Outputs, StridesLeaveOtherBytesAlone)
{
    constexpr std::ptrdiff_t k_step = 24, k_row = 37 * 24 + 13;
    std::vector<std::byte> memory(static_cast<std::size_t>(k_row) * 22 + 1, k_untouched);
    std::byte* const base = memory.data() + 1;
    const std::size_t bytes = memory.size() - 1;
    write({{"", PixelFormat::f32, base, k_step, -k_row, bytes},
           {"depth", PixelFormat::f32, base + 16, k_step, -k_row, bytes - 16}});
    std::size_t written = 0;
    for (int y = 0; y < k_size.height; ++y)
        for (int x = 0; x < k_size.width; ++x) {
            const std::byte* at = base + (k_size.height - 1 - y) * k_row + x * k_step;
            for (int c = 0; c < 4; ++c) {
                float value;
                std::memcpy(&value, at + (c == 3 ? 16 : 4 * c), sizeof value);
                ASSERT_EQ(value, c == 3 ? frame().layer("depth")->value(x, y) : frame().layers[0].value(x, y, c));
                written += 4;
            }
            for (const int gap : {12, 13, 14, 15, 20, 21, 22, 23}) ASSERT_EQ(at[gap], k_untouched);
        }
    const auto same = static_cast<std::size_t>(std::count(memory.begin(), memory.end(), k_untouched));
    EXPECT_GE(same, memory.size() - written);
    EXPECT_EQ(memory.front(), k_untouched);
}

TEST_F(Outputs, NeedNoMoreThanTheLastPixel)
{
    const std::size_t least = 22 * 37 * 8 - 4;   // the padding of the last pixel is not needed
    std::vector<std::byte> memory(least, k_untouched);
    EXPECT_EQ(refusal({"depth", PixelFormat::f32, memory.data(), 8, 37 * 8, least}), "");
    EXPECT_EQ(refusal({"depth", PixelFormat::f32, memory.data(), 8, 37 * 8, least - 1}),
              "output 'depth': 6507 bytes are too few for 37 x 22 pixels at these strides");
}

TEST_F(Outputs, MisuseIsAnErrorAndWritesNothing)
{
    std::vector<std::byte> memory(16 * k_pixels, k_untouched);
    void* const data = memory.data();
    const std::size_t bytes = memory.size();
    constexpr std::ptrdiff_t most = std::numeric_limits<std::ptrdiff_t>::max(),
                             least = std::numeric_limits<std::ptrdiff_t>::min();
    const auto f32 = PixelFormat::f32;
    const std::vector<Output> wrong = {
        {"depths", f32, data, 0, 0, bytes},
        {"depth.X", f32, data, 0, 0, bytes},
        {"depth", f32, nullptr, 0, 0, bytes},
        {"depth", f32, data, 0, 0, 0},
        {"depth", f32, data, 0, 0, 4 * k_pixels - 1},
        {"depth", f32, data, 3, 0, bytes},
        {"depth", f32, data, -4, 0, bytes},
        {"depth", f32, data, 4, 37 * 4 - 1, bytes},
        {"depth", f32, data, 4, -(37 * 4 - 1), bytes},
        {"depth", f32, data, most, 0, bytes},
        {"depth", f32, data, most / 36, 0, std::numeric_limits<std::size_t>::max()},
        {"depth", f32, data, 4, most, bytes},
        {"depth", f32, data, 4, least, bytes},
        {"depth", f32, data, least, 0, bytes},
        {"depth", PixelFormat::u32, data, 0, 0, bytes},
        {"depth", PixelFormat::rgba8, data, 0, 0, bytes},
        {"normal", PixelFormat::rgba8, data, 0, 0, bytes},
        {"albedo.R", PixelFormat::rgba8, data, 0, 0, bytes},
        {"id", f32, data, 0, 0, bytes},
        {"id", PixelFormat::f16, data, 0, 0, bytes},
        {"id", PixelFormat::rgba8, data, 0, 0, bytes},
        {"depth", static_cast<PixelFormat>(99), data, 0, 0, bytes},
    };
    const Output good{"depth", f32, data, 0, 0, bytes};
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        EXPECT_NE(refusal(wrong[i]), "") << i;
        EXPECT_THROW(write({good, wrong[i]}), UsageError) << i;
    }
    EXPECT_EQ(static_cast<std::size_t>(std::count(memory.begin(), memory.end(), k_untouched)), memory.size());
    EXPECT_EQ(refusal({"depths", f32, data, 0, 0, bytes}),
              "output 'depths': no such layer; beside the image there are: id, motion, depth, normal, albedo, direct, "
              "shadow");
    EXPECT_NO_THROW(write({good}));
}

TEST_F(Outputs, AreCheckedBeforeTheFrame)
{
    std::vector<float> depth(k_pixels);
    const Output good{"depth", PixelFormat::f32, depth.data(), 0, 0, 4 * k_pixels};
    EXPECT_NO_THROW(check_outputs({&good, 1}, k_size));
    EXPECT_THROW(check_outputs({&good, 1}, Size{38, 22}), UsageError);
    const Output none{"depth", PixelFormat::f32, nullptr, 0, 0, 4 * k_pixels};
    EXPECT_THROW(check_outputs({&none, 1}, k_size), UsageError);
}

}   // namespace
}   // namespace gnomon
