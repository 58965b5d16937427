// SPDX-License-Identifier: Apache-2.0
#pragma once
// What this machine renders with: the width of ray packets and the Vulkan devices.

#include <cstdint>
#include <string>
#include <vector>

namespace gnomon {

/// A Vulkan device of this machine, and whether and why it is used.
struct VulkanDevice {
    std::string name;
    std::string kind;                            // "discrete", "integrated", "virtual", "software", "other"
    std::string driver;                          // name and version
    std::string version;                         // of Vulkan: "1.3.250"
    std::uint64_t memory_bytes = 0;              // local to the device
    bool suitable = false;                       // for RenderMethod::raster
    bool chosen = false;                         // by RenderMethod::raster
    std::vector<std::string> reasons;            // why it is not suitable, or why it or another device was chosen
    std::vector<std::string> missing_for_rays;   // what it lacks for ray tracing; empty: it traces rays
};

/// What frames are rendered with.
struct Devices {
    int packet_width = 0;         // rays that the CPU traces at once
    bool vulkan_built = false;    // the library was built with Vulkan
    std::string vulkan_missing;   // why Vulkan cannot be used: no loader, no driver; empty: it can, or was not built
    /// Suitable ones first, in the order discrete, integrated, virtual, software.
    std::vector<VulkanDevice> vulkan;
};

/// Lists the devices of this machine. A machine without Vulkan is a result, not an error.
Devices devices();

}   // namespace gnomon
