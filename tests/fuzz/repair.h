// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a random change breaks and no random change makes good again.

#include "fuzz/targets.h"

namespace gnomon::fuzz {

/// The checksum of every chunk.
void repair_png(Bytes& bytes);
/// Length of the file and of its last chunk; the end of its JSON is where the braces close.
void repair_glb(Bytes& bytes);

}   // namespace gnomon::fuzz
