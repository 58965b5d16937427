// SPDX-License-Identifier: Apache-2.0
#pragma once
// Pipelines for dynamic rendering, compute and ray tracing. The descriptor layout (one set, pushed) comes from
// reflection.
//
// Vertex attributes are tightly packed, with one buffer per location. Viewport, scissor and cull mode are dynamic.

#include <string>
#include <vector>

#include "vk/device.h"
#include "vk/resource.h"
#include "vk/shader.h"

namespace gnomon::vk {

struct GraphicsDesc {
    std::string name;
    ShaderCode vertex;
    ShaderCode fragment;   // empty: depth only
    std::vector<VkFormat> colors{};
    VkFormat depth = VK_FORMAT_UNDEFINED;
    VkCompareOp depth_compare = VK_COMPARE_OP_GREATER;   // reversed depth: near is 1
    bool depth_write = true;
    bool depth_clamp = false;
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    std::vector<BlockExpectation> blocks{};
    std::vector<std::uint32_t> constants{};   // specialisation constants 0, 1, ...
};

struct ComputeDesc {
    std::string name;
    ShaderCode code;
    std::vector<BlockExpectation> blocks{};
    std::vector<std::uint32_t> constants{};
};

/// A pipeline for visibility rays: one ray generation shader, one miss shader, and one hit group for triangles, whose
/// any-hit shader may ignore hits.
struct RayDesc {
    std::string name;
    ShaderCode generation, miss;
    ShaderCode any_hit{};   // empty: every hit counts
    std::vector<BlockExpectation> blocks{};
    std::vector<std::uint32_t> constants{};
};

/// The shader binding table of a ray-tracing pipeline, as Vulkan structures.
struct ShaderTable {
    VkStridedDeviceAddressRegionKHR generation{}, miss{}, hit{}, callable{};
};

class Pipeline {
 public:
    Pipeline() = default;
    /// @throws MissingError   the device cannot create it
    /// @throws InternalError  the stages or the host's structures disagree
    Pipeline(const std::shared_ptr<Device>& device, const GraphicsDesc& desc);
    Pipeline(const std::shared_ptr<Device>& device, const ComputeDesc& desc);
    /// @pre the device supports ray tracing
    Pipeline(const std::shared_ptr<Device>& device, const RayDesc& desc);

    VkPipeline handle() const { return pipeline_.get(); }
    VkPipelineLayout layout() const { return layout_.get(); }
    VkPipelineBindPoint bind_point() const { return bind_point_; }
    const std::string& name() const { return name_; }
    const std::vector<Binding>& bindings() const { return bindings_; }   // of all stages, by number
    std::uint32_t push_bytes() const { return push_bytes_; }
    VkShaderStageFlags stages() const { return stages_; }
    const std::uint32_t* local_size() const { return local_size_; }
    std::uint32_t vertex_buffers() const { return vertex_buffers_; }
    std::size_t color_targets() const { return color_targets_; }
    const ShaderTable& table() const { return table_; }
    explicit operator bool() const { return static_cast<bool>(pipeline_); }

 private:
    void merge(const Reflection& reflection);
    void make_layout(const std::shared_ptr<Device>& device);
    void make_table(const std::shared_ptr<Device>& device, std::uint32_t groups);

    std::string name_;
    VkPipelineBindPoint bind_point_ = VK_PIPELINE_BIND_POINT_GRAPHICS;
    std::vector<Binding> bindings_;
    std::uint32_t push_bytes_ = 0, vertex_buffers_ = 0;
    std::uint32_t local_size_[3]{1, 1, 1};
    std::size_t color_targets_ = 0;
    VkShaderStageFlags stages_ = 0;
    Owned<VkDescriptorSetLayout> set_layout_;
    Owned<VkPipelineLayout> layout_;
    Owned<VkPipeline> pipeline_;
    Buffer table_memory_;
    ShaderTable table_;
};

}   // namespace gnomon::vk
