// SPDX-License-Identifier: Apache-2.0
#pragma once
// The loader, the instance and what devices there are, each with the reasons why it cannot be used.
//
// One instance a process, alive as long as somebody holds it. Validation (core and synchronisation) is on where the
// environment has GNOMON_VULKAN_VALIDATION=1, as all tests have: its messages are kept here, and whoever submits work
// throws the first of them as an InternalError.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// A physical device as `gnomon devices` lists it.
struct DeviceInfo {
    std::string name;
    std::string kind;                // "discrete", "integrated", "virtual", "software", "other"
    std::string driver;              // name and version
    std::uint32_t api_version = 0;   // as Vulkan packs it
    std::uint64_t memory = 0;        // bytes of device-local heaps
    bool suitable = false;
    bool chosen = false;                // what a Device takes
    std::vector<std::string> reasons;   // why it is not suitable; else why it was chosen, or another was
    std::vector<std::string> no_rays;   // what it lacks for tracing rays (Device::traces_rays); empty: nothing
    std::uint32_t queue_family = 0;     // graphics and compute
    VkPhysicalDevice handle = VK_NULL_HANDLE;
};

class Instance {
 public:
    /// The process's instance, made if there is none.
    /// @throws MissingError  no loader, no driver, or validation was asked for and is not installed
    static std::shared_ptr<Instance> get();
    ~Instance();
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    VkInstance handle() const { return handle_; }
    bool validates() const { return messenger_ != VK_NULL_HANDLE; }
    bool has_debug_utils() const { return debug_utils_; }

    /// Every device, the suitable ones first, best first: discrete, integrated, virtual, software.
    std::vector<DeviceInfo> devices() const;

 private:
    Instance();
    VkInstance handle_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    bool debug_utils_ = false;
};

/// What validation said since the last call, in order; process-wide. Thread-safe.
std::vector<std::string> take_validation_messages();
/// @throws InternalError  with the first message, if there is any; takes all
void check_validation();

}   // namespace gnomon::vk
