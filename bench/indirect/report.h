// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes the results of bench indirect as a section of a report: Tables 1 to 3 and Figures 7 to 9 of [Ki and Oh 2007]
// with printed values next to ours, and errors against the reference.

#include "bench/indirect/bench.h"
#include "bench/indirect/vulkan.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"
#include "gnomon/scene.h"

namespace gnomon::bench {

struct IndirectStudy {
    std::string scene, command;
    std::string device;                 // the Vulkan device; empty if everything ran on the CPU
    std::optional<LargeGather> large;   // measured on a Vulkan device with receivers at every pixel
    IndirectBenchOptions options;
    IndirectBenchResult result;
    Frame direct;   // direct light of the frame whose images are kept, with the layer `direct`; empty: no images
};

/// The methods in the tables: limit levels, thresholds, and numbers of samples in a disk of the published radius and in
/// one that covers the map.
std::vector<IndirectMethodInfo> indirect_methods_of_paper(const IndirectSettings& settings);

/// Renders the direct light of the frame whose images are kept, for IndirectStudy::direct.
Frame direct_light(const Scene& scene, const IndirectStudy& study);

void add_indirect_section(ReportPage& page, const IndirectStudy& study);

/// The JSON document of bench indirect.
nlohmann::ordered_json indirect_json(const IndirectStudy& study);

}   // namespace gnomon::bench
