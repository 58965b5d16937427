// SPDX-License-Identifier: Apache-2.0
#pragma once
// From what the shadows of a frame were answered, pixel by pixel and light by light: the data of --overlay
// shadow-states.
//
// A mark tells of the first hit of a pixel's first sample, by the memory as the frame read it: for certified culling
// the state of its part, for the published one the shadow mode of its triangle. Faults are answers that differ from a
// trace of every ray, at that hit or behind mirrors and glass, of any sample; so whoever fills a map traces every ray.

#include <cstdint>
#include <vector>

#include "gnomon/types.h"

namespace gnomon::trace {

/// In the order of the legend.
enum class StateMark : std::uint8_t {
    background,   // no surface
    away,         // the light is behind the surface, dark, or does not reach so far: no question
    moving,       // a surface that may move: always traced
    unknown,      // nothing is remembered yet: traced
    none,         // nothing static in the way: only what moves is asked, or nothing at all
    full,         // in the shadow of something static: no ray
    partial,      // both: traced
};
inline constexpr int k_state_marks = 7;

/// One byte: a mark and flags.
struct StateCell {
    StateMark mark = StateMark::background;
    bool untrusted = false;      // published culling: the triangle was not seen whole, its mode is not read
    bool wrong = false;          // the answer at this hit differs from a trace of every ray
    bool wrong_behind = false;   // one seen in a mirror or through glass does

    static constexpr std::uint8_t k_mark = 7, k_untrusted = 8, k_wrong = 16, k_wrong_behind = 32;
    static StateCell of(std::uint8_t byte)
    {
        return {static_cast<StateMark>(byte & k_mark), (byte & k_untrusted) != 0, (byte & k_wrong) != 0,
                (byte & k_wrong_behind) != 0};
    }
};

struct StateMap {
    Size size;
    std::vector<int> lights;           // which ones, by panel
    std::vector<std::uint8_t> cells;   // [panel][pixel], see StateCell
    std::vector<std::uint8_t> shade;   // [pixel]: 0 grazing to 255 facing the viewer; draws the shapes

    /// Empty, for that many pixels.
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
