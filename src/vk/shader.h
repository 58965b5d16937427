// SPDX-License-Identifier: Apache-2.0
#pragma once
// SPIR-V as the build embedded it, and what it says of itself (by SPIRV-Cross): bindings, block layouts, inputs.
//
// Descriptor layouts are made from this and from nothing else. What the host knows too (the bytes of shared structures,
// which binding holds which) is checked against it when a pipeline is made: see BlockExpectation. A pipeline is refused
// where a block of structures has no expectation.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "vk/api.h"
#include "vk/shared_members.h"

namespace gnomon::vk {

/// Code the build made: `#include "ROOM/NAME.STAGE.inc"` between braces gives the words.
struct ShaderCode {
    const char* name = "";   // "gpu_scene/cull.comp"
    std::span<const std::uint32_t> words;
};

/// A member of a block; those of a structure within it as "outer.inner".
using BlockMember = SharedMember;

/// One binding of set 0.
struct Binding {
    std::uint32_t binding = 0;
    std::string name;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_MAX_ENUM;
    std::uint32_t count = 1;
    bool writes = false;   // the shader may write it
    VkShaderStageFlags stages = 0;
    // Buffers: the bytes of one element if the block is one unsized array, else of the block; and its members.
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

/// @throws InternalError  for code that SPIRV-Cross cannot read, or that uses another set than 0
Reflection reflect(const ShaderCode& code);

/// A structure the host shares with a shader. Its bytes and all of its members must be the shader's: names, offsets,
/// sizes and strides of arrays; neither side may have a member that the other lacks.
struct BlockExpectation {
    std::string binding;   // the block's instance name in the shader; "" for the push constants
    std::size_t bytes = 0;
    std::vector<SharedMember> members;
};

/// Of a structure with GNOMON_MEMBERS: a block of one, or of any number.
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

/// The lists of several rooms as one.
template <class... Lists>
std::vector<BlockExpectation> all_blocks(BlockExpectation first, const Lists&... lists)
{
    std::vector<BlockExpectation> all{std::move(first)};
    (all.insert(all.end(), lists.begin(), lists.end()), ...);
    return all;
}

/// @throws InternalError  naming what differs
void check_block(const Reflection& reflection, const ShaderCode& code, const BlockExpectation& expected);
/// Every block of structures, and the push constants, must be among `expected`.
/// @throws InternalError  naming one that is not
void check_all_expected(const Reflection& reflection, const ShaderCode& code,
                        std::span<const BlockExpectation> expected);

}   // namespace gnomon::vk
