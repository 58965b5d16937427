// SPDX-License-Identifier: Apache-2.0
#pragma once
// Embedded SPIR-V, and its reflection by SPIRV-Cross: bindings, block layouts, inputs.
//
// Descriptor layouts are derived from reflection only. Knowledge that the host shares (sizes of structures, which
// binding holds which) is checked against it when a pipeline is created: see BlockExpectation. A pipeline is rejected
// if a block of structures has no expectation.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "vk/api.h"
#include "vk/shared_members.h"

namespace gnomon::vk {

/// Embedded code: `#include "ROOM/NAME.STAGE.inc"` between braces gives its words.
struct ShaderCode {
    const char* name = "";   // "gpu_scene/cull.comp"
    std::span<const std::uint32_t> words;
};

/// A member of a block; members of a structure within it are named "outer.inner".
using BlockMember = SharedMember;

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

/// A structure that host and shader share. Its size and all of its members must agree: names, offsets, sizes and array
/// strides; neither side may have a member that the other lacks.
struct BlockExpectation {
    std::string binding;   // the block's instance name in the shader; "" for the push constants
    std::size_t bytes = 0;
    std::vector<SharedMember> members;
};

/// The expectation of a structure with GNOMON_MEMBERS: a block of one, or an array of any length.
template <class Struct>
BlockExpectation shared_block(std::string binding)
{
    return {std::move(binding), sizeof(Struct), shared_members(static_cast<const Struct*>(nullptr))};
}
template <class Struct>
BlockExpectation shared_push()
{
    return shared_block<Struct>("");
}

/// Concatenates the lists of several rooms.
template <class... Lists>
std::vector<BlockExpectation> all_blocks(BlockExpectation first, const Lists&... lists)
{
    std::vector<BlockExpectation> all{std::move(first)};
    (all.insert(all.end(), lists.begin(), lists.end()), ...);
    return all;
}

/// @throws InternalError  with the name of what differs
void check_block(const Reflection& reflection, const ShaderCode& code, const BlockExpectation& expected);
/// Every block of structures, and the push constants, must be among `expected`.
/// @throws InternalError  with the name of one that is not
void check_all_expected(const Reflection& reflection, const ShaderCode& code,
                        std::span<const BlockExpectation> expected);

}   // namespace gnomon::vk
