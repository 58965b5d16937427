// SPDX-License-Identifier: Apache-2.0
#pragma once
// Readings of the published method, each of which changes one thing, and its two extensions by the paper's own future
// work [Nah 2009, 4]. bench culling measures them beside the method on the same points.

#include <string_view>
#include <vector>

#include "bench/culling/bench.h"

namespace gnomon::bench {

/// All of them, in the order of tables.
std::vector<PaperReading> all_readings();

/// @throws UsageError  no reading has this name
PaperReading reading_named(std::string_view name);

/// "separate", "hierarchy" or "mixed".
ray::KdLayout layout_named(std::string_view name);
std::string name_of(ray::KdLayout layout);

}   // namespace gnomon::bench
