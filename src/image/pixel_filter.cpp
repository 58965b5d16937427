// SPDX-License-Identifier: Apache-2.0
#include "image/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/check.h"

namespace gnomon::image {

PixelFilter chosen_filter(PixelFilter filter, bool adaptive)
{
    if (filter != PixelFilter::automatic) return filter;
    return adaptive ? PixelFilter::blackman_harris : PixelFilter::box;
}

float filter_weight(PixelFilter filter, float distance)
{
    GNOMON_CHECK(filter != PixelFilter::automatic);
    const float d = std::abs(distance);
    if (filter == PixelFilter::box) return d <= 0.5f ? 1.0f : 0.0f;
    if (d >= k_filter_radius) return 0;
    if (filter == PixelFilter::gaussian) {
        // Of deviation 0.5, less its value at the radius, so that it ends without a step.
        const float end = std::exp(-2 * k_filter_radius * k_filter_radius);
        return std::exp(-2 * d * d) - end;
    }
    // The window of four terms [Harris 1978, Table I], as wide as the filter.
    const float turn = 2 * std::numbers::pi_v<float> * (0.5f + d / (2 * k_filter_radius));
    const float w =
        0.35875f - 0.48829f * std::cos(turn) + 0.14128f * std::cos(2 * turn) - 0.01168f * std::cos(3 * turn);
    return std::max(w, 0.0f);
}

float filter_place(PixelFilter filter, float number)
{
    if (filter == PixelFilter::box) return number - 0.5f;
    // Walk along the filter's integral.
    constexpr int k_steps = 512;
    constexpr float k_step = 2 * k_filter_radius / k_steps;
    const auto weight = [&](int i) {
        return filter_weight(filter, k_step * (static_cast<float>(i) + 0.5f) - k_filter_radius);
    };
    float all = 0;
    for (int i = 0; i < k_steps; ++i) all += weight(i);
    float left = std::clamp(number, 0.0f, 1.0f) * all;
    int i = 0;
    while (i + 1 < k_steps && left > weight(i)) left -= weight(i++);
    const float here = weight(i);
    return k_step * (static_cast<float>(i) + (here > 0 ? std::min(left / here, 1.0f) : 0.5f)) - k_filter_radius;
}

SampleWeights sample_weights(PixelFilter filter, const glm::vec2& offset)
{
    SampleWeights weights;
    for (int i = 0; i < 3; ++i) {
        const float away = static_cast<float>(i - 1) + 0.5f;
        weights.across[i] = filter_weight(filter, offset.x - away);
        weights.down[i] = filter_weight(filter, offset.y - away);
    }
    return weights;
}

SampleWeights lone_sample_weights(PixelFilter filter)
{
    if (filter == PixelFilter::box) return sample_weights(filter, glm::vec2(0.5f));
    // Integrate the filter.
    constexpr int k_steps = 1000;
    float sum = 0, square = 0;
    for (int i = 0; i < k_steps; ++i) {
        const float d = k_filter_radius * (2 * (static_cast<float>(i) + 0.5f) / k_steps - 1);
        const float w = filter_weight(filter, d) * (2 * k_filter_radius / k_steps);
        sum += w, square += w * d * d;
    }
    const float beside = square / 2;
    SampleWeights weights;
    for (int i = 0; i < 3; ++i) weights.across[i] = weights.down[i] = i == 1 ? sum - 2 * beside : beside;
    return weights;
}

SampleSums::SampleSums(Size size, int tile, int channels, float white)
{
    begin(size, tile, channels, white);
    std::ranges::fill(sums_, 0.0f);
}

void SampleSums::begin(Size size, int tile, int channels, float white)
{
    GNOMON_CHECK(tile > 0 && channels >= 3);
    size_ = size, side_ = tile, channels_ = channels, white_ = white;
    columns_ = (size.width + tile - 1) / tile, rows_ = (size.height + tile - 1) / tile;
    stride_ = static_cast<std::size_t>(channels) + 2;
    tile_floats_ = static_cast<std::size_t>(tile + 2) * static_cast<std::size_t>(tile + 2) * stride_;
    sums_.resize(tile_floats_ * static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
}

void SampleSums::clear(std::size_t tile)
{
    std::fill_n(sums_.data() + tile * tile_floats_, tile_floats_, 0.0f);
}

float SampleSums::add(std::size_t tile, int x, int y, const SampleWeights& weights, float share, const float* values,
                      LightWeight counts)
{
    const float light = luminance(glm::vec3(values[0], values[1], values[2]));
    const float dimmed = counts == LightWeight::shown && light > white_ ? white_ / light : 1.0f;

    // Add to the pixel and its neighbours. The border makes room for all of them.
    float* const first = sums_.data() + tile * tile_floats_ + static_cast<std::size_t>(y * (side_ + 2) + x) * stride_;
    const std::size_t row = static_cast<std::size_t>(side_ + 2) * stride_;
    const auto add_all = [&](int channels) {
        for (std::size_t dy = 0; dy < 3; ++dy)
            for (std::size_t dx = 0; dx < 3; ++dx) {
                const float weight = share * weights.across[dx] * weights.down[dy];
                if (weight == 0) continue;
                float* const to = first + dy * row + dx * (static_cast<std::size_t>(channels) + 2);
                const float of_color = weight * dimmed;
                for (int c = 0; c < 3; ++c) to[c] += of_color * values[c];
                for (int c = 3; c < channels; ++c) to[c] += weight * values[c];
                to[channels] += of_color;
                to[channels + 1] += weight;
            }
    };
    // Most images have colour alone; the compiler then knows how far apart pixels are.
    channels_ == 3 ? add_all(3) : add_all(channels_);
    return dimmed;
}

void SampleSums::add_light(std::size_t tile, int x, int y, const std::array<glm::vec3, 9>& light)
{
    float* const first = sums_.data() + tile * tile_floats_;
    for (int i = 0; i < 9; ++i) {
        float* to = first + static_cast<std::size_t>((y + i / 3) * (side_ + 2) + x + i % 3) * stride_;
        for (int c = 0; c < 3; ++c) to[c] += light[static_cast<std::size_t>(i)][c];
    }
}

// The sums that a tile holds for a pixel of the image; null if the pixel lies beyond its border.
const float* SampleSums::sums_of(int column, int row, int x, int y) const
{
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return nullptr;
    const int in_x = x - column * side_ + 1, in_y = y - row * side_ + 1;
    if (in_x < 0 || in_y < 0 || in_x >= side_ + 2 || in_y >= side_ + 2) return nullptr;
    const std::size_t tile =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    return sums_.data() + tile * tile_floats_ + static_cast<std::size_t>(in_y * (side_ + 2) + in_x) * stride_;
}

void SampleSums::resolve(std::size_t tile, const std::function<void(int x, int y, const float* values)>& sink) const
{
    const int column = static_cast<int>(tile) % columns_, row = static_cast<int>(tile) / columns_;
    const int x_end = std::min((column + 1) * side_, size_.width), y_end = std::min((row + 1) * side_, size_.height);
    std::vector<float> sum(stride_);
    for (int y = row * side_; y < y_end; ++y)
        for (int x = column * side_; x < x_end; ++x) {
            // Add what this tile and those around it hold, row by row.
            const bool inner =
                x > column * side_ && y > row * side_ && x + 1 < (column + 1) * side_ && y + 1 < (row + 1) * side_;
            if (inner) {
                const float* const from = sums_of(column, row, x, y);
                for (std::size_t k = 0; k < stride_; ++k) sum[k] = 0.0f + from[k];
            } else {
                std::fill(sum.begin(), sum.end(), 0.0f);
                for (int r = row - 1; r <= row + 1; ++r)
                    for (int c = column - 1; c <= column + 1; ++c)
                        if (const float* from = sums_of(c, r, x, y))
                            for (std::size_t k = 0; k < stride_; ++k) sum[k] += from[k];
            }
            const float color = sum[static_cast<std::size_t>(channels_)],
                        others = sum[static_cast<std::size_t>(channels_) + 1];
            for (int k = 0; k < channels_; ++k) {
                const float weight = k < 3 ? color : others;
                sum[static_cast<std::size_t>(k)] = weight > 0 ? sum[static_cast<std::size_t>(k)] / weight : 0;
            }
            sink(x, y, sum.data());
        }
}

}   // namespace gnomon::image
