// SPDX-License-Identifier: Apache-2.0
#include "vk/shader.h"

#include <fmt/format.h>
#include <spirv_cross/spirv_cross_c.h>

#include <algorithm>
#include <memory>

#include "base/check.h"

namespace gnomon::vk {

namespace {

using Context = std::unique_ptr<spvc_context_s, void (*)(spvc_context)>;

// The SPIRV-Cross objects for reading one shader.
struct Reader {
    const char* name;
    Context context{nullptr, spvc_context_destroy};
    spvc_compiler compiler = nullptr;

    void check(spvc_result result) const
    {
        if (result == SPVC_SUCCESS) return;
        fail_check(
            __FILE__, __LINE__,
            fmt::format("{}: {}", name, context ? spvc_context_get_last_error_string(context.get()) : "out of memory"));
    }
    std::uint32_t decoration(spvc_variable_id id, SpvDecoration which) const
    {
        return spvc_compiler_get_decoration(compiler, id, which);
    }
    std::vector<BlockMember> members(spvc_type type, const std::string& outer = {}, std::uint32_t start = 0) const
    {
        std::vector<BlockMember> result;
        const spvc_type_id id = spvc_type_get_base_type_id(type);
        for (unsigned m = 0; m < spvc_type_get_num_member_types(type); ++m) {
            unsigned offset = 0;
            check(spvc_compiler_type_struct_member_offset(compiler, type, m, &offset));
            const std::string member_name = outer + spvc_compiler_get_member_name(compiler, id, m);
            const spvc_type member = spvc_compiler_get_type_handle(compiler, spvc_type_get_member_type(type, m));
            const bool is_array = spvc_type_get_num_array_dimensions(member) > 0;
            if (spvc_type_get_basetype(member) == SPVC_BASETYPE_STRUCT && !is_array) {
                const std::vector<BlockMember> inner =
                    members(spvc_compiler_get_type_handle(compiler, spvc_type_get_base_type_id(member)),
                            member_name + ".", start + offset);
                result.insert(result.end(), inner.begin(), inner.end());
                continue;
            }
            std::size_t size = 0;
            check(spvc_compiler_get_declared_struct_member_size(compiler, type, m, &size));
            unsigned stride = 0;
            if (is_array) check(spvc_compiler_type_struct_member_array_stride(compiler, type, m, &stride));
            result.push_back({member_name, start + offset, size, stride});
        }
        return result;
    }
    /// The members of a block; for a block that is one struct, the struct's members.
    std::vector<BlockMember> block_members(spvc_type type) const
    {
        if (spvc_type_get_num_member_types(type) != 1) return members(type);
        const spvc_type member = spvc_compiler_get_type_handle(compiler, spvc_type_get_member_type(type, 0));
        if (spvc_type_get_basetype(member) != SPVC_BASETYPE_STRUCT || spvc_type_get_num_array_dimensions(member) > 0)
            return members(type);
        return members(spvc_compiler_get_type_handle(compiler, spvc_type_get_base_type_id(member)));
    }
    std::uint32_t struct_bytes(spvc_type type) const
    {
        std::size_t size = 0;
        check(spvc_compiler_get_declared_struct_size(compiler, type, &size));
        return static_cast<std::uint32_t>(size);
    }
    std::span<const spvc_reflected_resource> list(spvc_resources all, spvc_resource_type type) const
    {
        const spvc_reflected_resource* resources = nullptr;
        std::size_t count = 0;
        check(spvc_resources_get_resource_list_for_type(all, type, &resources, &count));
        return {resources, count};
    }
};

// Describes a block; one that is an unsized array is described by its element.
void describe_block(const Reader& reader, const spvc_reflected_resource& resource, Binding& binding)
{
    const spvc_type type = spvc_compiler_get_type_handle(reader.compiler, resource.base_type_id);
    if (spvc_type_get_num_member_types(type) == 1) {
        const spvc_type member = spvc_compiler_get_type_handle(reader.compiler, spvc_type_get_member_type(type, 0));
        const bool unsized =
            spvc_type_get_num_array_dimensions(member) == 1 && spvc_type_get_array_dimension(member, 0) == 0;
        if (unsized) {
            unsigned stride = 0;
            reader.check(spvc_compiler_type_struct_member_array_stride(reader.compiler, type, 0, &stride));
            binding.bytes = stride;
            if (spvc_type_get_basetype(member) == SPVC_BASETYPE_STRUCT)
                binding.members =
                    reader.members(spvc_compiler_get_type_handle(reader.compiler, spvc_type_get_base_type_id(member)));
            return;
        }
    }
    binding.bytes = reader.struct_bytes(type);
    binding.members = reader.block_members(type);
}

VkFormat input_format(spvc_type type)
{
    const unsigned width = spvc_type_get_vector_size(type);
    const VkFormat floats[] = {VK_FORMAT_R32_SFLOAT, VK_FORMAT_R32G32_SFLOAT, VK_FORMAT_R32G32B32_SFLOAT,
                               VK_FORMAT_R32G32B32A32_SFLOAT};
    const VkFormat uints[] = {VK_FORMAT_R32_UINT, VK_FORMAT_R32G32_UINT, VK_FORMAT_R32G32B32_UINT,
                              VK_FORMAT_R32G32B32A32_UINT};
    GNOMON_CHECK(width >= 1 && width <= 4);
    return spvc_type_get_basetype(type) == SPVC_BASETYPE_FP32 ? floats[width - 1] : uints[width - 1];
}

VkShaderStageFlagBits stage_of(SpvExecutionModel model)
{
    switch (model) {
        case SpvExecutionModelVertex:
            return VK_SHADER_STAGE_VERTEX_BIT;
        case SpvExecutionModelFragment:
            return VK_SHADER_STAGE_FRAGMENT_BIT;
        case SpvExecutionModelRayGenerationKHR:
            return VK_SHADER_STAGE_RAYGEN_BIT_KHR;
        case SpvExecutionModelMissKHR:
            return VK_SHADER_STAGE_MISS_BIT_KHR;
        case SpvExecutionModelAnyHitKHR:
            return VK_SHADER_STAGE_ANY_HIT_BIT_KHR;
        default:
            GNOMON_CHECK(model == SpvExecutionModelGLCompute);
            return VK_SHADER_STAGE_COMPUTE_BIT;
    }
}

}   // namespace

Reflection reflect(const ShaderCode& code)
{
    Reader reader{code.name};
    spvc_context context = nullptr;
    reader.check(spvc_context_create(&context));
    reader.context.reset(context);
    spvc_parsed_ir ir = nullptr;
    reader.check(spvc_context_parse_spirv(context, code.words.data(), code.words.size(), &ir));
    reader.check(spvc_context_create_compiler(context, SPVC_BACKEND_NONE, ir, SPVC_CAPTURE_MODE_TAKE_OWNERSHIP,
                                              &reader.compiler));
    spvc_resources all = nullptr;
    reader.check(spvc_compiler_create_shader_resources(reader.compiler, &all));

    Reflection result;
    result.stage = stage_of(spvc_compiler_get_execution_model(reader.compiler));
    if (result.stage == VK_SHADER_STAGE_COMPUTE_BIT)
        for (unsigned i = 0; i < 3; ++i)
            result.local_size[i] =
                spvc_compiler_get_execution_mode_argument_by_index(reader.compiler, SpvExecutionModeLocalSize, i);

    const auto add = [&](const spvc_reflected_resource& resource) -> Binding& {
        if (reader.decoration(resource.id, SpvDecorationDescriptorSet) != 0)
            fail_check(__FILE__, __LINE__, fmt::format("{}: '{}' is not in set 0", code.name, resource.name));
        Binding& binding = result.bindings.emplace_back();
        binding.binding = reader.decoration(resource.id, SpvDecorationBinding);
        const char* instance = spvc_compiler_get_name(reader.compiler, resource.id);
        binding.name = instance && *instance ? instance : resource.name;
        binding.stages = result.stage;
        const spvc_type type = spvc_compiler_get_type_handle(reader.compiler, resource.type_id);
        for (unsigned d = 0; d < spvc_type_get_num_array_dimensions(type); ++d)
            binding.count *= spvc_type_get_array_dimension(type, d);
        return binding;
    };
    const auto is_texel_buffer = [&](const spvc_reflected_resource& resource) {
        const spvc_type type = spvc_compiler_get_type_handle(reader.compiler, resource.base_type_id);
        return spvc_type_get_image_dimension(type) == SpvDimBuffer;
    };

    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_UNIFORM_BUFFER)) {
        Binding& binding = add(r);
        binding.type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        describe_block(reader, r, binding);
    }
    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_STORAGE_BUFFER)) {
        Binding& binding = add(r);
        binding.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        describe_block(reader, r, binding);
        const SpvDecoration* decorations = nullptr;
        std::size_t count = 0;
        reader.check(spvc_compiler_get_buffer_block_decorations(reader.compiler, r.id, &decorations, &count));
        binding.writes = std::find(decorations, decorations + count, SpvDecorationNonWritable) == decorations + count;
    }
    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_STORAGE_IMAGE)) {
        Binding& binding = add(r);
        binding.type = VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        binding.writes = !spvc_compiler_has_decoration(reader.compiler, r.id, SpvDecorationNonWritable);
    }
    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_SAMPLED_IMAGE))
        add(r).type =
            is_texel_buffer(r) ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_SEPARATE_IMAGE))
        add(r).type = is_texel_buffer(r) ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_ACCELERATION_STRUCTURE))
        add(r).type = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
    for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_PUSH_CONSTANT)) {
        const spvc_type type = spvc_compiler_get_type_handle(reader.compiler, r.base_type_id);
        result.push_bytes = reader.struct_bytes(type);
        result.push_members = reader.block_members(type);
    }
    if (result.stage == VK_SHADER_STAGE_VERTEX_BIT)
        for (const auto& r : reader.list(all, SPVC_RESOURCE_TYPE_STAGE_INPUT))
            result.inputs.push_back({reader.decoration(r.id, SpvDecorationLocation),
                                     input_format(spvc_compiler_get_type_handle(reader.compiler, r.type_id))});
    if (result.stage == VK_SHADER_STAGE_FRAGMENT_BIT)
        result.color_outputs = static_cast<std::uint32_t>(reader.list(all, SPVC_RESOURCE_TYPE_STAGE_OUTPUT).size());
    const auto by_number = [](const Binding& a, const Binding& b) { return a.binding < b.binding; };
    std::sort(result.bindings.begin(), result.bindings.end(), by_number);
    std::sort(result.inputs.begin(), result.inputs.end(),
              [](const VertexInput& a, const VertexInput& b) { return a.location < b.location; });
    return result;
}

