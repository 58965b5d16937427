// SPDX-License-Identifier: Apache-2.0
#pragma once
// bench culling as a section of a report: the paper's Table 4 and Figures 7 and 8 with its printed values beside ours
// [Nah 2009, 3], and what certified culling does on the same rays.

#include "app/culling_bench.h"
#include "app/report_page.h"

namespace gnomon::app {

struct CullingReport {
    std::string scene;     // as named on the command line
    std::string command;   // the whole command line
    bool moving_lights = false;
    std::size_t lights = 0;
};

void add_culling_section(ReportPage& page, const CullingReport& about, const CullingBenchOptions& options,
                         const CullingBenchResult& result, const nlohmann::ordered_json& document);

}   // namespace gnomon::app
