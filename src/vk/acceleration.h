// SPDX-License-Identifier: Apache-2.0
#pragma once
// Acceleration structures for ray tracing on devices that support it (Device::traces_rays).
//
// A bottom level (BLAS) is built over triangles in buffers, a top level (TLAS) over instances of bottom levels. A
// structure is stored in a buffer; passes declare that buffer, and several structures may share one. Recorder::build
// builds structures; the caller provides the scratch memory.

#include <memory>
#include <utility>
#include <vector>

#include "vk/resource.h"

namespace gnomon::vk {

/// One geometry of a bottom level: triangles with 32-bit indices and positions of three floats, in buffers.
struct TriangleGeometry {
    const Buffer* positions = nullptr;
    std::uint32_t first_position = 0;   // position in the buffer to which index 0 refers
    std::uint32_t position_count = 0;
    const Buffer* indices = nullptr;
    std::uint32_t first_index = 0;
    std::uint32_t triangles = 0;
    const Buffer* matrices = nullptr;   // VkTransformMatrixKHR that transforms the positions; null: none
    std::uint32_t matrix = 0;
    bool opaque = true;   // every hit counts; otherwise the pipeline's any-hit shader decides
};

/// The geometry from which a structure is built.
struct StructureDesc {
    std::vector<TriangleGeometry> triangles{};   // of a bottom level
    const Buffer* instances = nullptr;           // of a top level: VkAccelerationStructureInstanceKHR
    std::uint32_t instance_count = 0;
    bool often = false;   // rebuilt often, so prefer fast builds over fast tracing

    bool top() const { return instances != nullptr; }
};

/// Sizes of a structure and of the scratch memory for building it.
struct StructureBytes {
    VkDeviceSize storage = 0, scratch = 0;
};
StructureBytes structure_bytes(const Device& device, const StructureDesc& desc);

/// Required alignment of structures in their buffer.
inline constexpr VkDeviceSize k_structure_alignment = 256;

constexpr VkDeviceSize round_up(VkDeviceSize value, VkDeviceSize alignment)
{
    return (value + alignment - 1) / alignment * alignment;
}

class AccelerationStructure {
 public:
    AccelerationStructure() = default;
    /// A structure within a shared buffer. @pre offset % k_structure_alignment == 0
    AccelerationStructure(const std::shared_ptr<Device>& device, const std::string& name, bool top,
                          const std::shared_ptr<const Buffer>& storage, VkDeviceSize offset, VkDeviceSize bytes);
    /// A structure in a buffer of its own. @throws MissingError  too little memory
    AccelerationStructure(const std::shared_ptr<Device>& device, const std::string& name, bool top, VkDeviceSize bytes);

    VkAccelerationStructureKHR handle() const { return handle_.get(); }
    /// The address by which instances refer to a bottom level.
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
    std::shared_ptr<const Buffer> storage_;   // released after the structure in it
    Owned<VkAccelerationStructureKHR> handle_;
    VkDeviceAddress address_ = 0;
};

/// One structure to build, with its position in the scratch memory.
struct StructureBuild {
    const StructureDesc* desc = nullptr;
    const AccelerationStructure* to = nullptr;
    VkDeviceAddress scratch = 0;   // a multiple of RayLimits::scratch_alignment
};

/// A description as Vulkan structures. Contains pointers to itself, so it is neither copied nor moved once filled.
struct BuildInfo {
    std::vector<VkAccelerationStructureGeometryKHR> geometries;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
    VkAccelerationStructureBuildGeometryInfoKHR info{};
    void fill(const StructureDesc& desc);
};

}   // namespace gnomon::vk
