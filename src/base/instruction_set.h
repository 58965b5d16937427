// SPDX-License-Identifier: Apache-2.0
#pragma once
// The instruction set that decides the arithmetic of images.

#include <string>

namespace gnomon {

/// The name of the instruction set that ray tracing and vectorised loops use on this processor: "sse4.2", "avx", "avx2"
/// or "avx512"; "generic" on other architectures. Two processors with the same name render the same bytes. Frames of a
/// video note it, so that frames of another one are never mixed with them. A name contains no blanks.
std::string instruction_set();

}   // namespace gnomon
