// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light of the sky from a fixed set of directions. Which of them a point sees past static geometry is one bit each,
// and a dynamic object can hide only those within the cone of its bounding sphere.
//
// The directions are a spherical Fibonacci lattice, each for the solid angle that is nearest to it, with the radiance
// of the sky's gradient. At the edge of an opening they can be divided into parts, which are directions of a finer
// lattice: what a point sees of the sky would otherwise change in steps from place to place. The sun is a light of its
// own, and environment images are lights, too (scene/environment.h).

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scene/light.h"

namespace gnomon::irradiance_cache {

inline constexpr std::size_t k_sky_directions = 512;   // at most

/// A bit per direction.
struct SkyMask {
    std::array<std::uint64_t, k_sky_directions / 64> bits{};
    void set(std::size_t i) { bits[i / 64] |= std::uint64_t{1} << (i % 64); }
    void reset(std::size_t i) { bits[i / 64] &= ~(std::uint64_t{1} << (i % 64)); }
    bool test(std::size_t i) const { return ((bits[i / 64] >> (i % 64)) & 1) != 0; }
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
    /// The number of set bits before one.
    std::size_t rank(std::size_t i) const
    {
        int sum = __builtin_popcountll(bits[i / 64] & ((std::uint64_t{1} << (i % 64)) - 1));
        for (std::size_t w = 0; w < i / 64; ++w) sum += __builtin_popcountll(bits[w]);
        return static_cast<std::size_t>(sum);
    }
    /// What is set here and not in the other.
    SkyMask without(const SkyMask& other) const
    {
        SkyMask rest;
        for (std::size_t w = 0; w < bits.size(); ++w) rest.bits[w] = bits[w] & ~other.bits[w];
        return rest;
    }
    /// The number of bits that are set in both.
    int common(const SkyMask& other) const
    {
        int sum = 0;
        for (std::size_t w = 0; w < bits.size(); ++w) sum += __builtin_popcountll(bits[w] & other.bits[w]);
        return sum;
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

/// A direction that is divided into parts, and which of these a point sees.
struct DividedDirection {
    std::uint16_t direction = 0;
    std::uint16_t seen = 0;   // a bit per part
};
inline constexpr std::size_t k_most_sky_parts = 16;   // of a direction

class SkyLight {
 public:
    struct Part {
        glm::vec3 direction, light;   // as below
    };
    /// @param background  the scene's; it gives light if it is a sky
    /// @param directions  a multiple of 64, up to k_sky_directions
    /// @param parts       of a direction, on average; 1: they cannot be divided
    explicit SkyLight(const scene::Background& background, std::size_t directions = k_sky_directions,
                      std::size_t parts = 1);
    bool any() const { return any_; }
    std::size_t directions() const { return directions_; }
    glm::vec3 direction(std::size_t i) const { return {x_[i], y_[i], z_[i]}; }
    /// Radiance times solid angle, which is the irradiance on a surface that faces the direction.
    const glm::vec3& light(std::size_t i) const { return light_[i]; }
    /// Directions whose rays from a point may meet a sphere.
    /// @param at  the sphere's centre, relative to the point
    /// @param or_part  directions of whose parts this may hold, too
    SkyMask towards(const glm::vec3& at, float radius, bool or_part = false) const;

    bool divides() const { return !parts_.empty(); }
    std::span<const Part> parts(std::size_t i) const
    {
        return {parts_.data() + first_part_[i], parts_.data() + first_part_[i + 1]};
    }
    /// The directions of `all` beside which there is one that is seen if they are not, or the other way round.
    SkyMask edges(const SkyMask& all, const SkyMask& seen) const;
    /// Takes back the division around directions that are alone among `all` in being seen, or not, where the parts like
    /// them are fewer than one direction has. For one small opening that a direction finds there are others that none
    /// finds, and it must stand for these, or what has many small openings would be too dark.
    /// @param divided  ascending by direction
    void take_back(const SkyMask& all, const SkyMask& seen, std::vector<DividedDirection>& divided) const;

 private:
    void make_parts(const scene::Background& sky, std::size_t count);

    bool any_ = false;
    std::size_t directions_;
    std::vector<Part> parts_;   // by direction
    std::array<std::uint32_t, k_sky_directions + 1> first_part_{};
    std::vector<SkyMask> beside_;   // by direction: those next to it
    float part_angle_ = 0;          // the largest angle between a direction and its parts
    alignas(64) std::array<float, k_sky_directions> x_{}, y_{}, z_{};
    std::array<glm::vec3, k_sky_directions> light_{};
};

}   // namespace gnomon::irradiance_cache
