// SPDX-License-Identifier: Apache-2.0
#pragma once
// The cells of a light's proven visibility as sample places (scene/sized_light.h), by which shading weights what is
// visible.

#include "area_light/area_visibility.h"
#include "scene/sized_light.h"

namespace gnomon::area_light {

/// A flat light with size (SizedLight::is_flat), for AreaVisibility::follow().
AreaLight area_light_of(const scene::SizedLight& light);

struct CellPlaces {
    /// How much of a place is visible: up to k_whole.
    static constexpr std::uint8_t k_whole = 16;

    std::vector<scene::SizedPlace> of[2];   // front, back
    std::vector<std::uint16_t> cell[2];     // of each place
    bool one_radiance = true;

    /// @param index  of the light in `visibility`
    CellPlaces(const AreaVisibility& visibility, std::size_t index, const scene::SizedLight& light);

    /// Fills in how much of each place of a side is visible.
    /// @param of_side  the cells of that side
    void fill_seen(std::size_t side, const LightCells& of_side, const VisibleCells& cells, std::uint8_t* seen) const;
};

}   // namespace gnomon::area_light
