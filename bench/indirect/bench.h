// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light measured: how far off it is, how it flickers, what it costs, method by method, against a path-traced
// reference of one bounce.
//
// Errors are of irradiance, at primary hits of every eighth pixel in x and y, the method run at full size; of three
// channels together; over the mean of the reference. They are taken in a few frames, spread over the range. Flicker is
// mean |dE - dE_ref| from such a frame to the next, at surface points that both show, over mean E; the references have
// the same random numbers in both frames, and the same figure between two references is the floor. Where only the view
// moves, E must not change at all; how much it does is measured on a short walk.
//
// Methods that know of nothing in the way are also judged against the sum over all texels of their light map
// (nrmse_brute): what they approximate.
//
// Times leave out the hits themselves.

#include <array>
#include <functional>
#include <optional>

#include "bench/indirect/methods.h"
#include "gnomon/types.h"

namespace gnomon::bench {

struct IndirectBenchOptions {
    FrameRange frames{1, 10};
    Size size{512, 512};
    int threads = 0;
    scene::CameraId camera = 0;
    int spp = 4096;            // paths a point, of references
    int judged = 4;            // frames with a reference
    int grid = 8;              // pixels from a judged point to the next
    int flicker_grid = 16;     // the same of flicker; a multiple of `grid`
    int view_steps = 8;        // of the walk
    double view_turn = 2e-3;   // radians by which a step goes around the scene's centre
    double view_zoom = 2e-3;   // share of the distance to the image's middle by which it goes forward
    std::vector<IndirectMethodInfo> methods;
    std::string reference_cache;   // folder; empty: references are not kept
    bool images = false;           // keep every method's irradiance in one frame, and the reference's
    int image_spp = 256;           // paths a pixel of the latter
};

/// In units of mean E.
struct Change {
    double mean = 0, largest = 0;
};

struct IndirectRow {
    std::string method, title;
    bool vulkan = false;   // where it ran
    IndirectSettings settings;
    // Means from the second frame on; the first is cold (a clip of one frame has that one alone). Wall time, and
    // process CPU time over all threads.
    double ms_cold = 0, ms_static = 0, ms_moving = 0, ms_repair = 0, ms_rebuild = 0;
    double cpu_ms_cold = 0, cpu_ms_static = 0, cpu_ms_moving = 0, cpu_ms_repair = 0, cpu_ms_rebuild = 0;
    double ms_moving_median = 0, ms_moving_worst = 0;
    IndirectWork work;   // means, bytes the largest; of moving frames
    std::uint64_t rays_cold = 0;
    std::optional<double> nrmse, nrmse_brute, energy_ratio, flicker, flicker_floor;
    std::optional<Change> view_change;   // not of sampling
    std::vector<double> nrmse_by_frame;
    std::vector<glm::vec3> image;   // irradiance by pixel, if images are kept
};

/// The frame of which images are kept.
struct IndirectImage {
    int frame = 0;
    std::vector<glm::vec3> diffuse;     // share of irradiance that each pixel's surface sends on, times pi
    std::vector<glm::vec3> reference;   // irradiance
};

struct IndirectBenchResult {
    std::vector<int> judged;
    double reference_noise = 0;   // root mean square error over mean E
    double mean_irradiance = 0;
    std::size_t points = 0;   // judged, of all frames
    int references_computed = 0, references_found = 0;
    std::vector<IndirectRow> rows;
    IndirectImage image;
};

/// @throws InterruptedError  progress returned false
IndirectBenchResult bench_indirect(const std::shared_ptr<const scene::Scene>& scene,
                                   const IndirectBenchOptions& options, const Progress& progress = {},
                                   const std::function<void(const IndirectRow&)>& on_row = {});

}   // namespace gnomon::bench
