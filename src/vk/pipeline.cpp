// SPDX-License-Identifier: Apache-2.0
#include "vk/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/check.h"
#include "vk/acceleration.h"

namespace gnomon::vk {

namespace {

Owned<VkShaderModule> make_module(const std::shared_ptr<Device>& device, const ShaderCode& code)
{
    VkShaderModuleCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    info.codeSize = code.words.size_bytes();
    info.pCode = code.words.data();
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device->handle(), &info, nullptr, &module), fmt::format("loading {}", code.name));
    return {device, module, [](const Device& d, VkShaderModule m) { vkDestroyShaderModule(d.handle(), m, nullptr); }};
}

Owned<VkPipeline> own(const std::shared_ptr<Device>& device, VkPipeline pipeline)
{
    return {device, pipeline, [](const Device& d, VkPipeline p) { vkDestroyPipeline(d.handle(), p, nullptr); }};
}

// Specialisation constants 0 ... n - 1 as Vulkan structures. Contains pointers to itself and to its argument.
struct Specialization {
    std::vector<VkSpecializationMapEntry> entries;
    VkSpecializationInfo info{};
    explicit Specialization(const std::vector<std::uint32_t>& constants)
    {
        for (std::uint32_t i = 0; i < constants.size(); ++i) entries.push_back({i, i * 4, 4});
        info.mapEntryCount = static_cast<std::uint32_t>(entries.size());
        info.pMapEntries = entries.data();
        info.dataSize = constants.size() * 4;
        info.pData = constants.data();
    }
};

VkPipelineShaderStageCreateInfo stage_info(VkShaderStageFlagBits stage, VkShaderModule module,
                                           const Specialization& constants)
{
    VkPipelineShaderStageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage = stage;
    info.module = module;
    info.pName = "main";
    info.pSpecializationInfo = &constants.info;
    return info;
}

// Checks that a block that the host shares appears in at least one stage and has the same layout in each.
void check_blocks(const std::vector<BlockExpectation>& blocks, std::span<const ShaderCode> codes,
                  std::span<const Reflection> reflections)
{
    for (const BlockExpectation& block : blocks) {
        bool found = false;
        for (std::size_t i = 0; i < codes.size(); ++i) {
            const auto& bindings = reflections[i].bindings;
            const bool here = block.binding.empty()
                                  ? reflections[i].push_bytes > 0
                                  : std::any_of(bindings.begin(), bindings.end(),
                                                [&](const Binding& b) { return b.name == block.binding; });
            if (here) check_block(reflections[i], codes[i], block);
            found = found || here;
        }
        if (!found) fail_check(__FILE__, __LINE__, fmt::format("{}: no block '{}'", codes[0].name, block.binding));
    }
    for (std::size_t i = 0; i < codes.size(); ++i) check_all_expected(reflections[i], codes[i], blocks);
}

}   // namespace

// Adds a stage's bindings; a binding number must have the same meaning in all stages.
void Pipeline::merge(const Reflection& reflection)
{
    stages_ |= reflection.stage;
    push_bytes_ = std::max(push_bytes_, reflection.push_bytes);
    for (const Binding& binding : reflection.bindings) {
        const auto there = std::find_if(bindings_.begin(), bindings_.end(),
                                        [&](const Binding& b) { return b.binding == binding.binding; });
        if (there == bindings_.end()) {
            bindings_.push_back(binding);
            continue;
        }
        if (there->type != binding.type || there->count != binding.count || there->bytes != binding.bytes)
            fail_check(__FILE__, __LINE__,
                       fmt::format("{}: binding {} is '{}' in one stage and '{}' in another", name_, binding.binding,
                                   there->name, binding.name));
        there->stages |= binding.stages;
        there->writes = there->writes || binding.writes;
    }
    std::sort(bindings_.begin(), bindings_.end(),
              [](const Binding& a, const Binding& b) { return a.binding < b.binding; });
}

void Pipeline::make_layout(const std::shared_ptr<Device>& device)
{
    std::vector<VkDescriptorSetLayoutBinding> slots;
    for (const Binding& b : bindings_) slots.push_back({b.binding, b.type, b.count, b.stages, nullptr});
    VkDescriptorSetLayoutCreateInfo set{};
    set.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    set.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    set.bindingCount = static_cast<std::uint32_t>(slots.size());
    set.pBindings = slots.data();
    VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device->handle(), &set, nullptr, &set_layout),
          fmt::format("creating the layout of '{}'", name_));
    set_layout_ = {device, set_layout, [](const Device& d, VkDescriptorSetLayout l) {
                       vkDestroyDescriptorSetLayout(d.handle(), l, nullptr);
                   }};

    const VkPushConstantRange range{stages_, 0, push_bytes_};
    VkPipelineLayoutCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    info.setLayoutCount = 1;
    info.pSetLayouts = &set_layout;
    info.pushConstantRangeCount = push_bytes_ > 0 ? 1 : 0;
    info.pPushConstantRanges = &range;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device->handle(), &info, nullptr, &layout),
          fmt::format("creating the layout of '{}'", name_));
    layout_ = {device, layout,
               [](const Device& d, VkPipelineLayout l) { vkDestroyPipelineLayout(d.handle(), l, nullptr); }};
}

