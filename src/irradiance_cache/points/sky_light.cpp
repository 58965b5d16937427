// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/sky_light.h"

#include <algorithm>
#include <bit>
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

// A spherical Fibonacci lattice.
std::vector<glm::dvec3> lattice_of(std::size_t count)
{
    constexpr double k_golden = 2.399963229728653;   // radians; pi (3 - sqrt 5)
    std::vector<glm::dvec3> all;
    for (std::size_t i = 0; i < count; ++i) {
        const double up = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
        const double across = std::sqrt(1 - up * up), angle = k_golden * static_cast<double>(i);
        all.emplace_back(across * std::cos(angle), up, across * std::sin(angle));
    }
    return all;
}

}   // namespace

SkyLight::SkyLight(const scene::Background& background, std::size_t directions, std::size_t parts)
    : directions_(directions)
{
    GNOMON_CHECK(directions % 64 == 0 && directions <= k_sky_directions);
    scene::Background sky = background;
    sky.sun_radiance = glm::vec3(0);
    const double solid_angle = 4 * k_pi / static_cast<double>(directions);
    std::vector<glm::dvec3> all = lattice_of(directions);
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
    if (any_ && parts > 1) make_parts(sky, parts * directions);
}

// Gives each direction of a finer lattice to the nearest of this one. The second nearest is beside it.
void SkyLight::make_parts(const scene::Background& sky, std::size_t count)
{
    const double solid_angle = 4 * k_pi / static_cast<double>(count);
    std::vector<std::vector<Part>> of(directions_);
    beside_.resize(directions_);
    double least = 1;
    for (const glm::dvec3& fine : lattice_of(count)) {
        std::size_t nearest = 0, second = 0;
        double first_cosine = -2, second_cosine = -2;
        for (std::size_t i = 0; i < directions_; ++i) {
            const double cosine = glm::dot(fine, glm::dvec3(direction(i)));
            if (cosine > first_cosine) {
                second = nearest, second_cosine = first_cosine;
                nearest = i, first_cosine = cosine;
            } else if (cosine > second_cosine) {
                second = i, second_cosine = cosine;
            }
        }
        const glm::vec3 direction(fine);
        of[nearest].push_back({direction, sky.radiance(direction) * static_cast<float>(solid_angle)});
        beside_[nearest].set(second), beside_[second].set(nearest);
        least = std::min(least, first_cosine);
    }
    part_angle_ = static_cast<float>(std::acos(least)) + 1e-3f;
    // A direction's light is that of its parts.
    for (std::size_t i = 0; i < directions_; ++i) {
        GNOMON_CHECK(!of[i].empty() && of[i].size() <= k_most_sky_parts);
        parts_.insert(parts_.end(), of[i].begin(), of[i].end());
        first_part_[i + 1] = static_cast<std::uint32_t>(parts_.size());
        light_[i] = glm::vec3(0);
        for (const Part& part : of[i]) light_[i] += part.light;
    }
}

SkyMask SkyLight::edges(const SkyMask& all, const SkyMask& seen) const
{
    const SkyMask unseen = all.without(seen);
    SkyMask edges;
    all.for_each([&](std::size_t i) {
        if (beside_[i].common(seen.test(i) ? unseen : seen) > 0) edges.set(i);
    });
    return edges;
}

void SkyLight::take_back(const SkyMask& all, const SkyMask& seen, std::vector<DividedDirection>& divided) const
{
    SkyMask back;
    const auto entry = [&](std::size_t i) {
        return std::ranges::lower_bound(divided, i, {}, &DividedDirection::direction);
    };
    for (const DividedDirection& alone : divided) {
        const std::size_t i = alone.direction;
        const bool is_seen = seen.test(i);
        const SkyMask same = is_seen ? seen : all.without(seen);
        if (beside_[i].common(same) > 0) continue;
        // Count the parts like it of those beside it that have no other direction like it beside them.
        std::size_t like = 0;
        SkyMask own;
        own.set(i);
        (beside_[i] & all).for_each([&](std::size_t other) {
            if (beside_[other].common(same) == 1) own.set(other);
        });
        own.for_each([&](std::size_t other) {
            const auto bits = static_cast<std::size_t>(std::popcount(entry(other)->seen));
            like += is_seen ? bits : parts(other).size() - bits;
        });
        if (like < parts(i).size()) back |= own;
    }
    std::erase_if(divided, [&](const DividedDirection& d) { return back.test(d.direction); });
}

SkyMask SkyLight::towards(const glm::vec3& at, float radius, bool or_part) const
{
    // Select the directions within the angle whose sine is radius over distance; inside the sphere, all.
    const float square = glm::dot(at, at) - radius * radius;
    float least = square > 0 ? std::sqrt(square) : -k_infinity;
    if (or_part) least = std::cos(part_angle_) * least - std::sin(part_angle_) * radius;
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
