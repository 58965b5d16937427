// SPDX-License-Identifier: Apache-2.0
#pragma once
// How much of a planar light a point sees, from its visible places, weighted by what each brings.
//
// 16 neighbouring places (four each of four rows) make a cell, and the weight of a cell is that of the middle of its
// places: the cosines at the surface and at the light over the squared distance, by the area of the places. The share
// is the ratio of the visible weight to the whole, so it has no error where all or nothing is visible.
//
// Cost: some 300 ns (AVX-512). The same bits for any instruction set.

#include <array>
#include <cstdint>

#include "area_light/light_places.h"

namespace gnomon::area_light {

inline constexpr int k_cells = k_rows / 4 * 16;   // some without places

/// By cell: how many of its places are visible, up to 16.
using VisibleCells = std::array<std::uint8_t, k_cells>;

/// Counts the places that are not blocked, of those inside the light.
/// @return  the number of all of them
int count_visible(const LightPlaces& places, const PlaceMask& blocked, VisibleCells& visible);

class LightCells {
 public:
    explicit LightCells(const LightPlaces& places);

    /// The middle of a cell's places; of a cell without places, somewhere.
    glm::vec3 position(int cell) const
    {
        const auto c = static_cast<std::size_t>(cell);
        return {x_[c], y_[c], z_[c]};
    }
    /// The number of its places inside the light.
    int count(int cell) const { return static_cast<int>(count_[static_cast<std::size_t>(cell)]); }
    /// The light's, unit.
    const glm::vec3& normal() const { return light_normal_; }
    /// The area that one place stands for.
    float area_of_place() const { return area_; }

    /// The visible share of the irradiance that arrives at a point, 0 to 1, for a light of one radiance.
    /// @param normal   unit, of the irradiance
    /// @param horizon  unit, the geometric normal: nothing arrives from below its plane either
    float share(const glm::vec3& point, const glm::vec3& normal, const glm::vec3& horizon,
                const VisibleCells& visible) const;

 private:
    glm::vec3 light_normal_{0};
    float area_ = 0;
    alignas(64) std::array<float, k_cells> x_, y_, z_, count_;
};

}   // namespace gnomon::area_light