Pipeline::Pipeline(const std::shared_ptr<Device>& device, const ComputeDesc& desc)
    : name_(desc.name), bind_point_(VK_PIPELINE_BIND_POINT_COMPUTE)
{
    const Reflection reflection = reflect(desc.code);
    GNOMON_CHECK_EQ(static_cast<int>(reflection.stage), static_cast<int>(VK_SHADER_STAGE_COMPUTE_BIT));
    check_blocks(desc.blocks, {&desc.code, 1}, {&reflection, 1});
    std::copy(std::begin(reflection.local_size), std::end(reflection.local_size), local_size_);
    merge(reflection);
    make_layout(device);

    const auto module = make_module(device, desc.code);
    const Specialization constants(desc.constants);
    VkComputePipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    info.stage = stage_info(VK_SHADER_STAGE_COMPUTE_BIT, module.get(), constants);
    info.layout = layout_.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device->handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          fmt::format("creating pipeline '{}'", name_));
    pipeline_ = own(device, pipeline);
    device->name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(pipeline), name_);
}

Pipeline::Pipeline(const std::shared_ptr<Device>& device, const RayDesc& desc)
    : name_(desc.name), bind_point_(VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR)
{
    GNOMON_CHECK(device->traces_rays());
    std::vector<ShaderCode> codes{desc.generation, desc.miss};
    if (!desc.any_hit.words.empty()) codes.push_back(desc.any_hit);
    constexpr VkShaderStageFlagBits expected[] = {VK_SHADER_STAGE_RAYGEN_BIT_KHR, VK_SHADER_STAGE_MISS_BIT_KHR,
                                                  VK_SHADER_STAGE_ANY_HIT_BIT_KHR};
    std::vector<Reflection> reflections;
    for (std::size_t i = 0; i < codes.size(); ++i) {
        reflections.push_back(reflect(codes[i]));
        GNOMON_CHECK_EQ(static_cast<int>(reflections[i].stage), static_cast<int>(expected[i]));
        merge(reflections[i]);
    }
    check_blocks(desc.blocks, codes, reflections);
    make_layout(device);

    const Specialization constants(desc.constants);
    std::vector<Owned<VkShaderModule>> modules;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    for (std::size_t i = 0; i < codes.size(); ++i) {
        modules.push_back(make_module(device, codes[i]));
        stages.push_back(stage_info(reflections[i].stage, modules.back().get(), constants));
    }
    // Fill the groups: ray generation, miss, hit.
    VkRayTracingShaderGroupCreateInfoKHR groups[3]{};
    for (std::uint32_t g = 0; g < 3; ++g) {
        groups[g].sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR;
        groups[g].type = g < 2 ? VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR
                               : VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR;
        groups[g].generalShader = g < 2 ? g : VK_SHADER_UNUSED_KHR;
        groups[g].closestHitShader = groups[g].intersectionShader = VK_SHADER_UNUSED_KHR;
        groups[g].anyHitShader = g == 2 && codes.size() > 2 ? 2 : VK_SHADER_UNUSED_KHR;
    }
    VkRayTracingPipelineCreateInfoKHR info{};
    info.sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR;
    info.stageCount = static_cast<std::uint32_t>(stages.size());
    info.pStages = stages.data();
    info.groupCount = std::size(groups);
    info.pGroups = groups;
    info.maxPipelineRayRecursionDepth = 1;
    info.layout = layout_.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(
        vkCreateRayTracingPipelinesKHR(device->handle(), VK_NULL_HANDLE, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
        fmt::format("creating pipeline '{}'", name_));
    pipeline_ = own(device, pipeline);
    device->name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(pipeline), name_);
    make_table(device, std::size(groups));
}

// Makes the shader binding table: one record per group, each at the start of its own aligned part.
void Pipeline::make_table(const std::shared_ptr<Device>& device, std::uint32_t groups)
{
    const RayLimits& limits = device->ray_limits();
    const VkDeviceSize stride = round_up(limits.handle_bytes, limits.handle_alignment);
    const VkDeviceSize part = round_up(stride, limits.table_alignment);
    std::vector<std::byte> handles(std::size_t{groups} * limits.handle_bytes);
    check(vkGetRayTracingShaderGroupHandlesKHR(device->handle(), pipeline_.get(), 0, groups, handles.size(),
                                               handles.data()),
          fmt::format("querying the shader groups of '{}'", name_));
    // The memory's start may be unaligned; reserve space to align it.
    table_memory_ = Buffer(device, name_ + " (shader table)", groups * part + limits.table_alignment, Access::upload);
    const VkDeviceAddress memory = table_memory_.address(), first = round_up(memory, limits.table_alignment);
    VkStridedDeviceAddressRegionKHR* const parts[] = {&table_.generation, &table_.miss, &table_.hit};
    for (std::uint32_t g = 0; g < groups; ++g) {
        std::memcpy(table_memory_.mapped() + (first - memory) + g * part, handles.data() + g * limits.handle_bytes,
                    limits.handle_bytes);
        *parts[g] = {first + g * part, stride, stride};
    }
}

