// SPDX-License-Identifier: Apache-2.0
#pragma once
// Repairs what a random change breaks and what no further random change would repair.

#include "fuzz/targets.h"

namespace gnomon::fuzz {

/// Recomputes the checksum of every chunk.
void repair_png(Bytes& bytes);
/// Sets the lengths of the file and of its last chunk; the JSON ends where its braces close.
void repair_glb(Bytes& bytes);

}   // namespace gnomon::fuzz
