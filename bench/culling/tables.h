// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tables of bench culling over any number of windows, with the values that the paper prints [Nah 2009, Table 4
// and 3.2].

#include <span>
#include <string>

#include "bench/culling/window.h"
#include "bench/report/page.h"

namespace gnomon::bench {

struct PrintedCulling {
    const char* scene;
    const char* figure;   // the figure that shows every frame
    const char* file;     // beginning of the name of its files
    int frames;
    double nodes_mean, nodes_best, tests_mean, tests_best;   // percent saved
    int nodes_best_frame, tests_best_frame;
    double extra_tests_per_pixel;
};

/// The printed values for a scene; nullptr if the scene is not in the paper.
const PrintedCulling* printed_culling_of(const std::string& scene);

/// Table 4: percent saved, mean and best, for those windows that have counts.
ReportTable table_of_savings(std::span<const CullingWindow> windows);

/// Where the published method's shadow rays go, in percent of all: why each of those traced against everything was, for
/// those windows that measured it.
ReportTable table_of_reasons(std::span<const CullingWindow> windows);

/// Other readings and the extensions of the published method, for those windows that measured some.
ReportTable table_of_readings(std::span<const CullingWindow> windows);

/// Savings of the published method against the step between frames, for those windows that measured several.
ReportTable table_of_steps(std::span<const CullingWindow> windows);

/// Savings of the published method on each layout of the kd-tree [Nah 2009, Fig. 4].
ReportTable table_of_trees(std::span<const CullingWindow> windows);

/// The speed-up of certified culling over tracing every ray, for those windows that measured it.
ReportTable table_of_speed(std::span<const CullingWindow> windows);

}   // namespace gnomon::bench
