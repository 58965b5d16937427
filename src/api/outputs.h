// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts layers of a frame into memory of the caller's.

#include <span>

#include "base/tasks.h"
#include "gnomon/frame.h"
#include "gnomon/output.h"

namespace gnomon {

/// Checks what can be checked before a frame of that size is rendered: pointers, strides and lengths.
/// @throws UsageError
void check_outputs(std::span<const Output> outputs, Size size);

/// Writes all outputs, one after the other. Nothing is written if one of them is wrong.
/// @throws UsageError  a layer or channel that the frame does not have, a format that it cannot have, no memory or too
///         little, strides with which pixels would overlap
void write_outputs(const Frame& frame, std::span<const Output> outputs, Tasks& tasks);

}   // namespace gnomon
