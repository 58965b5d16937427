// SPDX-License-Identifier: Apache-2.0
#pragma once
// Computes the summary of bench culling from the frames of one or several runs.

#include <span>

#include "bench/culling/bench.h"

namespace gnomon::bench {

/// Medians of the times, frame by frame, over several runs of the same frames.
/// @throws InternalError  if a count differs between two runs, which must be equal because runs are independent
std::vector<CullingFrame> medians_of(std::span<const std::vector<CullingFrame>> runs);

/// Fills in all values of the result that follow from its frames.
void summarise(const CullingBenchOptions& options, CullingBenchResult& result);

}   // namespace gnomon::bench
