// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts the scene's materials, textures and lights to the form that shaders read.

#include "gpu_scene/gpu_scene_shared.h"
#include "scene/scene.h"

namespace gnomon::gpu_scene {

/// Of a material without layers: zeros.
shared::GpuLayers convert_layers(const scene::Material& material);
shared::GpuMaterial convert(const scene::Material& material);
shared::GpuLight convert(const scene::Light& light, const scene::LightState& state);

/// All levels of all textures as linear half floats, four per texel, concatenated.
struct TexelPool {
    std::vector<shared::GpuTexture> textures;
    std::vector<std::uint16_t> halves;
};
/// @throws MissingError  more texels than a 32-bit index can address
TexelPool convert(const scene::SharedList<scene::Texture>& textures);

}   // namespace gnomon::gpu_scene
