// SPDX-License-Identifier: Apache-2.0
#pragma once
// Acceleration structures: what rays are traced against, on devices that do (Device::traces_rays).
//
// A bottom level is built over triangles that lie in buffers, a top level over instances of bottom levels. Where a
// structure lies is a buffer; that is what passes declare and wait for, so many structures may share one. Building is
// Recorder::build; the memory that builds work in is the caller's.

#include <memory>
#include <utility>
#include <vector>

#include "vk/resource.h"

namespace gnomon::vk {

/// One geometry of a bottom level: triangles with 32-bit indices and positions of three floats, as they lie in buffers.
struct TriangleGeometry {
    const Buffer* positions = nullptr;
    std::uint32_t first_position = 0;   // of the buffer: what index 0 means
    std::uint32_t position_count = 0;
    const Buffer* indices = nullptr;
    std::uint32_t first_index = 0;
    std::uint32_t triangles = 0;
    const Buffer* matrices = nullptr;   // VkTransformMatrixKHR: positions are moved by one of them; null: they are not
    std::uint32_t matrix = 0;
    bool opaque = true;   // every hit counts; else the pipeline's any-hit shader is asked
};

/// What a structure is built from.
struct StructureDesc {
    std::vector<TriangleGeometry> triangles{};   // of a bottom level
    const Buffer* instances = nullptr;           // of a top level: VkAccelerationStructureInstanceKHR
    std::uint32_t instance_count = 0;
    bool often = false;   // it is rebuilt often: better built fast than traced fast

    bool top() const { return instances != nullptr; }
};

/// What it takes: where it lies, and what its build works in.
struct StructureBytes {
    VkDeviceSize storage = 0, scratch = 0;
};
StructureBytes structure_bytes(const Device& device, const StructureDesc& desc);

/// Structures begin at multiples of this in their buffer.
inline constexpr VkDeviceSize k_structure_alignment = 256;

constexpr VkDeviceSize round_up(VkDeviceSize value, VkDeviceSize alignment)
{
    return (value + alignment - 1) / alignment * alignment;
}

class AccelerationStructure {
 public:
    AccelerationStructure() = default;
    /// In a buffer of others, which must live as long. @pre offset % k_structure_alignment == 0
    AccelerationStructure(const std::shared_ptr<Device>& device, const std::string& name, bool top,
                          const std::shared_ptr<const Buffer>& storage, VkDeviceSize offset, VkDeviceSize bytes);
    /// In a buffer of its own. @throws MissingError  too little memory
    AccelerationStructure(const std::shared_ptr<Device>& device, const std::string& name, bool top, VkDeviceSize bytes);

    VkAccelerationStructureKHR handle() const { return handle_.get(); }
    /// What instances refer to a bottom level by.
    VkDeviceAddress address() const { return address_; }
    const Buffer& storage() const { return *storage_; }
    explicit operator bool() const { return static_cast<bool>(handle_); }

    AccelerationStructure(AccelerationStructure&& other) noexcept { swap(other); }
    AccelerationStructure& operator=(AccelerationStructure&& other) noexcept
    {
        AccelerationStructure(std::move(other)).swap(*this);
        return *this;
    }
    ~AccelerationStructure() = default;
    void swap(AccelerationStructure& other) noexcept
    {
        std::swap(storage_, other.storage_);
        std::swap(handle_, other.handle_);
        std::swap(address_, other.address_);
    }

 private:
    std::shared_ptr<const Buffer> storage_;   // goes after what lies in it
    Owned<VkAccelerationStructureKHR> handle_;
    VkDeviceAddress address_ = 0;
};

/// One structure to build, and where in the scratch memory.
struct StructureBuild {
    const StructureDesc* desc = nullptr;
    const AccelerationStructure* to = nullptr;
    VkDeviceAddress scratch = 0;   // a multiple of RayLimits::scratch_alignment
};

/// A description as Vulkan wants it. Points into itself: neither copied nor moved once filled.
struct BuildInfo {
    std::vector<VkAccelerationStructureGeometryKHR> geometries;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
    VkAccelerationStructureBuildGeometryInfoKHR info{};
    void fill(const StructureDesc& desc);
};

}   // namespace gnomon::vk
