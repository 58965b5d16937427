// SPDX-License-Identifier: Apache-2.0
#pragma once
// The arithmetic of traced images, and the instruction sets of the processor.

#include <cstdint>
#include <string_view>

namespace gnomon {

/// What decides where rays hit. `portable`: code whose results are the same on every x86-64 processor with SSE4.2, so
/// that an image has the same bytes on all of them. `native`: Embree's code for this processor, which may differ from
/// that of another in the last bits, and so at the edges of surfaces.
enum class Arithmetic : std::uint8_t { portable, native };

/// The instruction set that this process uses: "sse4.2", "avx", "avx2" or "avx512". It is the last one that the
/// processor has, unless the environment variable GNOMON_ISA names an earlier one, which limits Embree and all
/// vectorised loops.
/// @throws UsageError    GNOMON_ISA has another value
/// @throws MissingError  the processor lacks the instruction set that GNOMON_ISA names
std::string_view instruction_set_name();

}   // namespace gnomon
