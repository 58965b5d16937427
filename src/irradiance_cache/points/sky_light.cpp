// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/sky_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/check.h"
#include "base/morton.h"

namespace gnomon::irradiance_cache {

namespace {

// A direction's place along a curve over the sphere.
std::uint64_t place_on_curve(const glm::dvec3& direction)
{
    constexpr std::uint64_t k_lower = std::uint64_t{1} << 32;
    const auto cell = [](double coordinate) {
        return static_cast<std::uint32_t>(std::clamp(16 + 16 * coordinate, 0.0, 31.0));
    };
    return morton_code(cell(direction.x), cell(direction.z)) + (direction.y > 0 ? 0 : k_lower);
}

}   // namespace

SkyLight::SkyLight(const scene::Background& background, std::size_t directions) : directions_(directions)
{
    GNOMON_CHECK(directions % 64 == 0 && directions <= k_sky_directions);
    scene::Background sky = background;
    sky.sun_radiance = glm::vec3(0);
    constexpr double k_golden = 2.399963229728653;   // radians; pi (3 - sqrt 5)
    const double solid_angle = 4 * k_pi / static_cast<double>(directions);
    std::vector<glm::dvec3> all;
    for (std::size_t i = 0; i < directions; ++i) {
        const double up = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(directions);
        const double across = std::sqrt(1 - up * up), angle = k_golden * static_cast<double>(i);
        all.emplace_back(across * std::cos(angle), up, across * std::sin(angle));
    }
    // Packets take rays in this order, and stay together if their directions do: the upper half, then the lower one,
    // each along a Morton curve.
    std::ranges::stable_sort(all, {}, place_on_curve);
    for (std::size_t i = 0; i < directions; ++i) {
        x_[i] = static_cast<float>(all[i].x);
        y_[i] = static_cast<float>(all[i].y);
        z_[i] = static_cast<float>(all[i].z);
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
