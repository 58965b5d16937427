// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of the sky from a fixed set of directions. Which of them a point sees past static geometry is one bit each,
// and a dynamic object can hide only those within the cone of its bounding sphere.
//
// Each direction represents an equal solid angle (a spherical Fibonacci lattice) with the radiance of the sky's
// gradient. The sun is a light of its own, and environment images are lights, too (scene/environment.h).

#include <array>
#include <cstdint>

#include "scene/light.h"

namespace gnomon::irradiance_cache {

inline constexpr std::size_t k_sky_directions = 512;   // at most

/// A bit per direction.
struct SkyMask {
    std::array<std::uint64_t, k_sky_directions / 64> bits{};
    void set(std::size_t i) { bits[i / 64] |= std::uint64_t{1} << (i % 64); }
    bool any() const
    {
        for (const std::uint64_t word : bits)
            if (word != 0) return true;
        return false;
    }
    SkyMask operator&(const SkyMask& other) const
    {
        SkyMask both;
        for (std::size_t w = 0; w < bits.size(); ++w) both.bits[w] = bits[w] & other.bits[w];
        return both;
    }
    void operator|=(const SkyMask& other)
    {
        for (std::size_t w = 0; w < bits.size(); ++w) bits[w] |= other.bits[w];
    }
    /// Calls body(i) for every set bit, in rising order.
    template <typename Body>
    void for_each(const Body& body) const
    {
        for (std::size_t w = 0; w < bits.size(); ++w)
            for (std::uint64_t word = bits[w]; word != 0; word &= word - 1)
                body(64 * w + static_cast<std::size_t>(__builtin_ctzll(word)));
    }
};

class SkyLight {
 public:
    /// @param background  the scene's; it gives light if it is a sky
    /// @param directions  a multiple of 64, up to k_sky_directions
    explicit SkyLight(const scene::Background& background, std::size_t directions = k_sky_directions);
    bool any() const { return any_; }
    std::size_t directions() const { return directions_; }
    glm::vec3 direction(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
    /// Radiance times solid angle, which is the irradiance on a surface that faces the direction.
    const glm::vec3& light(std::size_t i) const { return light_[i]; }
    /// Directions whose rays from a point may meet a sphere.
    /// @param at  the sphere's centre, relative to the point
    SkyMask towards(const glm::vec3& at, float radius) const;

 private:
    bool any_ = false;
    std::size_t directions_;
    alignas(64) std::array<float, k_sky_directions> x_{}, y_{}, z_{};
    std::array<glm::vec3, k_sky_directions> light_{};
};

}   // namespace gnomon::irradiance_cache
