// SPDX-License-Identifier: Apache-2.0
#pragma once
// What shadow culling saves: the shadow pass of every frame of a range, with every ray traced, with the
// published culling and with certified culling, on the same primary hits.
//
// `off` traces every facing (point, light) pair in packets against one tree that holds everything. Times are process
// CPU time of the whole pass, certificates included; Embree's builds are left out for both.

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "gnomon/types.h"
#include "scene/scene.h"
#include "shadow_culling/paper_culling.h"

namespace gnomon::app {

struct CullingBenchOptions {
    FrameRange frames{1, 100};
    Size size{512, 512};
    int threads = 1;
    double pixels_per_part = 8;
    bool paper = true, certified = true;   // methods to run beside `off`
    bool counts = true;                    // nodes and triangle tests on the counting kd-tree; slow, outside all times
    shadow_culling::PaperOptions paper_options;
};

struct CullingFrame {
    int frame = 1;
    struct Off {
        std::uint64_t rays = 0, nodes = 0, tests = 0;
        double ms = 0, wall_ms = 0;
    } off;
    // Wrong: (pixel, light) results that differ from `off`.
    struct Paper {
        std::uint64_t rays = 0, skipped = 0, dynamic_only = 0, nodes = 0, tests = 0, wrong = 0;
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

struct CullingBenchResult {
    std::vector<CullingFrame> frames;
    double speedup_mean = 0, speedup_steady = 0, first_frame_ratio = 0, worst_frame_ratio = 0;
    double paper_extra_tests_per_pixel = 0, paper_wrong_mean = 0;   // a frame
    std::uint64_t wrong_total = 0, bytes = 0, visible_triangles = 0;
    // Percent of `off`, from the counts: means are over frames.
    struct Saved {
        double nodes_mean = 0, nodes_best = 0, tests_mean = 0, tests_best = 0;
    } paper_saved, certified_saved;
};

CullingBenchResult bench_culling(const std::shared_ptr<const scene::Scene>& scene, const CullingBenchOptions& options,
                                 const std::function<void(const CullingFrame&)>& on_frame = {});

}   // namespace gnomon::app
