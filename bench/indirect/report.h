// SPDX-License-Identifier: Apache-2.0
#pragma once
// Writes the results of bench indirect as a section of a report: Tables 1 to 3 and Figures 1, 3, 5 and 7 to 10 of [Ki
// and Oh 2007], and errors against the reference. Printed values stand beside ours only for the scene that they were
// printed for.

#include "bench/indirect/bench.h"
#include "bench/indirect/device_frames.h"
#include "bench/indirect/vulkan.h"
#include "bench/report/page.h"
#include "gnomon/frame.h"
#include "gnomon/scene.h"

namespace gnomon::bench {

/// The scene of the paper that a study measures.
enum class PaperScene : std::uint8_t { none, cornell, buddha, sponza };

struct IndirectStudy {
    std::string scene, command;
    std::string device;                 // the Vulkan device; empty if everything ran on the CPU
    std::optional<LargeGather> large;   // measured on a Vulkan device with receivers at every pixel
    PaperScene printed = PaperScene::none;
    std::string description;   // of the scene, for the page; may be empty
    IndirectBenchOptions options;
    IndirectBenchResult result;
    std::vector<DeviceFramesResult> device_frames;         // whole frames on a Vulkan device, if measured
    std::string no_device;                                 // why there are none
    std::vector<NamedImage> map_images, validity_images;   // Figures 3 and 5, if asked for
    Frame direct;   // direct light of the frame whose images are kept, with the layer `direct`; empty: no images
};

/// The methods in the tables: limit levels, thresholds, and numbers of samples in a disk of the published radius and in
/// one that covers the map.
std::vector<IndirectMethodInfo> indirect_methods_of_paper(const IndirectSettings& settings);
/// The paper's scene by the name of a scene: builtin:cornell, or none.
PaperScene paper_scene_of(const std::string& scene);

/// Renders the direct light of the frame whose images are kept, for IndirectStudy::direct.
Frame direct_light(const Scene& scene, const IndirectStudy& study);

void add_indirect_section(ReportPage& page, const IndirectStudy& study);

/// The JSON document of bench indirect.
nlohmann::ordered_json indirect_json(const IndirectStudy& study);

}   // namespace gnomon::bench
