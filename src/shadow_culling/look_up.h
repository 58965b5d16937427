// SPDX-License-Identifier: Apache-2.0
#pragma once
// The inner loops of a look-up, many points at a time, with what the processor at hand offers (Highway).
//
// Additions, multiplications and comparisons in single precision alone, in one order: every instruction set finds the
// same parts. The twin for one point is micro_index_at (micro_triangles.h).

#include <cstddef>
#include <cstdint>
#include <vector>

#include "shadow_culling/shadow_memory.h"

namespace gnomon::shadow_culling {

/// Arrays are read and written in steps of this many points.
inline constexpr std::size_t k_look_up_step = 16;

/// Points on remembered triangles, by point; all arrays are padded to the step.
struct LookUp {
    std::vector<float> u, v;                      // in the triangle
    std::vector<float> rim_u, rim_v, per_inner;   // of the triangle's rim (rim.h)
    std::vector<float> divisions;                 // of each axis at the finest level: 2^level
    std::vector<std::uint32_t> slot;   // where the finest level begins, then the part; k_no_slot: not remembered

    void resize(std::size_t points);
};

/// Turns the beginnings in `points.slot` into parts; k_no_slot in the rim.
void find_parts(LookUp& points);
/// out[k] = states[slot[k]] & mask; 0 without a slot.
/// @param out  padded, too
void fetch_states(const LookUp& points, const std::uint8_t* states, std::uint8_t mask, std::uint8_t* out);

}   // namespace gnomon::shadow_culling
