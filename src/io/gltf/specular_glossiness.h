// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts the specular-glossiness model [KHR_materials_pbrSpecularGlossiness] to metallic-roughness: metallic is
// solved so that a surface of that base colour has the given diffuse and specular brightness, as the Khronos converter
// does. What both models can express keeps its colours; a coloured highlight on a dielectric does not.

#include "base/image.h"
#include "base/math.h"

namespace gnomon::io::gltf {

/// Linear values.
struct MetallicRoughness {
    glm::vec3 base_color{1};
    float metallic = 0;
};

/// @param diffuse   diffuse reflectance, linear, 0 to 1
/// @param specular  reflectance at normal incidence, linear, 0 to 1
MetallicRoughness metallic_from_specular(const glm::vec3& diffuse, const glm::vec3& specular);

struct ConvertedImages {
    Image8 base_color;           // sRGB, with the alpha of the diffuse image
    Image8 metallic_roughness;   // roughness in G, metallic in B
};

/// Converts texel by texel, at the size of the larger image.
/// @param diffuse              sRGB, alpha optional; empty: white
/// @param specular_glossiness  specular sRGB, glossiness in alpha (1 without); empty: white
/// @param diffuse_factor, specular_factor, glossiness_factor  multiply the texels
ConvertedImages metallic_from_specular(const Image8& diffuse, const Image8& specular_glossiness,
                                       const glm::vec3& diffuse_factor, const glm::vec3& specular_factor,
                                       float glossiness_factor);

}   // namespace gnomon::io::gltf
