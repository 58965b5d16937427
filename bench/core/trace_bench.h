// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures the overhead of the traced frame beyond its rays: compares the whole frame with a loop that traces the same
// rays in the same order and packets and does nothing else.

#include <cstdint>
#include <memory>

#include "gnomon/arithmetic.h"
#include "gnomon/types.h"
#include "scene/scene.h"

namespace gnomon::bench {

struct TraceBenchOptions {
    int frame = 1;
    Size size{512, 512};
    scene::CameraId camera = 0;
    int threads = 0;   // threads for the frame, 0: all; the bare loop runs on one
    int max_depth = 10;
    Arithmetic arithmetic = Arithmetic::portable;
    int repeats = 7;   // runs; times are medians over them
};

struct TraceBenchResult {
    double frame_ms = 0;        // the whole traced frame, without loading and building BVHs
    double bare_ms = 0;         // the recorded rays alone, on one thread
    double ratio = 0;           // one_thread_ms / bare_ms
    double one_thread_ms = 0;   // the whole traced frame on one thread
    double update_ms = 0;       // advancing to the next frame and updating the BVHs
    double build_ms = 0;        // building the BVHs
    std::uint64_t rays = 0;
    std::uint64_t bytes = 0;   // of BVHs and vertices
};

TraceBenchResult bench_trace(const std::shared_ptr<const scene::Scene>& scene, const TraceBenchOptions& options);

}   // namespace gnomon::bench
