// SPDX-License-Identifier: Apache-2.0
#pragma once
// bench indirect as a section of a report: Tables 1 to 3 and Figures 7 to 9 of [Ki and Oh 2007] with its printed values
// beside ours, and what the reference says of each.

#include "bench/indirect/bench.h"
#include "bench/indirect/vulkan.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"
#include "gnomon/scene.h"

namespace gnomon::bench {

struct IndirectStudy {
    std::string scene, command;
    std::string device;                 // Vulkan's; empty: all on the processor
    std::optional<LargeGather> large;   // on a Vulkan device, where every pixel gathers
    IndirectBenchOptions options;
    IndirectBenchResult result;
    Frame direct;   // of the frame of which images are kept, with the layer `direct`; none: no images
};

/// What the tables ask for: limit levels, thresholds, and samples in a disk as published and in one that covers the
/// map.
std::vector<IndirectMethodInfo> indirect_methods_of_paper(const IndirectSettings& settings);

/// What the lamps add without a bounce, in the frame that is shown, for IndirectStudy::direct.
Frame direct_light(const Scene& scene, const IndirectStudy& study);

void add_indirect_section(ReportPage& page, const IndirectStudy& study);

/// The document of bench indirect.
nlohmann::ordered_json indirect_json(const IndirectStudy& study);

}   // namespace gnomon::bench
