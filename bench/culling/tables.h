// SPDX-License-Identifier: Apache-2.0
#pragma once
// Tables of bench culling over any number of windows, beside what the paper prints [Nah 2009, Table 4 and 3.2].

#include <span>
#include <string>

#include "bench/culling/window.h"
#include "bench/report/page.h"

namespace gnomon::bench {

struct PrintedCulling {
    const char* scene;
    const char* figure;   // its frames one by one
    const char* file;     // how names of its files begin
    int frames;
    double nodes_mean, nodes_best, tests_mean, tests_best;   // per cent saved
    int nodes_best_frame, tests_best_frame;
    double extra_tests_per_pixel;
};

/// The printed values of this scene; nullptr if the paper does not have it.
const PrintedCulling* printed_culling_of(const std::string& scene);

/// Table 4: per cent saved, mean and best. Windows with counts alone.
ReportTable table_of_savings(std::span<const CullingWindow> windows);

/// How much faster than tracing every ray certified culling is. Windows with it alone.
ReportTable table_of_speed(std::span<const CullingWindow> windows);

}   // namespace gnomon::bench
