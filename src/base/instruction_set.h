// SPDX-License-Identifier: Apache-2.0
#pragma once
// The instruction sets that the program uses.
//
// The environment variable GNOMON_ISA (sse4.2, avx, avx2, avx512) limits the program to one of them and those below it.
// It is meant for tests: with Arithmetic::portable it changes the time alone.

#include "gnomon/arithmetic.h"

namespace gnomon {

enum class InstructionSet : std::uint8_t { sse42, avx, avx2, avx512 };

/// "sse4.2", "avx", "avx2", "avx512".
std::string_view name_of(InstructionSet set);

/// The last instruction set that the processor has and GNOMON_ISA allows. The first call applies the limit to
/// vectorised loops; call it before any of them runs. Thread-safe.
/// @throws UsageError, MissingError  as instruction_set_name()
InstructionSet instruction_set();
/// Whether GNOMON_ISA limits it.
bool instruction_set_is_limited();

}   // namespace gnomon
