// SPDX-License-Identifier: Apache-2.0
#pragma once
// Paints the image of --overlay shadow-states: one panel per light, coloured by the cached shadow states, with wrong
// results in glaring colours, and a legend with percentages. Shapes are drawn by the angle between surface and viewer.

#include <array>
#include <string>

#include "base/image.h"
#include "trace/state_map.h"

namespace gnomon::frame {

using Rgb8 = std::array<std::uint8_t, 3>;

/// The colour of a mark where the surface faces the viewer; the colour of a wrong result replaces it.
Rgb8 state_color(trace::StateMark mark);
inline constexpr Rgb8 k_wrong_color{255, 0, 255}, k_wrong_behind_color{0, 255, 255};
/// The colour of one pixel. Wrong results are not shaded.
Rgb8 cell_color(const trace::StateCell& cell, std::uint8_t shade);

/// Size in pixels of the whole image: panels in a grid, titles and legend. Both sides are even, as videos need.
Size overlay_size(Size panel, std::size_t panels, bool paper);

/// The position of a panel's first pixel.
struct PanelPlace {
    int left = 0, top = 0;
};
PanelPlace panel_place(Size panel, std::size_t panels, std::size_t index);

/// @param titles  by panel
/// @param paper   names and explains the published method's modes
Image8 paint_states(const trace::StateMap& map, const std::vector<std::string>& titles, bool paper);

}   // namespace gnomon::frame
