// SPDX-License-Identifier: Apache-2.0
#include "io/image/hdr.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "gnomon/error.h"

namespace gnomon::io {

namespace {
constexpr std::string_view k_starts[] = {"#?RADIANCE", "#?RGBE"};
constexpr std::size_t k_longest_line = 4096;
constexpr int k_most_lines = 1000;
constexpr int k_narrowest_run_length = 8,
              k_widest_run_length = 0x7fff;   // widths that the newer run-length scheme supports
constexpr int k_exponent_bias = 128 + 8;      // the exponent's bias, and the mantissa's eight bits

class Decoder {
 public:
    Decoder(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits)
        : bytes_(bytes), name_(name), limits_(limits)
    {
    }

    ImageF decode()
    {
        read_header();
        read_resolution();
        // The shortest possible row: one pixel, then a run.
        const std::size_t shortest_row = width_ == 1 ? 4 : 8;
        if (left() / shortest_row < static_cast<std::size_t>(height_))
            fail(fmt::format("{} rows cannot be in {} bytes", height_, left()));
        ImageF image(width_, height_, 3);
        row_.resize(static_cast<std::size_t>(width_) * 4);
        for (int y = 0; y < height_; ++y) {
            read_row();
            convert(image.pixel(0, y));
        }
        return image;
    }

 private:
    [[noreturn]] void fail(const std::string& what) const
    {
        throw InputError(name_, fmt::format("byte {}", at_), what);
    }
    std::size_t left() const { return bytes_.size() - at_; }
    const std::uint8_t* take(std::size_t count)
    {
        if (count > left()) fail("the file ends too early");
        at_ += count;
        return bytes_.data() + at_ - count;
    }
    std::string_view line()
    {
        const char* begin = reinterpret_cast<const char*>(bytes_.data()) + at_;
        const std::string_view rest(begin, std::min(left(), k_longest_line));
        const std::size_t end = rest.find('\n');
        if (end == std::string_view::npos) fail("a line is not terminated");
        at_ += end + 1;
        return rest.substr(0, end);
    }

    // Read variables until an empty line.
    void read_header()
    {
        if (!is_hdr(bytes_)) fail("not a Radiance image");
        line();
        for (int count = 0;; ++count) {
            if (count == k_most_lines) fail("the header has no end");
            const std::string_view text = line();
            if (text.empty()) break;
            constexpr std::string_view format = "FORMAT=", exposure = "EXPOSURE=";
            if (text.starts_with(format) && text.substr(format.size()) != "32-bit_rle_rgbe")
                fail(fmt::format("format '{}' is not supported", text.substr(format.size())));
            if (text.starts_with(exposure)) {
                const std::string value(text.substr(exposure.size()));
                char* end = nullptr;
                const double factor = std::strtod(value.c_str(), &end);
                if (end == value.c_str() || !std::isfinite(factor) || !(factor > 0)) fail("the exposure is invalid");
                exposure_ *= factor;
                if (!std::isfinite(1 / exposure_) || !std::isfinite(exposure_)) fail("the exposure is invalid");
            }
        }
    }

    // Parse "-Y height +X width".
    void read_resolution()
    {
        std::string_view text = line();
        const auto number_after = [&](std::string_view axis) {
            if (!text.starts_with(axis)) fail("expected '-Y height +X width'");
            text.remove_prefix(axis.size());
            int value = 0;
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            if (error != std::errc() || value < 1) fail("expected '-Y height +X width'");
            text.remove_prefix(static_cast<std::size_t>(end - text.data()));
            return value;
        };
        height_ = number_after("-Y ");
        width_ = number_after(" +X ");
        if (!text.empty()) fail("expected '-Y height +X width'");
        const auto pixels = static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height_);
        if (width_ > limits_.max_side || height_ > limits_.max_side || pixels > limits_.max_pixels)
            fail(fmt::format("{} x {} pixels are more than allowed", width_, height_));
    }

    // Read a row in either scheme: rows of the newer begin with 2 2 and the width.
    void read_row()
    {
        const std::uint8_t* start = bytes_.data() + at_;
        if (width_ >= k_narrowest_run_length && width_ <= k_widest_run_length && left() >= 4 && start[0] == 2 &&
            start[1] == 2 && start[2] < 128) {
            if ((start[2] << 8 | start[3]) != width_) fail("a row has another width");
            take(4);
            for (std::size_t c = 0; c < 4; ++c) read_component(c);
        } else {
            read_pixels();
        }
    }

    // Read one of the four bytes of all pixels: runs and literals.
    void read_component(std::size_t c)
    {
        constexpr int run_flag = 128;
        const auto width = static_cast<std::size_t>(width_);
        for (std::size_t x = 0; x < width;) {
            const int code = *take(1);
            const auto count = static_cast<std::size_t>(code > run_flag ? code - run_flag : code);
            if (count == 0 || count > width - x) fail("a run exceeds the row");
            const bool run = code > run_flag;
            const std::uint8_t* from = take(run ? 1 : count);
            for (std::size_t i = 0; i < count; ++i, ++x) row_[x * 4 + c] = from[run ? 0 : i];
        }
    }

    // Read pixel by pixel; 1 1 1 n repeats the previous pixel n times, and directly following repeats count 256-fold.
    void read_pixels()
    {
        const auto width = static_cast<std::size_t>(width_);
        int shift = 0;
        for (std::size_t x = 0; x < width;) {
            const std::uint8_t* p = take(4);
            if (p[0] == 1 && p[1] == 1 && p[2] == 1) {
                constexpr int last_shift = 16;
                if (x == 0 || shift > last_shift) fail("a run has no pixel to repeat");
                const std::size_t count = static_cast<std::size_t>(p[3]) << shift;
                if (count > width - x) fail("a run exceeds the row");
                for (std::size_t i = 0; i < count; ++i, ++x) std::memcpy(&row_[x * 4], &row_[x * 4 - 4], 4);
                shift += 8;
            } else {
                std::memcpy(&row_[x * 4], p, 4);
                ++x;
                shift = 0;
            }
        }
    }

    void convert(float* to) const
    {
        for (std::size_t x = 0; x < static_cast<std::size_t>(width_); ++x) {
            const std::uint8_t* p = &row_[x * 4];
            const double scale = p[3] == 0 ? 0.0 : std::ldexp(1 / exposure_, p[3] - k_exponent_bias);
            for (int c = 0; c < 3; ++c) to[x * 3 + static_cast<std::size_t>(c)] = static_cast<float>(p[c] * scale);
        }
    }

    std::span<const std::uint8_t> bytes_;
    const std::string& name_;
    const FloatImageLimits& limits_;
    std::size_t at_ = 0;
    int width_ = 0, height_ = 0;
    double exposure_ = 1;
    std::vector<std::uint8_t> row_;   // RGBE
};
}   // namespace

bool is_hdr(std::span<const std::uint8_t> bytes)
{
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.starts_with(k_starts[0]) || text.starts_with(k_starts[1]);
}

ImageF decode_hdr(std::span<const std::uint8_t> bytes, const std::string& name, const FloatImageLimits& limits)
{
    return Decoder(bytes, name, limits).decode();
}

}   // namespace gnomon::io
