// SPDX-License-Identifier: Apache-2.0
#pragma once
// Paints the image of --overlay shadow-states: one panel per light, and per emissive object, coloured by the cached
// shadow states, with wrong results in glaring colours, and a legend with percentages. Shapes are drawn by the angle
// between surface and viewer.

#include <array>
#include <string>

#include "base/image.h"
#include "scene/sized_light.h"
#include "trace/state_map.h"

namespace gnomon::frame {

using Rgb8 = std::array<std::uint8_t, 3>;

/// The colour of a mark where the surface faces the viewer; the colour of a wrong result replaces it.
Rgb8 state_color(trace::StateMark mark);
inline constexpr Rgb8 k_wrong_color{255, 0, 255}, k_wrong_behind_color{0, 255, 255};
/// The colour of one pixel. Wrong results are not shaded.
Rgb8 cell_color(const trace::StateCell& cell, std::uint8_t shade);

/// What the overlay shows beside the lights of a scene, and in its legend.
struct OverlayKind {
    bool paper = false;   // names and explains the published method's modes
    bool sized = false;   // has panels of lights with size
};

/// Panels of lights with size: one for each emissive object, or a single one if there are more than k_most_sized.
struct SizedPanels {
    static constexpr std::size_t k_most_sized = 16;
    std::vector<std::string> titles;   // by panel
    std::vector<int> of_object;        // panel by object; -1: none
};
SizedPanels sized_panels(const scene::Scene& scene);
/// The panel of a map by light with size; -1: none.
std::vector<int> panels_of(const trace::StateMap& map, const scene::SizedLights& lights, const scene::Scene& scene);

/// Size in pixels of the whole image: panels in a grid, titles and legend. Both sides are even, as videos need.
Size overlay_size(Size panel, std::size_t panels, const OverlayKind& kind);

/// The position of a panel's first pixel.
struct PanelPlace {
    int left = 0, top = 0;
};
PanelPlace panel_place(Size panel, std::size_t panels, std::size_t index);

/// @param titles  by panel
Image8 paint_states(const trace::StateMap& map, const std::vector<std::string>& titles, const OverlayKind& kind);

}   // namespace gnomon::frame
