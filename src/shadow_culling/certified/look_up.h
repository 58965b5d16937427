// SPDX-License-Identifier: Apache-2.0
#pragma once
// Looks up the parts and states of many points at a time, vectorised for the processor at hand (Highway).
//
// Only additions, multiplications and comparisons in single precision, in one order, so that every instruction set
// finds the same parts. The reference implementation for one point is micro_index_at (micro_triangles.h).

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shadow_culling/certified/shadow_memory.h"
#include "shadow_culling/certified/shadow_point.h"

namespace gnomon::shadow_culling {

/// Arrays are read and written in steps of so many points.
inline constexpr std::size_t k_look_up_step = 16;

/// Points on remembered triangles; arrays by point are padded to the step. Consecutive points mostly lie on one
/// triangle, so the triangle's data is stored once per run of them.
struct LookUp {
    struct Run {
        std::uint32_t first;             // point; the run ends where the next one begins
        std::uint32_t begin;             // address of the finest states or of the table; k_no_slot: not remembered
        float rim_u, rim_v, per_inner;   // of the triangle's rim (rim.h)
        float divisions;                 // of each axis: 2^level
        bool pieces = false;             // at `begin` is a table of pieces (shadow_memory.h)
    };
    std::vector<glm::vec2> uv;         // in the triangle
    std::vector<std::uint32_t> slot;   // of the part; k_no_slot: not remembered, or in the rim
    std::vector<Run> runs;
    std::size_t count = 0;   // points

    /// Makes room for points, and removes all runs.
    void resize(std::size_t points);
};

Box3 bounds_of(std::span<const ShadowPoint> points);

/// Finds the parts of all points: `slot`.
/// @param tables  the block of the tables of pieces; may be null if no run has one
void find_parts(LookUp& points, const std::uint8_t* tables);
/// out[k] = states[slot[k]] & mask; 0 without a slot. For the points of all runs.
/// @param out  padded to the step
void fetch_states(const LookUp& points, const std::uint8_t* states, std::uint8_t mask, std::uint8_t* out);

}   // namespace gnomon::shadow_culling
