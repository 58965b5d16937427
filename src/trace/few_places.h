// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much of a dim light with size a point sees, by few shadow rays.
//
// Where an environment image lights a point, a light with size that brings a small part of what the image brings there
// needs no fine visibility: its visible share is found at so few of its places that one of them brings at most
// 1 / k_steps of what the image brings. The steps that this leaves are invisible beside the image's light. Lights that
// bring more, and points that the image does not reach, keep the visibility of SizedVisibility.
//
// The number of places is a function of the point, the light and the image's light there, so it does not depend on what
// is remembered. Points that several rays of one lobe stand for need fewer steps, because these rays are averaged.
//
// Cost: a power of two of rays for each point and light, 1 for the dimmest.

#include <algorithm>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "ray/ray_scene.h"
#include "scene/sized_light.h"
#include "trace/point_batch.h"

namespace gnomon::trace {

class FewPlaces {
 public:
    static constexpr float k_steps = 512;
    static constexpr float k_lobe_steps = 128;    // of points that one of several rays of a lobe met
    static constexpr float k_most_mirrored = 4;   // a point whose light makes a share of a pixel needs that many
                                                  // times this share of the steps
    static constexpr float k_least_mirrored = 1 / 16.0f;   // likewise, at least
    static constexpr std::size_t k_most = 64;              // places; a light that needs more needs finer visibility

    FewPlaces(const scene::SizedLights& lights, const ray::RayScene& rays);

    /// The number of places that do, as a power of two; 0: the light needs finer visibility.
    /// @param arrives  luminance that the point reflects of the light if it sees all of it
    /// @param image    luminance that it reflects of the environment image; 0: it sees nothing of it
    /// @param share    that the light of a point makes, of its pixel
    std::size_t count(std::uint32_t light, const TilePoint& point, float arrives, float image, float share) const;

    /// Some places of a light, each with its part of the area: so many, or all if there are fewer.
    std::span<const scene::SizedPlace> some(std::uint32_t light, std::size_t count) const
    {
        const auto& subsets = subsets_[light];
        return subsets[std::min(static_cast<std::size_t>(std::bit_width(count)), subsets.size()) - 1];
    }

    /// Forgets the points of the last light.
    void clear();
    /// Adds a point of the batch.
    void push(std::uint32_t light, std::size_t count, std::uint32_t point, const PointBatch& batch);
    /// Traces the rays of all points.
    void trace();
    /// By added point: its places, and which of them it sees: 1, or 0.
    std::span<const scene::SizedPlace> places(std::size_t added) const { return asked_[added].places; }
    std::span<const std::uint8_t> seen(std::size_t added) const
    {
        return {seen_.data() + asked_[added].first, asked_[added].places.size()};
    }
    std::uint64_t rays_traced() const { return traced_; }

 private:
    struct Asked {
        std::span<const scene::SizedPlace> places;
        std::size_t first = 0;   // in seen_
    };
    const scene::SizedLights& lights_;
    const ray::RayScene& rays_;
    std::vector<std::vector<std::vector<scene::SizedPlace>>> subsets_;   // by light and the logarithm of their number
    std::vector<Asked> asked_;
    std::vector<std::uint8_t> seen_;
    ray::RayQueue queue_;
    std::vector<std::size_t> targets_;   // by ray, in seen_
    std::vector<std::uint8_t> occluded_;
    std::uint64_t traced_ = 0;
};

}   // namespace gnomon::trace
