// SPDX-License-Identifier: Apache-2.0
#pragma once
// What shadow culling saves: the shadow pass of every frame of a range, with every ray traced, with the
// published culling and with certified culling, on the same hits.
//
// `off` traces every facing (point, light) pair in packets against one tree that holds everything. Times are process
// CPU time of the whole pass, certificates included; Embree's builds are left out for both.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "base/image.h"
#include "gnomon/types.h"
#include "scene/scene.h"
#include "shadow_culling/nah2009/paper_culling.h"

namespace gnomon::bench {

struct CullingBenchOptions {
    FrameRange frames{1, 100};
    Size size{512, 512};
    scene::CameraId camera = 0;
    int threads = 1;
    int max_depth = 0;   // reflections and refractions in a row whose hits ask for shadows, too
    int repeat = 1;      // runs; times are their medians
    double pixels_per_part = 8;
    bool paper = true, certified = true;   // methods to run beside `off`
    bool counts = true;                    // nodes and triangle tests on the counting kd-tree; slow, outside all times
    bool images = false;                   // of the frame in which the published method has most wrong
    shadow_culling::PaperOptions paper_options;
};

struct CullingFrame {
    int frame = 1;
    struct Off {
        std::uint64_t rays = 0, nodes = 0, tests = 0;
        double ms = 0, wall_ms = 0;
    } off;
    // Wrong: (point, light) results that differ from `off`.
    struct Paper {
        std::uint64_t rays = 0, skipped = 0, dynamic_only = 0, nodes = 0, tests = 0, extra_tests = 0, wrong = 0;
        double extra_tests_per_pixel = 0;
        double ms = 0, wall_ms = 0;
    } paper;
    struct Certified {
        std::uint64_t rays = 0, skipped = 0, dynamic_only = 0, partial = 0, certificates = 0, certified = 0, nodes = 0,
                      tests = 0, wrong = 0;
        double ms = 0, wall_ms = 0;
        double judge_ms = 0;   // wall, of wall_ms
    } certified;
};

/// The frame with most wrong results of the published method; see culling_images.h.
struct WrongImages {
    int frame = 0;
    std::uint64_t wrong = 0;
    Image8 off, paper, difference;
};

struct CullingBenchResult {
    std::vector<CullingFrame> frames;
    double speedup_mean = 0, speedup_steady = 0;           // off / certified: of sums; over the second half
    double first_frame_ratio = 0, worst_frame_ratio = 0;   // certified / off, wall time
    double later_frames_ratio = 0;                         // certified / off, of sums, from the second frame on
    double paper_extra_tests_per_pixel = 0, paper_wrong_mean = 0;   // a frame
    std::uint64_t wrong_total = 0, bytes = 0, mask_bytes = 0, visible_triangles = 0;
    std::uint64_t most_evidence_bytes = 0;   // at once, until it was judged
    std::uint64_t paper_bytes = 0;
    double bytes_per_triangle_light = 0;   // per visible triangle and light, of certified
    // Percent of `off`, from the counts. Mean and best: over the frames' percentages; of totals: of the frames' sums.
    struct Saved {
        double nodes_mean = 0, nodes_best = 0, tests_mean = 0, tests_best = 0;
        double nodes_of_totals = 0, tests_of_totals = 0;
        int nodes_best_frame = 0, tests_best_frame = 0;
    } paper_saved, certified_saved;
    std::optional<WrongImages> images;
};

/// @param progress  asked before every frame
/// @param on_frame  told every frame of the first run
/// @throws InterruptedError  progress returned false
/// @throws InternalError     counts differ between two runs
CullingBenchResult bench_culling(const std::shared_ptr<const scene::Scene>& scene, const CullingBenchOptions& options,
                                 const Progress& progress = {},
                                 const std::function<void(const CullingFrame&)>& on_frame = {});

}   // namespace gnomon::bench
