// SPDX-License-Identifier: Apache-2.0
#pragma once
// The blocks of the scene that shaders declare, for pipelines to check (vk::BlockExpectation).

#include "gpu_scene/gpu_scene_shared.h"
#include "vk/shader.h"

namespace gnomon::gpu_scene {

/// Of shaders that draw objects.
inline std::vector<vk::BlockExpectation> draw_blocks()
{
    return {vk::shared_block<shared::GpuObject>("objects"), vk::shared_block<shared::GpuDraw>("draws")};
}

/// Of shaders that include scene_data.glsl.
inline std::vector<vk::BlockExpectation> scene_data_blocks()
{
    return {vk::shared_block<shared::GpuObject>("objects"), vk::shared_block<shared::GpuDraw>("draws"),
            vk::shared_block<shared::GpuMaterial>("materials"), vk::shared_block<shared::GpuTexture>("textures")};
}

}   // namespace gnomon::gpu_scene
