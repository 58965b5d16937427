// SPDX-License-Identifier: Apache-2.0
#include "scene/texture.h"

#include <algorithm>
#include <cmath>

#include "scene/reduced_image.h"

namespace gnomon::scene {

namespace {

// Reduces a coordinate to one period before it becomes a texel index, because large coordinates lose their fraction
// in 32 bits.
[[gnu::always_inline]] inline int wrap_texel(int i, int size, Wrap wrap)
{
    switch (wrap) {
        case Wrap::clamp:
            return std::clamp(i, 0, size - 1);
        case Wrap::mirror: {
            const int period = 2 * size;
            i %= period;
            if (i < 0) i += period;
            return i < size ? i : period - 1 - i;
        }
        case Wrap::repeat:
            break;
    }
    // After the reduction, i is at most one step outside.
    if (i < 0) i += size;
    if (i >= size) i -= size;
    return std::clamp(i, 0, size - 1);
}

float reduce(float x, Wrap wrap)
{
    if (!std::isfinite(x)) return 0;
    switch (wrap) {
        case Wrap::repeat:
            return x - std::floor(x);
        case Wrap::mirror:
            return x - 2 * std::floor(0.5f * x);
        case Wrap::clamp:
            break;
    }
    return std::clamp(x, -1.0f, 2.0f);
}

[[gnu::always_inline]] inline glm::vec4 decode(const std::uint8_t* p, bool srgb)
{
    constexpr float scale = 1.0f / 255.0f;
    if (!srgb) return {p[0] * scale, p[1] * scale, p[2] * scale, p[3] * scale};
    static const float* const table = linear_from_srgb8();
    return {table[p[0]], table[p[1]], table[p[2]], p[3] * scale};
}

[[gnu::always_inline]] inline float decode_alpha(const std::uint8_t* p)
{
    constexpr float scale = 1.0f / 255.0f;
    return p[3] * scale;
}

}   // namespace

Texture::Texture(std::string name, const Image8& image, bool srgb, Sampler sampler)
    : name_(std::move(name)), sampler_(sampler), srgb_(srgb)
{
    levels_.push_back(reduced_rgba(image, srgb, 0));
    const std::vector<std::uint8_t>& finest = levels_.front().data;
    for (std::size_t i = 3; i < finest.size() && !has_alpha_; i += 4) has_alpha_ = finest[i] != 255;
    if (sampler.mipmaps)
        while (levels_.back().width > 1 || levels_.back().height > 1)
            levels_.push_back(reduced_rgba(levels_.back(), srgb, 1));
}

std::size_t Texture::bytes() const
{
    std::size_t sum = 0;
    for (const Image8& level : levels_) sum += level.data.size();
    return sum;
}

glm::vec4 Texture::texel(const Image8& level, int x, int y) const
{
    return decode(
        level.pixel(wrap_texel(x, level.width, sampler_.wrap_u), wrap_texel(y, level.height, sampler_.wrap_v)), srgb_);
}

glm::vec4 Texture::nearest(const Image8& level, glm::vec2 uv) const
{
    return texel(level, static_cast<int>(std::floor(uv.x * level.width)),
                 static_cast<int>(std::floor(uv.y * level.height)));
}

glm::vec4 Texture::bilinear(const Image8& level, glm::vec2 uv) const
{
    const float x = uv.x * static_cast<float>(level.width) - 0.5f;
    const float y = uv.y * static_cast<float>(level.height) - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y);
    const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
    const float wx = x - fx, wy = y - fy;

    // Wrap each column and row once, then blend four texels.
    const int x0 = wrap_texel(ix, level.width, sampler_.wrap_u), x1 = wrap_texel(ix + 1, level.width, sampler_.wrap_u);
    const std::uint8_t* const upper = level.pixel(0, wrap_texel(iy, level.height, sampler_.wrap_v));
    const std::uint8_t* const lower = level.pixel(0, wrap_texel(iy + 1, level.height, sampler_.wrap_v));
    const glm::vec4 top = decode(upper + 4 * x0, srgb_) * (1 - wx) + decode(upper + 4 * x1, srgb_) * wx;
    const glm::vec4 bottom = decode(lower + 4 * x0, srgb_) * (1 - wx) + decode(lower + 4 * x1, srgb_) * wx;
    return top * (1 - wy) + bottom * wy;
}

// The last component of bilinear(), to the bit.
float Texture::bilinear_alpha(const Image8& level, glm::vec2 uv) const
{
    const float x = uv.x * static_cast<float>(level.width) - 0.5f;
    const float y = uv.y * static_cast<float>(level.height) - 0.5f;
    const float fx = std::floor(x), fy = std::floor(y);
    const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
    const float wx = x - fx, wy = y - fy;
    const int x0 = wrap_texel(ix, level.width, sampler_.wrap_u), x1 = wrap_texel(ix + 1, level.width, sampler_.wrap_u);
    const std::uint8_t* const upper = level.pixel(0, wrap_texel(iy, level.height, sampler_.wrap_v));
    const std::uint8_t* const lower = level.pixel(0, wrap_texel(iy + 1, level.height, sampler_.wrap_v));
    const float top = decode_alpha(upper + 4 * x0) * (1 - wx) + decode_alpha(upper + 4 * x1) * wx;
    const float bottom = decode_alpha(lower + 4 * x0) * (1 - wx) + decode_alpha(lower + 4 * x1) * wx;
    return top * (1 - wy) + bottom * wy;
}

glm::vec4 Texture::sample(glm::vec2 uv, float footprint) const
{
    uv = {reduce(uv.x, sampler_.wrap_u), reduce(uv.y, sampler_.wrap_v)};
    const auto look_up = [&](const Image8& level, Filter filter) {
        return filter == Filter::nearest ? nearest(level, uv) : bilinear(level, uv);
    };
    if (!(footprint > 1) || levels_.size() == 1)
        return look_up(levels_[0], footprint > 1 ? sampler_.minify : sampler_.magnify);

    // Blend the two levels whose texel sizes enclose the footprint.
    const float lod = std::min(std::log2(footprint), static_cast<float>(levels_.size() - 1));
    const auto fine = static_cast<std::size_t>(lod);
    const float blend = lod - static_cast<float>(fine);
    const glm::vec4 a = look_up(levels_[fine], sampler_.minify);
    if (blend == 0 || fine + 1 >= levels_.size()) return a;
    return a * (1 - blend) + look_up(levels_[fine + 1], sampler_.minify) * blend;
}

float Texture::alpha(glm::vec2 uv) const
{
    if (!has_alpha_) return 1;
    uv = {reduce(uv.x, sampler_.wrap_u), reduce(uv.y, sampler_.wrap_v)};
    return sampler_.magnify == Filter::nearest ? nearest(levels_[0], uv).w : bilinear_alpha(levels_[0], uv);
}

std::uint8_t Texture::alpha_texel(int x, int y) const
{
    const Image8& level = levels_[0];
    return level.pixel(wrap_texel(x, level.width, sampler_.wrap_u), wrap_texel(y, level.height, sampler_.wrap_v))[3];
}

glm::vec2 TextureUse::apply(glm::vec2 uv) const
{
    const glm::vec2 s = uv * scale;
    if (rotation == 0) return s + offset;
    const float c = std::cos(rotation), n = std::sin(rotation);
    return glm::vec2(c * s.x + n * s.y, -n * s.x + c * s.y) + offset;
}

}   // namespace gnomon::scene
