// SPDX-License-Identifier: Apache-2.0
#pragma once
// A logical device with one queue for graphics, compute and copies, and the allocator of its memory.
//
// Objects that are created on a device keep it alive. Not thread-safe: use a device from one thread.

#include <functional>
#include <memory>
#include <string>

#include "vk/instance.h"
#include "vk/memory.h"

namespace gnomon::vk {

/// Requirements and limits of a device for ray tracing.
struct RayLimits {
    std::uint32_t handle_bytes = 0;        // of a shader group
    std::uint32_t handle_alignment = 1;    // of records in a shader binding table
    std::uint32_t table_alignment = 1;     // of the table's parts
    std::uint32_t scratch_alignment = 1;   // of scratch memory
    std::uint64_t most_rays = 0;           // per trace
    std::uint64_t most_instances = 0;      // per top level
    std::uint64_t most_triangles = 0;      // per bottom level
};

class Device : public std::enable_shared_from_this<Device> {
 public:
    /// Opens the best suitable device.
    /// @throws MissingError  no Vulkan, no suitable device (with the reasons), or the device cannot be opened
    static std::shared_ptr<Device> open();
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkDevice handle() const { return handle_; }
    VkPhysicalDevice physical() const { return info_.handle; }
    VkQueue queue() const { return queue_; }
    std::uint32_t queue_family() const { return info_.queue_family; }
    const DeviceInfo& info() const { return info_; }
    const VkPhysicalDeviceLimits& limits() const { return limits_; }
    /// Whether it supports acceleration structures and ray-tracing pipelines (ray queries are not needed).
    bool traces_rays() const { return info_.no_rays.empty(); }
    /// @throws MissingError  the size exceeds the device's limit on a storage buffer's range
    void check_storage_range(const std::string& name, VkDeviceSize bytes) const;
    const RayLimits& ray_limits() const { return ray_limits_; }
    /// Nanoseconds per timestamp step; 0: no timestamps.
    double timestamp_period() const { return timestamp_period_; }
    const Instance& instance() const { return *instance_; }
    Memory& memory() { return *memory_; }

    /// Names an object for debuggers and validation messages.
    void name(VkObjectType type, std::uint64_t object, const std::string& name) const;

 private:
    Device();
    std::shared_ptr<Instance> instance_;
    DeviceInfo info_;
    VkPhysicalDeviceLimits limits_{};
    RayLimits ray_limits_;
    double timestamp_period_ = 0;
    VkDevice handle_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::unique_ptr<Memory> memory_;
};

/// Owns one Vulkan handle: destroys it, can be moved but not copied.
template <class Handle>
class Owned {
 public:
    using Destroy = void (*)(const Device&, Handle);
    Owned() = default;
    Owned(std::shared_ptr<const Device> device, Handle handle, Destroy destroy)
        : device_(std::move(device)), handle_(handle), destroy_(destroy)
    {
    }
    Owned(Owned&& other) noexcept { swap(other); }
    Owned& operator=(Owned&& other) noexcept
    {
        Owned(std::move(other)).swap(*this);
        return *this;
    }
    ~Owned()
    {
        if (handle_) destroy_(*device_, handle_);
    }
    Handle get() const { return handle_; }
    explicit operator bool() const { return handle_ != VK_NULL_HANDLE; }
    void swap(Owned& other) noexcept
    {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        std::swap(destroy_, other.destroy_);
    }

 private:
    std::shared_ptr<const Device> device_;
    Handle handle_ = VK_NULL_HANDLE;
    Destroy destroy_ = nullptr;
};

}   // namespace gnomon::vk
