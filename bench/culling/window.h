// SPDX-License-Identifier: Apache-2.0
#pragma once
// A range of frames of a scene that bench culling measures: its options and its results.

#include <string>

#include "bench/culling/bench.h"

namespace gnomon::bench {

struct CullingWindow {
    std::string scene;     // as named on the command line
    std::string command;   // the whole command line
    bool moving_lights = false;
    std::size_t lights = 0;
    CullingBenchOptions options;
    CullingBenchResult result;
};

/// "kitchen.aff, frames 1 to 22"
std::string name_of(const CullingWindow& window);

/// The same window restricted to its first frames. The results are those of a run over these frames, because methods
/// do not depend on later frames; only the memory is that of the whole run.
/// @param frames  1 to the number of frames in the window
CullingWindow beginning_of(const CullingWindow& window, int frames);

}   // namespace gnomon::bench
