// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures methods for indirect light: error and flicker against a path-traced one-bounce reference, and cost.
//
// Errors are root mean squares of irradiance over the three channels, divided by the mean of the reference. They are
// taken at the primary hits of every eighth pixel in x and y, in a few frames spread over the range; the method itself
// runs at full size. Flicker is mean |dE - dE_ref| from such a frame to the next, at surface points visible in both,
// divided by mean E. The references use the same random numbers in both frames; the same value computed between two
// references is the noise floor. While only the view moves, E must not change; a short camera path measures the change.
//
// Methods that ignore visibility are also compared with the sum over all texels of their light map (nrmse_brute), which
// they approximate.
//
// Times exclude tracing the primary hits, except ms_not_kept.

#include <array>
#include <functional>
#include <optional>

#include "bench/indirect/local_means.h"
#include "bench/indirect/methods.h"
#include "gnomon/types.h"

namespace gnomon::bench {

struct IndirectBenchOptions {
    FrameRange frames{1, 10};
    Size size{512, 512};
    int threads = 0;
    scene::CameraId camera = 0;
    int spp = 4096;            // paths per point of a reference
    int bounces = 1;           // of its paths
    int judged = 4;            // number of frames with a reference
    int grid = 8;              // spacing of the compared points, in pixels; divides the next
    int flicker_grid = 16;     // spacing of the points for flicker, in pixels
    int view_steps = 8;        // steps of the camera path
    double view_turn = 2e-3;   // angle per step around the scene's centre, in radians
    double view_zoom = 2e-3;   // forward motion per step, as a fraction of the largest distance seen
    std::vector<IndirectMethodInfo> methods;
    std::string reference_cache;   // folder in which references are kept; empty: none
    bool images = false;           // keep the irradiance of one frame, of every method and of the reference
    int image_spp = 256;           // paths per pixel of the reference image
};

/// Change of E, in units of mean E.
struct Change {
    double mean = 0, largest = 0;
};

struct IndirectRow {
    std::string method, title;
    bool vulkan = false;   // ran on a Vulkan device
    IndirectSettings settings;
    // Mean times from the second frame on, except `cold`, which is the first frame's (a clip of one frame has only
    // that one): wall time, and process CPU time over all threads.
    double ms_cold = 0, ms_static = 0, ms_moving = 0, ms_repair = 0, ms_rebuild = 0;
    double cpu_ms_cold = 0, cpu_ms_static = 0, cpu_ms_moving = 0, cpu_ms_repair = 0, cpu_ms_rebuild = 0;
    /// 'Not kept' as the paper means it: primary hits (on the CPU), light map, tree, cut and light are all made anew. 0
    /// for cached visibility.
    double ms_not_kept = 0, cpu_ms_not_kept = 0;
    double ms_moving_median = 0, ms_moving_worst = 0;
    IndirectWork work;   // means over moving frames; the maximum of bytes
    std::uint64_t rays_cold = 0;
    std::optional<double> nrmse, nrmse_brute, energy_ratio, flicker, flicker_floor;
    std::optional<Change> view_change;   // none for sampling
    std::vector<double> nrmse_by_frame;
    LocalMeans local_means;
    std::vector<glm::vec3> image;   // irradiance by pixel, if images are kept
};

/// The frame whose images are kept.
struct IndirectImage {
    int frame = 0;
    std::vector<glm::vec3> diffuse;     // diffuse reflectance by pixel
    std::vector<glm::vec3> reference;   // irradiance
};

struct IndirectBenchResult {
    std::vector<int> judged;
    double reference_noise = 0;   // root mean square error of the references over mean E
    double mean_irradiance = 0;
    std::size_t points = 0;   // compared points, in all frames
    int references_computed = 0, references_found = 0;
    std::vector<IndirectRow> rows;
    IndirectImage image;
};

/// @param on_row  called after each method
/// @throws InterruptedError  if progress returned false
IndirectBenchResult bench_indirect(const std::shared_ptr<const scene::Scene>& scene,
                                   const IndirectBenchOptions& options, const Progress& progress = {},
                                   const std::function<void(const IndirectRow&)>& on_row = {});

}   // namespace gnomon::bench
