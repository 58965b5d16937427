// SPDX-License-Identifier: Apache-2.0
#pragma once
// Measures proven visibility of lights with size (area_light/) beside packets of shadow rays: how much is proven, how
// right it is, and what it costs.
//
// The points are the primary hits of each frame. Every point and spot light of the scene becomes a square at its place,
// facing along its node's -Z; every emissive polygon stays what it is. Times are process CPU time of one thread, for
// all points of a frame and one light, points known. The opponent traces rays to stratified places of the light, all of
// a point together, in Embree's widest native packets. The truth for both are rays to many more places, for some of the
// points, in eight to fifteen of a clip's frames. Soft shadow textures [Soler and Sillion 1998] are compared with the
// same truth.

#include <memory>
#include <vector>

#include "area_light/area_shadows.h"
#include "gnomon/types.h"
#include "scene/scene.h"

namespace gnomon::bench {

struct LightsBenchOptions {
    FrameRange frames{1, 1};
    Size size{512, 512};
    scene::CameraId camera = 0;
    float side = 0.3f;   // of the squares, metres
    std::vector<int> samples = {16, 64, 256};
    int check = 64;                     // segments traced for every proven answer
    int truth = 16384;                  // rays of a point to find the truth
    int truth_points = 2000;            // points of a frame and light that are compared with the truth
    int repeats = 3;                    // of the steady frame and of the opponents; the least time counts
    area_light::AreaOptions proofs{};   // what is measured
};

struct LightsBenchResult {
    struct Error {
        double rmse = 0, max_abs = 0;   // of the visible share of the irradiance
    };
    struct Row {
        std::string light;
        // Shares of the points that light could reach: lit, dark or listed parts, and those that rays decide.
        double lit = 0, dark = 0, penumbra = 0, unproven = 0;
        std::uint64_t points = 0, wrong = 0, segments = 0;   // wrong: segments that contradict a proven answer
        double ms_cold = 0, ms_steady = 0;
        Error error;
        double triangles = 0;            // tested for a point in a listed part, mean
        std::vector<double> soft_rmse;   // of soft textures, as in `soft`; empty for lights after the eighth
    };
    struct Opponent {
        int samples = 0;
        double ms = 0;   // mean over lights and frames
        Error error;
    };
    struct Soft {   // soft shadow textures, kept (soft.h)
        const char* name = "";
        Error error;
        std::uint64_t leaks = 0, darkest = 0;   // points that see next to nothing, and of these, those lit by a tenth
        std::size_t textures = 0;               // of all lights
        double updated = 0;                     // in a frame after the first, mean
        double ms_first = 0, ms_then = 0;       // to draw views and textures of all lights; mean of later frames
    };
    std::vector<Row> rows;
    std::vector<Opponent> opponents;
    std::vector<Soft> soft;
    double truth_rmse = 0;   // of the truth itself, estimated from its halves
    std::size_t bytes = 0;
};

/// @throws UsageError  the scene has no light that could have a size
LightsBenchResult bench_lights(const std::shared_ptr<const scene::Scene>& scene, const LightsBenchOptions& options,
                               const Progress& progress = {});

}   // namespace gnomon::bench
