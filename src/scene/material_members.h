// SPDX-License-Identifier: Apache-2.0
#pragma once
// The numbers and colours of Material: one table for those who compare or blend them. Those of its layers are in
// material_layers.h.

#include "scene/material.h"

namespace gnomon::scene {

inline constexpr float Material::*k_material_numbers[] = {
    &Material::alpha,        &Material::alpha_cutoff,       &Material::metallic,     &Material::roughness,
    &Material::normal_scale, &Material::occlusion_strength, &Material::transmission, &Material::shine,
    &Material::ior,          &Material::transmittance};
inline constexpr glm::vec3 Material::*k_material_colors[] = {&Material::base_color, &Material::emissive,
                                                             &Material::ambient, &Material::specular};

}   // namespace gnomon::scene