void check_block(const Reflection& reflection, const ShaderCode& code, const BlockExpectation& expected)
{
    const auto differs = [&](const std::string& what) {
        fail_check(__FILE__, __LINE__, fmt::format("{}: '{}': {}", code.name, expected.binding, what));
    };
    std::uint32_t bytes = reflection.push_bytes;
    const std::vector<BlockMember>* members = &reflection.push_members;
    if (!expected.binding.empty()) {
        const auto found = std::find_if(reflection.bindings.begin(), reflection.bindings.end(),
                                        [&](const Binding& b) { return b.name == expected.binding; });
        if (found == reflection.bindings.end()) differs("no such binding");
        bytes = found->bytes;
        members = &found->members;
    }
    if (bytes != expected.bytes) differs(fmt::format("{} bytes in the shader, {} on the host", bytes, expected.bytes));
    const auto find = [](const std::vector<SharedMember>& list, const std::string& name) {
        const auto at = std::find_if(list.begin(), list.end(), [&](const SharedMember& m) { return m.name == name; });
        return at == list.end() ? nullptr : &*at;
    };
    for (const SharedMember& host : expected.members) {
        const SharedMember* shader = find(*members, host.name);
        if (!shader) differs(fmt::format("no member '{}' in the shader", host.name));
        const auto same = [&](const char* what, std::size_t in_shader, std::size_t on_host) {
            if (in_shader != on_host)
                differs(fmt::format("the {} of '{}' is {} in the shader, {} on the host", what, host.name, in_shader,
                                    on_host));
        };
        same("offset", shader->offset, host.offset);
        same("size", shader->size, host.size);
        same("stride", shader->stride, host.stride);
    }
    for (const SharedMember& shader : *members)
        if (!find(expected.members, shader.name)) differs(fmt::format("no member '{}' on the host", shader.name));
}

void check_all_expected(const Reflection& reflection, const ShaderCode& code,
                        std::span<const BlockExpectation> expected)
{
    const auto is_expected = [&](const std::string& binding) {
        return std::any_of(expected.begin(), expected.end(), [&](const auto& e) { return e.binding == binding; });
    };
    if (reflection.push_bytes > 0 && !is_expected(""))
        fail_check(__FILE__, __LINE__, fmt::format("{}: the host expects no push constants", code.name));
    for (const Binding& binding : reflection.bindings)
        if (binding.bytes > 4 && !binding.members.empty() && !is_expected(binding.name))   // else: one number
            fail_check(__FILE__, __LINE__,
                       fmt::format("{}: the host expects no structures in '{}'", code.name, binding.name));
}

}   // namespace gnomon::vk
