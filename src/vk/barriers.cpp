// SPDX-License-Identifier: Apache-2.0
#include "vk/barriers.h"

#include "base/check.h"

namespace gnomon::vk {

UseMeaning meaning(Use use, VkPipelineStageFlags2 shaders)
{
    constexpr VkPipelineStageFlags2 depth_stages =
        VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
    switch (use) {
        case Use::sampled:
            return {shaders, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, false};
        case Use::storage_read:
            return {shaders, VK_ACCESS_2_SHADER_STORAGE_READ_BIT, VK_IMAGE_LAYOUT_GENERAL, false};
        case Use::storage_write:
            return {shaders, VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                    VK_IMAGE_LAYOUT_GENERAL, true};
        case Use::uniform:
            return {shaders, VK_ACCESS_2_UNIFORM_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED, false};
        case Use::vertices:
            return {VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
                    VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_2_INDEX_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                    false};
        case Use::indirect:
            return {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
                    VK_IMAGE_LAYOUT_UNDEFINED, false};
        case Use::copy_source:
            return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                    VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, false};
        case Use::copy_target:
            return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, true};
        case Use::color_target:
            return {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                    VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                    VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, true};
        case Use::depth_target:
            return {depth_stages,
                    VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, true};
        case Use::depth_test:
            return {depth_stages, VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT,
                    VK_IMAGE_LAYOUT_DEPTH_READ_ONLY_OPTIMAL, false};
        case Use::build_input:
            return {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR, VK_ACCESS_2_SHADER_READ_BIT,
                    VK_IMAGE_LAYOUT_UNDEFINED, false};
        case Use::build_source:
            return {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                    VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, VK_IMAGE_LAYOUT_UNDEFINED, false};
        case Use::build_target:
            return {VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR,
                    VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR | VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR,
                    VK_IMAGE_LAYOUT_UNDEFINED, true};
        case Use::traced:
            return {shaders, VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, VK_IMAGE_LAYOUT_UNDEFINED, false};
        case Use::host_read:
            return {VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT, VK_IMAGE_LAYOUT_UNDEFINED, false};
    }
    fail_check(__FILE__, __LINE__, "unknown use of a resource");
}

std::optional<Wait> follow(UseState& state, const UseMeaning& use, bool image)
{
    const bool changes_layout = image && state.layout != use.layout;
    Wait wait{state.write_stages, use.stages, state.write_access, use.access, state.layout, use.layout};

    if (use.writes || changes_layout) {
        // Wait for the last write and for all reads since then.
        const bool used_before = state.write_stages || state.read_stages;
        wait.from_stages |= state.read_stages;
        state.write_stages = use.stages;
        state.write_access = use.writes ? use.access : 0;
        state.read_stages = use.writes ? 0 : use.stages;
        // A new write is not visible to anyone; a layout transition is visible to the stages for which it was made.
        state.seen_stages = use.writes ? 0 : use.stages;
        state.seen_access = use.writes ? 0 : use.access;
        if (image) state.layout = use.layout;
        if (!changes_layout && !used_before) return std::nullopt;
        return wait;
    }

    // Wait for the last write unless it is already visible to these stages.
    const bool seen = !(use.stages & ~state.seen_stages) && !(use.access & ~state.seen_access);
    state.read_stages |= use.stages;
    if (state.write_stages == 0 || seen) return std::nullopt;
    state.seen_stages |= use.stages;
    state.seen_access |= use.access;
    return wait;
}

}   // namespace gnomon::vk
