// SPDX-License-Identifier: Apache-2.0
#pragma once
// A range of frames of a scene that bench culling measures: its options and its results.

#include <string>

#include "bench/culling/bench.h"

namespace gnomon::bench {

/// The same frames of a window, after a history of frames that are nearer to one another.
struct CullingStep {
    double seconds = 0;   // between the frames that the methods see
    CullingBenchOptions options;
    CullingBenchResult result;
};

struct CullingWindow {
    std::string scene;     // as named on the command line
    std::string command;   // the whole command line
    bool moving_lights = false;
    std::size_t lights = 0;
    CullingBenchOptions options;
    CullingBenchResult result;
    std::vector<CullingStep> steps;   // optional, the window's own among them: savings against the step
};

/// How many smaller steps make a step.
/// @throws UsageError  no integer number
int frames_between(double step, double seconds);

/// Measures the frames of a window again, with the methods seeing a frame every so many seconds.
/// @param seconds  the window's step divided by integers
/// @throws UsageError  it is not
CullingStep measure_step(const std::shared_ptr<const scene::Scene>& scene, const CullingWindow& window, double seconds,
                         const Progress& progress);

/// "kitchen.aff, frames 1 to 22", or "kitchen.aff, 22 frames 1 s apart from -1 s on"
std::string name_of(const CullingWindow& window);

/// The same window restricted to its first frames. The results are those of a run over these frames, because methods
/// do not depend on later frames; only the memory is that of the whole run.
/// @param frames  1 to the number of frames in the window
CullingWindow beginning_of(const CullingWindow& window, int frames);

}   // namespace gnomon::bench
