// SPDX-License-Identifier: Apache-2.0
#pragma once
// The image of --overlay shadow-states: a panel for each light, coloured by what was remembered, wrong answers
// glaring, a legend with shares below. Shapes come from how far a surface faces the viewer.

#include <array>
#include <string>

#include "base/image.h"
#include "trace/state_map.h"

namespace gnomon::frame {

using Rgb8 = std::array<std::uint8_t, 3>;

/// Of a mark where the surface faces the viewer; wrong answers overrule it.
Rgb8 state_color(trace::StateMark mark);
inline constexpr Rgb8 k_wrong_color{255, 0, 255}, k_wrong_behind_color{0, 255, 255};
/// Of one pixel. Wrong answers are not shaded.
Rgb8 cell_color(const trace::StateCell& cell, std::uint8_t shade);

/// How many pixels the whole image takes: panels in a grid, legend and titles. Both even, as videos need.
Size overlay_size(Size panel, std::size_t panels, bool paper);

/// Where a panel's first pixel lies.
struct PanelPlace {
    int left = 0, top = 0;
};
PanelPlace panel_place(Size panel, std::size_t panels, std::size_t index);

/// @param titles  by panel
/// @param paper   names and explains the published method's modes
Image8 paint_states(const trace::StateMap& map, const std::vector<std::string>& titles, bool paper);

}   // namespace gnomon::frame
