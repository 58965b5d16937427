// SPDX-License-Identifier: Apache-2.0
#pragma once
// Embedded SPIR-V, and its reflection by SPIRV-Cross: bindings, block layouts, inputs.
//
// Descriptor layouts are derived from reflection only. Knowledge that the host shares (sizes of structures, which
// binding holds which) is checked against it when a pipeline is created: see BlockExpectation.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "vk/api.h"

namespace gnomon::vk {

/// Embedded code: `#include "ROOM/NAME.STAGE.inc"` between braces gives its words.
struct ShaderCode {
    const char* name = "";   // "gpu_scene/cull.comp"
    std::span<const std::uint32_t> words;
};

struct BlockMember {
    std::string name;
    std::uint32_t offset = 0, size = 0;
};

/// A binding of set 0.
struct Binding {
    std::uint32_t binding = 0;
    std::string name;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_MAX_ENUM;
    std::uint32_t count = 1;
    bool writes = false;   // the shader may write it
    VkShaderStageFlags stages = 0;
    // For buffers: size of one element if the block is an unsized array, else of the block; and its members.
    std::uint32_t bytes = 0;
    std::vector<BlockMember> members;
};

struct VertexInput {
    std::uint32_t location = 0;
    VkFormat format = VK_FORMAT_UNDEFINED;
};

struct Reflection {
    VkShaderStageFlagBits stage{};
    std::vector<Binding> bindings;   // by number
    std::uint32_t push_bytes = 0;    // of the push constants; 0: none
    std::vector<BlockMember> push_members;
    std::uint32_t local_size[3]{1, 1, 1};   // of compute shaders
    std::vector<VertexInput> inputs;        // of vertex shaders, by location
    std::uint32_t color_outputs = 0;        // of fragment shaders
};

/// @throws InternalError  SPIRV-Cross cannot read the code, or it uses a set other than 0
Reflection reflect(const ShaderCode& code);

/// A structure that host and shader share: its size and the offsets of its members must agree.
struct BlockExpectation {
    std::string binding;   // the block's instance name in the shader; "" for the push constants
    std::size_t bytes = 0;
    std::vector<std::pair<std::string, std::size_t>> offsets;   // some or all members
};
/// @throws InternalError  with the name of what differs
void check_block(const Reflection& reflection, const ShaderCode& code, const BlockExpectation& expected);

}   // namespace gnomon::vk
