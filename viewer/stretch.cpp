// SPDX-License-Identifier: Apache-2.0
#include "viewer/stretch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gnomon::viewer {

namespace {

constexpr std::uint16_t k_whole = 128;   // so that weighted bytes fit in 16 bits

std::uint8_t mix(std::uint8_t first, std::uint8_t second, std::uint16_t weight)
{
    return static_cast<std::uint8_t>(
        static_cast<std::uint16_t>(first * (k_whole - weight) + second * weight + k_whole / 2) / k_whole);
}

}   // namespace

// By output pixel, from the middle of the first image pixel to that of the last.
std::vector<Stretcher::Between> Stretcher::places(int from, int to)
{
    std::vector<Between> places;
    places.reserve(static_cast<std::size_t>(to));
    for (int i = 0; i < to; ++i) {
        const double at = std::clamp((i + 0.5) * from / to - 0.5, 0.0, from - 1.0);
        const auto first = static_cast<std::size_t>(at);
        const auto weight = static_cast<std::uint16_t>(std::lround((at - std::floor(at)) * k_whole));
        places.push_back({first, std::min(first + 1, static_cast<std::size_t>(from) - 1), weight});
    }
    return places;
}

void Stretcher::stretch_row(const std::uint8_t* row, std::vector<std::uint8_t>& to) const
{
    std::uint8_t* bgra = to.data();
    for (const Between& at : across_) {
        const std::uint8_t *const first = row + 3 * at.first, *const second = row + 3 * at.second;
        for (int channel = 0; channel < 3; ++channel)
            bgra[channel] = mix(first[2 - channel], second[2 - channel], at.weight);
        bgra[3] = 255;
        bgra += 4;
    }
}

const std::vector<std::uint8_t>& Stretcher::stretched(const Image8& image, Size size)
{
    const std::size_t stride = 3 * static_cast<std::size_t>(image.width);
    const std::size_t bytes = 4 * static_cast<std::size_t>(size.width);
    across_ = places(image.width, size.width);
    upper_.resize(bytes), lower_.resize(bytes);
    out_.resize(bytes * static_cast<std::size_t>(size.height));
    // Stretch each row of the image across once, and mix two of them for each row of the output.
    const std::size_t none = static_cast<std::size_t>(-1);
    std::size_t upper = none, lower = none;
    std::uint8_t* out = out_.data();
    for (const Between& at : places(image.height, size.height)) {
        if (upper != at.first) {
            if (lower == at.first)
                upper_.swap(lower_), std::swap(upper, lower);
            else
                stretch_row(image.data.data() + stride * at.first, upper_);
            upper = at.first;
        }
        if (lower != at.second) {
            stretch_row(image.data.data() + stride * at.second, lower_);
            lower = at.second;
        }
        const std::uint8_t *const a = upper_.data(), *const b = lower_.data();
        const std::uint16_t weight = at.weight;
        for (std::size_t i = 0; i < bytes; ++i) out[i] = mix(a[i], b[i], weight);
        out += bytes;
    }
    return out_;
}

}   // namespace gnomon::viewer