// LONG: one Vulkan structure after the other, all of which the call at the end reads.
Pipeline::Pipeline(const std::shared_ptr<Device>& device, const GraphicsDesc& desc)
    : name_(desc.name), color_targets_(desc.colors.size())
{
    // Reflect the stages, and make the layout.
    std::vector<ShaderCode> codes{desc.vertex};
    if (!desc.fragment.words.empty()) codes.push_back(desc.fragment);
    std::vector<Reflection> reflections;
    for (const ShaderCode& code : codes) {
        reflections.push_back(reflect(code));
        merge(reflections.back());
    }
    check_blocks(desc.blocks, codes, reflections);
    const std::size_t outputs = codes.size() > 1 ? reflections[1].color_outputs : 0;
    GNOMON_CHECK_EQ(outputs, desc.colors.size());
    make_layout(device);

    const Specialization constants(desc.constants);
    std::vector<Owned<VkShaderModule>> modules;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    for (std::size_t i = 0; i < codes.size(); ++i) {
        modules.push_back(make_module(device, codes[i]));
        stages.push_back(stage_info(reflections[i].stage, modules.back().get(), constants));
    }

    // Derive the vertex input from the vertex shader: one tightly packed buffer per location.
    std::vector<VkVertexInputBindingDescription> buffers;
    std::vector<VkVertexInputAttributeDescription> attributes;
    for (const VertexInput& input : reflections[0].inputs) {
        buffers.push_back({input.location, texel_bytes(input.format), VK_VERTEX_INPUT_RATE_VERTEX});
        attributes.push_back({input.location, input.location, input.format, 0});
    }
    vertex_buffers_ = static_cast<std::uint32_t>(buffers.size());
    VkPipelineVertexInputStateCreateInfo vertices{};
    vertices.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;
    vertices.vertexBindingDescriptionCount = vertex_buffers_;
    vertices.pVertexBindingDescriptions = buffers.data();
    vertices.vertexAttributeDescriptionCount = vertex_buffers_;
    vertices.pVertexAttributeDescriptions = attributes.data();

    // Fill in the fixed-function state.
    VkPipelineInputAssemblyStateCreateInfo assembly{};
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = desc.topology;

    VkPipelineViewportStateCreateInfo viewport{};
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = viewport.scissorCount = 1;

    VkPipelineRasterizationStateCreateInfo raster{};
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.depthClampEnable = desc.depth_clamp;
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1;

    VkPipelineMultisampleStateCreateInfo multisample{};
    multisample.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    multisample.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;

    VkPipelineDepthStencilStateCreateInfo depth{};
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = desc.depth != VK_FORMAT_UNDEFINED;
    depth.depthWriteEnable = desc.depth_write && depth.depthTestEnable;
    depth.depthCompareOp = desc.depth_compare;

    VkPipelineColorBlendAttachmentState overwrite{};
    overwrite.colorWriteMask =
        VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    const std::vector<VkPipelineColorBlendAttachmentState> targets(desc.colors.size(), overwrite);
    VkPipelineColorBlendStateCreateInfo blend{};
    blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
    blend.attachmentCount = static_cast<std::uint32_t>(targets.size());
    blend.pAttachments = targets.data();

    const VkDynamicState changing[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR, VK_DYNAMIC_STATE_CULL_MODE};
    VkPipelineDynamicStateCreateInfo dynamic{};
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = std::size(changing);
    dynamic.pDynamicStates = changing;

    // Use dynamic rendering.
    VkPipelineRenderingCreateInfo rendering{};
    rendering.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO;
    rendering.colorAttachmentCount = static_cast<std::uint32_t>(desc.colors.size());
    rendering.pColorAttachmentFormats = desc.colors.data();
    rendering.depthAttachmentFormat = desc.depth;

    VkGraphicsPipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
    info.pNext = &rendering;
    info.stageCount = static_cast<std::uint32_t>(stages.size());
    info.pStages = stages.data();
    info.pVertexInputState = &vertices;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewport;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &multisample;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blend;
    info.pDynamicState = &dynamic;
    info.layout = layout_.get();
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(device->handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          fmt::format("creating pipeline '{}'", name_));
    pipeline_ = own(device, pipeline);
    device->name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<std::uint64_t>(pipeline), name_);
}

}   // namespace gnomon::vk
