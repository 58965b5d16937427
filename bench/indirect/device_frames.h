// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures whole rasterised frames with indirect light on the device, as the paper measured its own [Ki and Oh 2007,
// 6]: G-buffer, direct light with shadows, light map, tree, cut and gather, by the renderer's own passes.
//
// Kept: neither scene nor view change, and the renderer keeps G-buffer, light map, cut and the light of sparse
// receivers (its counters confirm it). Not kept: all of them are made anew, as in the paper where something moves.
// Without Vulkan, every function throws MissingError.

#include <functional>
#include <string>
#include <vector>

#include "bench/indirect/bench.h"

namespace gnomon::bench {

struct DeviceFramesRow {
    std::string method;   // quadtree:LEVEL, printed:LEVEL or rsm:SAMPLES:RADIUS
    double depth_threshold = 0.05, normal_threshold = 0.9;
    std::uint64_t lights = 0;              // clusters or samples
    double ms_kept = 0, ms_not_kept = 0;   // medians, by the clock of the result
    bool kept = false;                     // the renderer kept all of its buffers in the frames of ms_kept
    bool made = false;                     // and none in those of ms_not_kept
    double different_from_quadtree = 0;    // printed: fraction of values that differ from the compacted cut's image
};

struct DeviceFramesResult {
    std::string device, clock;   // clock: "process CPU" for a software device, else "wall"
    bool full = false;           // receivers at every pixel
    std::vector<DeviceFramesRow> rows;
};

struct DeviceFramesOptions {
    Size size{512, 512};
    int frame = 1;
    scene::CameraId camera = 0;
    int repeats = 3;
    bool full = false;   // receivers at every pixel
    std::vector<std::string> methods;
    std::vector<std::pair<double, double>> thresholds;   // also, for quadtree:5: depth and normal
};

/// @throws MissingError      no Vulkan, or too little device memory
/// @throws InterruptedError  progress returned false
DeviceFramesResult measure_device_frames(const std::shared_ptr<const scene::Scene>& scene,
                                         const DeviceFramesOptions& options, const Progress& progress = {});

}   // namespace gnomon::bench
