// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/sky_light.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"

namespace gnomon::irradiance_cache {

SkyLight::SkyLight(const scene::Background& background, std::size_t directions) : directions_(directions)
{
    GNOMON_CHECK(directions % 64 == 0 && directions <= k_sky_directions);
    scene::Background sky = background;
    sky.sun_radiance = glm::vec3(0);
    constexpr double k_golden = 2.399963229728653;   // radians; pi (3 - sqrt 5)
    const double solid_angle = 4 * k_pi / static_cast<double>(directions);
    for (std::size_t i = 0; i < directions; ++i) {
        const double up = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(directions);
        const double across = std::sqrt(1 - up * up), angle = k_golden * static_cast<double>(i);
        x_[i] = static_cast<float>(across * std::cos(angle));
        y_[i] = static_cast<float>(up);
        z_[i] = static_cast<float>(across * std::sin(angle));
        if (background.kind != scene::Background::Kind::sky) continue;
        light_[i] = sky.radiance(direction(i)) * static_cast<float>(solid_angle);
        any_ = any_ || light_[i] != glm::vec3(0);
    }
}

SkyMask SkyLight::towards(const glm::vec3& at, float radius) const
{
    // Select the directions within the angle whose sine is radius over distance; inside the sphere, all.
    const float square = glm::dot(at, at) - radius * radius;
    const float least = square > 0 ? std::sqrt(square) : -k_infinity;
    SkyMask mask;
    for (std::size_t w = 0; w < directions_ / 64; ++w) {
        std::array<std::uint8_t, 64> in{};
        for (std::size_t k = 0; k < 64; ++k) {
            const std::size_t i = 64 * w + k;
            in[k] = static_cast<std::uint8_t>(x_[i] * at.x + y_[i] * at.y + z_[i] * at.z >= least);
        }
        for (std::size_t k = 0; k < 64; ++k) mask.bits[w] |= static_cast<std::uint64_t>(in[k]) << k;
    }
    return mask;
}

}   // namespace gnomon::irradiance_cache
