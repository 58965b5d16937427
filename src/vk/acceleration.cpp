// SPDX-License-Identifier: Apache-2.0
#include "vk/acceleration.h"

#include <fmt/format.h>

#include "base/check.h"

namespace gnomon::vk {

namespace {

constexpr VkDeviceSize k_position_bytes = 3 * sizeof(float);

VkAccelerationStructureGeometryKHR describe(const TriangleGeometry& g)
{
    VkAccelerationStructureGeometryKHR result{};
    result.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    result.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    result.flags = g.opaque ? VK_GEOMETRY_OPAQUE_BIT_KHR : 0;
    VkAccelerationStructureGeometryTrianglesDataKHR& triangles = result.geometry.triangles;
    triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = g.positions->address() + g.first_position * k_position_bytes;
    triangles.vertexStride = k_position_bytes;
    triangles.maxVertex = g.position_count - 1;
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    triangles.indexData.deviceAddress = g.indices->address();
    if (g.matrices) triangles.transformData.deviceAddress = g.matrices->address();
    return result;
}

VkAccelerationStructureTypeKHR type_of(bool top)
{
    return top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
}

}   // namespace

void BuildInfo::fill(const StructureDesc& desc)
{
    for (const TriangleGeometry& g : desc.triangles) {
        GNOMON_CHECK(!desc.top() && g.position_count > 0);
        geometries.push_back(describe(g));
        // Drivers may add the offset to the null address of no matrices, and read there.
        const std::size_t matrix = g.matrices ? g.matrix * sizeof(VkTransformMatrixKHR) : 0;
        ranges.push_back({g.triangles, static_cast<std::uint32_t>(g.first_index * sizeof(std::uint32_t)), 0,
                          static_cast<std::uint32_t>(matrix)});
    }
    if (desc.top()) {
        VkAccelerationStructureGeometryKHR& all = geometries.emplace_back();
        all = {};
        all.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
        all.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
        all.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
        all.geometry.instances.data.deviceAddress = desc.instances->address();
        ranges.push_back({desc.instance_count, 0, 0, 0});
    }
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
    info.type = type_of(desc.top());
    info.flags = desc.often ? VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR
                            : VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = static_cast<std::uint32_t>(geometries.size());
    info.pGeometries = geometries.data();
}

StructureBytes structure_bytes(const Device& device, const StructureDesc& desc)
{
    BuildInfo build;
    build.fill(desc);
    std::vector<std::uint32_t> counts;
    for (const auto& range : build.ranges) counts.push_back(range.primitiveCount);
    VkAccelerationStructureBuildSizesInfoKHR sizes{};
    sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
    vkGetAccelerationStructureBuildSizesKHR(device.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR,
                                            &build.info, counts.data(), &sizes);
    return {round_up(sizes.accelerationStructureSize, k_structure_alignment),
            round_up(sizes.buildScratchSize, device.ray_limits().scratch_alignment)};
}

AccelerationStructure::AccelerationStructure(const std::shared_ptr<Device>& device, const std::string& name, bool top,
                                             const std::shared_ptr<const Buffer>& storage, VkDeviceSize offset,
                                             VkDeviceSize bytes)
    : storage_(storage)
{
    GNOMON_CHECK_EQ(offset % k_structure_alignment, 0u);
    VkAccelerationStructureCreateInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
    info.buffer = storage->handle();
    info.offset = offset;
    info.size = bytes;
    info.type = type_of(top);
    VkAccelerationStructureKHR structure = VK_NULL_HANDLE;
    check(vkCreateAccelerationStructureKHR(device->handle(), &info, nullptr, &structure),
          fmt::format("creating acceleration structure '{}'", name));
    handle_ = {device, structure, [](const Device& d, VkAccelerationStructureKHR s) {
                   vkDestroyAccelerationStructureKHR(d.handle(), s, nullptr);
               }};
    device->name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, reinterpret_cast<std::uint64_t>(structure), name);
    VkAccelerationStructureDeviceAddressInfoKHR where{};
    where.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
    where.accelerationStructure = structure;
    address_ = vkGetAccelerationStructureDeviceAddressKHR(device->handle(), &where);
}

AccelerationStructure::AccelerationStructure(const std::shared_ptr<Device>& device, const std::string& name, bool top,
                                             VkDeviceSize bytes)
    : AccelerationStructure(device, name, top, std::make_shared<const Buffer>(device, name, bytes), 0, bytes)
{
}

}   // namespace gnomon::vk
