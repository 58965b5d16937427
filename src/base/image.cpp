// SPDX-License-Identifier: Apache-2.0
#include "base/image.h"

#include <array>
#include <cmath>

namespace gnomon {

float srgb_from_linear(float linear)
{
    if (!(linear > 0.0f)) return 0.0f;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

float linear_from_srgb(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

const float* linear_from_srgb8()
{
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values{};
        for (int i = 0; i < 256; ++i) values[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
        return values;
    }();
    return table.data();
}

}   // namespace gnomon
