// SPDX-License-Identifier: Apache-2.0
#pragma once
// What the traced frame costs beyond its rays: the whole frame against a bare loop that traces the very same rays, in
// the same order and packets, and does nothing else.

#include <cstdint>
#include <memory>

#include "gnomon/types.h"
#include "scene/scene.h"

namespace gnomon::bench {

struct TraceBenchOptions {
    int frame = 1;
    Size size{512, 512};
    scene::CameraId camera = 0;
    int threads = 0;   // of the frame; the bare loop runs on one
    int max_depth = 10;
    int repeats = 7;   // medians of so many runs
};

struct TraceBenchResult {
    double frame_ms = 0;   // whole traced frame, scene and trees already there
    double bare_ms = 0;    // the recorded rays alone, one thread
    double ratio = 0;      // frame on one thread / bare
    double one_thread_ms = 0;
    double update_ms = 0;   // advance and tree update for a step to the next frame
    double build_ms = 0;    // trees, at the start
    std::uint64_t rays = 0;
    std::uint64_t bytes = 0;   // trees and vertices
};

TraceBenchResult bench_trace(const std::shared_ptr<const scene::Scene>& scene, const TraceBenchOptions& options);

}   // namespace gnomon::bench
