// SPDX-License-Identifier: Apache-2.0
#pragma once
// One run of bench culling: some frames of a scene, what was asked and what came out.

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

/// The same window as it would be with its first frames alone: methods know nothing of what is to come. Memory stays
/// that of the whole.
/// @param frames  1 to all of the window's
CullingWindow beginning_of(const CullingWindow& window, int frames);

}   // namespace gnomon::bench
