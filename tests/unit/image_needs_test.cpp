// SPDX-License-Identifier: Apache-2.0
// What decoding an image takes is known from its header: never more than image_needs() says, and for decoders that hold
// more than the pixels not only those.
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>
#include <webp/encode.h>

#include <fstream>

#include "image_bytes.h"
#include "io/image/image_file.h"
#include "sanitized.h"
#include "support.h"

namespace gnomon::io {
namespace {

using Bytes = std::vector<std::uint8_t>;

// A line of /proc/self/status in bytes.
std::uint64_t status(const std::string& line)
{
    std::ifstream file("/proc/self/status");
    for (std::string word; file >> word;) {
        std::uint64_t kilobytes = 0;
        if (word == line + ":" && file >> kilobytes) return kilobytes << 10;
    }
    return 0;
}

// The memory that decoding takes at most, measured by a process of its own.
std::uint64_t peak_of_decoding(const Bytes& file)
{
    int ends[2];
    if (::pipe(ends) != 0) return 0;
    const pid_t child = ::fork();
    if (child == 0) {
        ::malloc_trim(0);                                // memory that is free, but held, would not be seen
        std::ofstream("/proc/self/clear_refs") << "5";   // the peak begins here
        const std::uint64_t before = status("VmRSS");
        {
            const Image8 image = decode_image(file, "t");
            const std::uint64_t more = status("VmHWM") - before;
            if (::write(ends[1], &more, sizeof more) != sizeof more) ::_exit(1);
        }
        ::_exit(0);
    }
    std::uint64_t peak = 0;
    EXPECT_EQ(::read(ends[0], &peak, sizeof peak), static_cast<ssize_t>(sizeof peak));
    ::waitpid(child, nullptr, 0);
    ::close(ends[0]);
    ::close(ends[1]);
    return peak;
}

constexpr int k_side = 1600;
constexpr std::uint64_t k_pixels = std::uint64_t{k_side} * k_side;

Bytes webp_of(int channels, bool lossless)
{
    Bytes pixels(k_pixels * static_cast<std::uint64_t>(channels));
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>((i >> 12) * 37 + i % 5);
    std::uint8_t* out = nullptr;
    const int stride = k_side * channels;
    std::size_t size = 0;
    if (channels == 4)
        size = lossless ? WebPEncodeLosslessRGBA(pixels.data(), k_side, k_side, stride, &out)
                        : WebPEncodeRGBA(pixels.data(), k_side, k_side, stride, 50, &out);
    else
        size = lossless ? WebPEncodeLosslessRGB(pixels.data(), k_side, k_side, stride, &out)
                        : WebPEncodeRGB(pixels.data(), k_side, k_side, stride, 50, &out);
    Bytes bytes(out, out + size);
    WebPFree(out);
    return bytes;
}

TEST(ImageNeeds, AreNeverExceededByTheDecoder)
{
    if (test::k_sanitized) GTEST_SKIP() << "the sanitizer needs memory itself";
    const Bytes row(static_cast<std::size_t>(k_side) * 8, 99);
    const auto png = [&](int depth, int type, bool interlaced) {
        return test::png_bytes(
            {.width = k_side, .height = k_side, .depth = depth, .type = type, .interlaced = interlaced}, {row});
    };
    const auto jpeg = [&](J_COLOR_SPACE space, int channels, bool progressive) {
        return test::jpeg_bytes({k_side, k_side, space, channels, progressive}, row);
    };
    Bytes ppm;
    for (const char c : "P6 1600 1600 255 ") ppm.push_back(static_cast<std::uint8_t>(c));
    ppm.back() = 0;
    ppm.resize(ppm.size() + 3 * k_pixels, 7);
    struct Case {
        const char* what;
        Bytes file;
        int channels;
        std::uint64_t more;   // bytes per pixel that the decoder is known to hold beside the pixels
    };
    const Case cases[] = {
        {"grey PNG", png(8, PNG_COLOR_TYPE_GRAY, false), 1, 0},
        {"16-bit RGBA PNG", png(16, PNG_COLOR_TYPE_RGB_ALPHA, false), 4, 0},
        {"interlaced RGB PNG", png(8, PNG_COLOR_TYPE_RGB, true), 3, 0},
        {"JPEG", jpeg(JCS_RGB, 3, false), 3, 0},
        {"progressive JPEG", jpeg(JCS_RGB, 3, true), 3, 2},
        {"progressive grey JPEG", jpeg(JCS_GRAYSCALE, 1, true), 1, 2},
        {"CMYK JPEG", jpeg(JCS_CMYK, 4, false), 3, 4},
        {"lossy WebP", webp_of(3, false), 3, 0},
        {"lossy WebP with alpha", webp_of(4, false), 4, 1},
        {"lossless WebP", webp_of(3, true), 3, 4},
        {"lossless WebP with alpha", webp_of(4, true), 4, 4},
        {"PPM", ppm, 3, 0},
    };
    constexpr std::uint64_t k_small = 2 << 20;   // tables and code that is used for the first time
    for (const Case& c : cases) {
        const ImageNeeds needs = image_needs(c.file, "t");
        const std::uint64_t peak = peak_of_decoding(c.file), pixels = k_pixels * static_cast<std::uint64_t>(c.channels);
        std::printf("%-26s pixels %5.1f MB, needs %5.1f MB, measured %5.1f MB\n", c.what,
                    1e-6 * static_cast<double>(pixels), 1e-6 * static_cast<double>(needs.bytes),
                    1e-6 * static_cast<double>(peak));
        EXPECT_EQ(needs.width, k_side) << c.what;
        EXPECT_EQ(needs.height, k_side) << c.what;
        EXPECT_EQ(needs.channels, c.channels) << c.what;
        EXPECT_LE(peak, needs.bytes + k_small) << c.what;
        EXPECT_GE(peak + k_small, pixels + c.more * k_pixels) << c.what << ": the measurement misses memory";
    }
}

}   // namespace
}   // namespace gnomon::io
