// SPDX-License-Identifier: Apache-2.0
#include "scene/reduced_image.h"

#include <algorithm>
#include <array>
#include <span>

#include "base/check.h"
#include "base/interruption.h"
#include "base/math.h"

namespace gnomon::scene {

namespace {

inline glm::vec4 decode(const std::uint8_t* p, bool srgb)
{
    constexpr float scale = 1.0f / 255.0f;
    if (!srgb) return {p[0] * scale, p[1] * scale, p[2] * scale, p[3] * scale};
    static const float* const table = linear_from_srgb8();
    return {table[p[0]], table[p[1]], table[p[2]], p[3] * scale};
}

std::uint8_t encode8(float value, bool srgb)
{
    if (srgb) return srgb8_from_linear(value);
    return static_cast<std::uint8_t>(std::clamp(value * 255.0f + 0.5f, 0.0f, 255.0f));
}

constexpr std::size_t k_rgba = 4;

// Half of a side; an odd last row or column is merged with its neighbour.
int half_side(int side)
{
    return std::max(1, side / 2);
}

// The first of the rows (or columns) of a finer level that texel `i` of `half_side(fine)` covers; those of i + 1
// follow.
int first_of(int i, int fine)
{
    return i * fine / half_side(fine);
}

// One row of the next coarser level from the rows that it covers, with a box filter in linear light. Colour is weighted
// by alpha, so that transparent texels do not bleed into it.
void halve_row(std::span<const std::uint8_t* const> rows, int width, bool srgb, std::uint8_t* out)
{
    for (int x = 0; x < half_side(width); ++x) {
        const int x0 = first_of(x, width), x1 = std::max(x0 + 1, first_of(x + 1, width));
        glm::vec3 weighted(0), plain(0);
        float alpha = 0;
        for (const std::uint8_t* const row : rows)
            for (int i = x0; i < x1; ++i) {
                const glm::vec4 texel = decode(row + k_rgba * static_cast<std::size_t>(i), srgb);
                weighted += glm::vec3(texel) * texel.w;
                plain += glm::vec3(texel);
                alpha += texel.w;
            }
        const float count = static_cast<float>((x1 - x0) * static_cast<int>(rows.size()));
        const glm::vec3 color = alpha > 0 ? weighted / alpha : plain / count;
        for (int c = 0; c < 3; ++c) *out++ = encode8(color[c], srgb);
        *out++ = encode8(alpha / count, false);
    }
}

// The rows of an image as RGBA, halved any number of times. Each row that is asked for computes those of the finer
// levels that it covers and no other row does, so a level costs a few rows of each finer one.
class ReducedRows {
 public:
    ReducedRows(const Image8& image, bool srgb, int halvings, bool without_alpha)
        : image_(image), without_alpha_(without_alpha), srgb_(srgb)
    {
        levels_.push_back({image.width, image.height, {}});
        for (int i = 0; i < halvings; ++i) {
            Level& finer = levels_.back();
            finer.rows.resize(k_most_covered * static_cast<std::size_t>(finer.width) * k_rgba);
            levels_.push_back({half_side(finer.width), half_side(finer.height), {}});
        }
    }
    Image8 all()
    {
        const Level& coarsest = levels_.back();
        Image8 result(coarsest.width, coarsest.height, static_cast<int>(k_rgba));
        for (int y = 0; y < result.height; ++y) {
            interruption_point();
            row(levels_.size() - 1, y, result.pixel(0, y));
        }
        return result;
    }

 private:
    static constexpr std::size_t k_most_covered = 3;
    struct Level {
        int width, height;
        std::vector<std::uint8_t> rows;   // those that one row of the next level covers
    };
    void row(std::size_t level, int y, std::uint8_t* out)
    {
        if (level == 0) return convert(y, out);
        Level& finer = levels_[level - 1];
        const int y0 = first_of(y, finer.height), y1 = std::max(y0 + 1, first_of(y + 1, finer.height));
        std::array<const std::uint8_t*, k_most_covered> covered{};
        const auto count = static_cast<std::size_t>(y1 - y0);
        GNOMON_CHECK_LE(count, k_most_covered);
        for (std::size_t i = 0; i < count; ++i) {
            std::uint8_t* const to = &finer.rows[i * static_cast<std::size_t>(finer.width) * k_rgba];
            row(level - 1, y0 + static_cast<int>(i), to);
            covered[i] = to;
        }
        halve_row({covered.data(), count}, finer.width, srgb_, out);
    }
    // A row of the image as RGBA.
    void convert(int y, std::uint8_t* out) const
    {
        const bool grey = image_.channels <= 2, alpha = image_.channels % 2 == 0 && !without_alpha_;
        const std::uint8_t* in = image_.pixel(0, y);
        for (int x = 0; x < image_.width; ++x, in += image_.channels) {
            for (int c = 0; c < 3; ++c) *out++ = grey ? in[0] : in[c];
            *out++ = alpha ? in[image_.channels - 1] : 255;
        }
    }

    const Image8& image_;
    bool without_alpha_, srgb_;
    std::vector<Level> levels_;   // finest first
};

}   // namespace

Image8 reduced_rgba(const Image8& image, bool srgb, int halvings, bool without_alpha)
{
    GNOMON_CHECK(!image.empty());
    GNOMON_CHECK(image.channels >= 1 && image.channels <= 4);
    return ReducedRows(image, srgb, halvings, without_alpha).all();
}

}   // namespace gnomon::scene
