// SPDX-License-Identifier: Apache-2.0
#pragma once
// Records, per pixel and light, which cached state a frame's shadows came from: the data of --overlay shadow-states.
//
// A mark describes the first hit of a pixel's first sample, as the cache was when the frame read it: for certified
// culling the state of its part, for the culling of [Nah 2009] the shadow mode of its triangle, for a light with size
// that of the part (area_light/area_shadows.h). A result is wrong if it
// differs from that of a traced ray, at this hit or behind mirrors and glass, in any sample (checked_shadows.h).

#include <cstdint>
#include <vector>

#include "gnomon/types.h"

namespace gnomon::trace {

/// In the order of the legend.
enum class StateMark : std::uint8_t {
    background,   // no surface
    away,         // the light is behind the surface, dark or out of range: no test
    moving,       // the surface is dynamic: always traced
    unknown,      // nothing is known yet: traced
    none,         // no static occluder: traced against dynamic objects at most
    full,         // in the shadow of a static object: no ray
    partial,      // some points lit, some in shadow: traced
    penumbra,     // of lights with size: part of the light is visible past the static triangles that are remembered
};
inline constexpr int k_state_marks = 8;

/// A mark and flags, stored in one byte.
struct StateCell {
    StateMark mark = StateMark::background;
    bool untrusted = false;      // [Nah 2009]: the triangle was partly hidden, so its mode is not used
    bool wrong = false;          // the result at this hit differs from a traced ray's
    bool wrong_behind = false;   // so does one at a point seen in a mirror or through glass

    static constexpr std::uint8_t k_mark = 7, k_untrusted = 8, k_wrong = 16, k_wrong_behind = 32;
    static StateCell of(std::uint8_t byte)
    {
        return {static_cast<StateMark>(byte & k_mark), (byte & k_untrusted) != 0, (byte & k_wrong) != 0,
                (byte & k_wrong_behind) != 0};
    }
};

struct StateMap {
    Size size;
    std::vector<int> lights;           // by panel; the scene's number of lights and more: lights with size
    std::vector<std::uint8_t> cells;   // [panel][pixel], see StateCell
    std::vector<std::uint8_t> shade;   // [pixel]: 0 grazing to 255 facing the viewer; draws the shapes

    /// Clears the map, for an image of that size.
    void start(Size image)
    {
        size = image;
        cells.assign(lights.size() * pixels(), 0);
        shade.assign(pixels(), 0);
    }
    std::size_t pixels() const { return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height); }
    std::uint8_t* panel(std::size_t index) { return cells.data() + index * pixels(); }
    StateCell cell(std::size_t panel, int x, int y) const
    {
        return StateCell::of(cells[panel * pixels() + static_cast<std::size_t>(y) * size.width + x]);
    }
};

}   // namespace gnomon::trace
