// SPDX-License-Identifier: Apache-2.0
#pragma once
// Checks options of the public interface against their ranges (gnomon/ranges.h) and against each other.

#include <string_view>

#include "gnomon/ranges.h"
#include "gnomon/renderer.h"

namespace gnomon {

/// @param what  begins the message: "samples are"
/// @param unit  ends it: " MB"
/// @throws UsageError  "samples are out of range: 1 to 4096"
void check_range(std::string_view what, double value, const Range& range, std::string_view unit = {});

}   // namespace gnomon
