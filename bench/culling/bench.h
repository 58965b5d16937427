// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures shadow culling: runs the shadow pass of every frame of a range with every ray traced, with the published
// culling and with certified culling, on the same shading points.
//
// `off` traces every facing (point, light) pair in packets against one BVH of the whole scene. Times are process CPU
// times of the whole pass, including certificates and excluding Embree's builds.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/image.h"
#include "gnomon/types.h"
#include "ray/kdtree/kdtree.h"
#include "scene/scene.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "visibility/checks.h"

namespace gnomon::bench {

/// Another reading or extension of the published method, measured beside it on the same points.
struct PaperReading {
    std::string name;    // a word, for JSON
    std::string label;   // for tables
    shadow_culling::PaperOptions options;
    bool caches_occluders = false;   // see OccluderCache; only in counts
};

struct CullingBenchOptions {
    FrameRange frames{1, 100};
    double step = 0;               // seconds between frames; 0: the clip's own frames
    std::optional<double> start;   // with a step: time of frame 1 in seconds; none: the start of the clip
    int between =
        1;   // with a step: the paper's method also sees frames between, so many a step, that are not measured
    Size size{512, 512};
    scene::CameraId camera = 0;
    int threads = 1;
    int max_depth = 0;   // largest number of reflections and refractions in a path; 0: primary hits only
    int repeat = 1;      // runs; times are medians over them
    double pixels_per_part = 8;
    bool paper = true, certified = true;   // methods to run in addition to `off`
    bool counts = true;                    // count nodes and triangle tests on the kd-tree; slow, excluded from times
    bool images = false;                   // keep images of the frame with the most wrong results
    shadow_culling::PaperOptions paper_options;
    visibility::LeftOut left_out;         // checks of the certified method, for tests
    std::vector<PaperReading> readings;   // besides `paper`
    ray::KdLayout layout = ray::KdLayout::separate;
};

/// The time of a frame, or of a fraction of one.
double time_of(const CullingBenchOptions& options, const scene::Timeline& timeline, double frame);
/// With a step: the number of frames up to the end of the clip; at least 1.
int steps_in(const scene::Timeline& timeline, const CullingBenchOptions& options);

struct CullingFrame {
    int frame = 1;
    double time = 0;   // seconds
    struct Off {
        std::uint64_t rays = 0, nodes = 0, tests = 0;
        double ms = 0, wall_ms = 0;
    } off;
    // `wrong` counts (point, light) results that differ from `off`.
    struct Paper {
        std::uint64_t rays = 0, skipped = 0, dynamic_only = 0, nodes = 0, tests = 0, extra_tests = 0, wrong = 0;
        double extra_tests_per_pixel = 0;
        double ms = 0, wall_ms = 0;
        std::array<std::uint64_t, shadow_culling::k_full_reasons> full{};   // rays against everything, by FullReason
        std::uint64_t cache_tests = 0, cache_hits = 0;                      // with OccluderCache
    } paper;
    std::vector<Paper> readings;   // as CullingBenchOptions::readings
    struct Certified {
        std::uint64_t rays = 0, skipped = 0, dynamic_only = 0, traced = 0, partial = 0, certificates = 0, certified = 0,
                      nodes = 0, tests = 0, wrong = 0;
        double ms = 0, wall_ms = 0;
        double judge_ms = 0;   // wall time for proving certificates, included in wall_ms
    } certified;
};

/// The frame with the most wrong results of the published method; see bench/culling/images.h.
struct WrongImages {
    int frame = 0;
    std::uint64_t wrong = 0;
    Image8 off, paper, difference;
};

struct CullingBenchResult {
    std::vector<CullingFrame> frames;
    double speedup_mean = 0, speedup_steady = 0;           // off / certified of summed times: all frames; second half
    double first_frame_ratio = 0, worst_frame_ratio = 0;   // certified / off of wall times; worst: from the second on
    double later_frames_ratio = 0;                         // certified / off of summed times, from the second frame on
    double paper_extra_tests_per_pixel = 0, paper_wrong_mean = 0;   // means per frame
    std::uint64_t wrong_total = 0, bytes = 0, mask_bytes = 0, visible_triangles = 0;
    std::uint64_t most_evidence_bytes = 0;   // peak size of the evidence that waits for proof
    std::uint64_t paper_bytes = 0;
    double bytes_per_triangle_light = 0;   // of certified culling, per visible triangle and light
    // Percent saved of the counts of `off`. Mean and best are over the frames' percentages, of_totals over their sums.
    struct Saved {
        double nodes_mean = 0, nodes_best = 0, tests_mean = 0, tests_best = 0;
        double nodes_of_totals = 0, tests_of_totals = 0;
        int nodes_best_frame = 0, tests_best_frame = 0;
    } paper_saved, certified_saved;
    struct Reading {
        Saved saved;
        double extra_tests_per_pixel = 0, wrong_mean = 0;
        std::uint64_t bytes = 0;
    };
    std::vector<Reading> readings;
    // The build of the kd-tree after the last frame: nodes, and those that were split at bounds of the scene graph.
    std::uint64_t tree_nodes = 0, tree_group_splits = 0;
    std::optional<WrongImages> images;
};

/// @param progress  called before every frame
/// @param on_frame  called after every frame of the first run
/// @throws InterruptedError  progress returned false
/// @throws InternalError     counts differ between two runs
CullingBenchResult bench_culling(const std::shared_ptr<const scene::Scene>& scene, const CullingBenchOptions& options,
                                 const Progress& progress = {},
                                 const std::function<void(const CullingFrame&)>& on_frame = {});

}   // namespace gnomon::bench
