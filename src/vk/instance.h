// SPDX-License-Identifier: Apache-2.0
#pragma once
// The Vulkan loader, the instance and the list of devices, each with the reasons why it cannot be used.
//
// There is one instance per process, alive while it is referenced. Validation (core and synchronisation) is enabled by
// the environment variable GNOMON_VULKAN_VALIDATION=1, which all tests set. Its messages are collected here; the next
// submit throws the first one as an InternalError.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Properties of a physical device, listed by `gnomon devices`.
struct DeviceInfo {
    std::string name;
    std::string kind;                // "discrete", "integrated", "virtual", "software", "other"
    std::string driver;              // name and version
    std::uint32_t api_version = 0;   // in Vulkan's packed format
    std::uint64_t memory = 0;        // bytes of device-local heaps
    bool suitable = false;
    bool chosen = false;                // selected by Device::open
    std::vector<std::string> reasons;   // why it is not suitable, or why it or another device was selected
    std::vector<std::string> no_rays;   // missing features for ray tracing (Device::traces_rays); empty: none
    std::uint32_t queue_family = 0;     // graphics and compute
    VkPhysicalDevice handle = VK_NULL_HANDLE;
};

class Instance {
 public:
    /// The instance of the process, created on first use.
    /// @throws MissingError  no loader, no driver, or validation was requested and is not installed
    static std::shared_ptr<Instance> get();
    ~Instance();
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    VkInstance handle() const { return handle_; }
    bool validates() const { return messenger_ != VK_NULL_HANDLE; }
    bool has_debug_utils() const { return debug_utils_; }

    /// All devices, suitable ones first, in the order discrete, integrated, virtual, software.
    std::vector<DeviceInfo> devices() const;

 private:
    Instance();
    VkInstance handle_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    bool debug_utils_ = false;
};

/// Validation messages since the last call, in order, for the whole process. Thread-safe.
std::vector<std::string> take_validation_messages();
/// @throws InternalError  with the first message, if there is any; discards all messages
void check_validation();

}   // namespace gnomon::vk
