// SPDX-License-Identifier: Apache-2.0
#pragma once
// From the frames of one or several runs of bench culling to its figures.

#include <span>

#include "bench/culling/bench.h"

namespace gnomon::bench {

/// Medians of the times, frame by frame, of runs over the same frames.
/// @throws InternalError  if a count differs between two runs: they see the same scene and remember nothing
///         from each other
std::vector<CullingFrame> medians_of(std::span<const std::vector<CullingFrame>> runs);

/// Fills in all of the result that follows from its frames.
void summarise(const CullingBenchOptions& options, CullingBenchResult& result);

}   // namespace gnomon::bench
