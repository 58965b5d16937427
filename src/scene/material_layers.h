// SPDX-License-Identifier: Apache-2.0
#pragma once
// The optional part of a metallic-roughness material: layers above its surface, how its specular lobe differs, and what
// light meets inside; and the cone of its emission. Most materials have none, and cost nothing for it (Material::layers
// is null).
//
// The values and their meaning are those of glTF's extensions KHR_materials_specular, clearcoat, sheen, anisotropy,
// iridescence, transmission, volume and dispersion. Colours are linear.

#include <array>

#include "base/math.h"
#include "scene/texture.h"

namespace gnomon::scene {

struct MaterialLayers {
    // The dielectric's specular lobe: reflectance at normal incidence and at grazing angles.
    float specular = 1;            // scales both
    TextureUse specular_texture;   // in A
    glm::vec3 specular_color{1};   // scales the first; may exceed 1
    TextureUse specular_color_texture;

    // A dielectric coat of index 1.5 above everything else.
    float clearcoat = 0;
    TextureUse clearcoat_texture;   // in R
    float clearcoat_roughness = 0;
    TextureUse clearcoat_roughness_texture;   // in G
    TextureUse clearcoat_normal_texture;      // none: the coat is as smooth as the mesh, whatever the base's normal map
    float clearcoat_normal_scale = 1;

    // Fibres of cloth.
    glm::vec3 sheen_color{0};   // 0: none
    TextureUse sheen_color_texture;
    float sheen_roughness = 0;
    TextureUse sheen_roughness_texture;   // in A

    // Brushed surfaces: the lobe is wider along the grain.
    float anisotropy = 0;
    float anisotropy_rotation = 0;   // of the grain's direction, radians from the tangent
    TextureUse anisotropy_texture;   // direction in RG, strength in B

    // A thin film.
    float iridescence = 0;
    TextureUse iridescence_texture;   // in R
    float iridescence_ior = 1.3f;
    float iridescence_thickness_least = 100, iridescence_thickness_most = 400;   // nanometres
    TextureUse iridescence_thickness_texture;   // in G, from the first to the second; none: the second

    // Transmission, and what is inside.
    TextureUse transmission_texture;   // in R
    bool thin_walled = false;          // a sheet: light passes without refraction. Else the surface bounds a body
    float thickness = 0;               // of the body, metres: for renderers that do not trace refracted rays
    TextureUse thickness_texture;      // in G
    glm::vec3 attenuation_color{1};    // white light after the distance below
    float attenuation_distance = 0;    // metres; 0: nothing is absorbed
    float dispersion = 0;              // 20 divided by the Abbe number

    // The cone around the -Z of the object's space within which the surface emits, as a spot does: half-angles,
    // radians. From the inner to the outer one the light fades out (SpotProfile::smooth_cosine). Outer 0: there is no
    // cone.
    float emission_inner = 0, emission_outer = 0;

    /// Absorption per metre inside [KHR_materials_volume: Beer's law].
    glm::vec3 absorption() const;
};

/// The members of MaterialLayers by kind: one table for those who copy, compare or hash them.
inline constexpr float MaterialLayers::*k_layer_numbers[] = {&MaterialLayers::specular,
                                                             &MaterialLayers::clearcoat,
                                                             &MaterialLayers::clearcoat_roughness,
                                                             &MaterialLayers::clearcoat_normal_scale,
                                                             &MaterialLayers::sheen_roughness,
                                                             &MaterialLayers::anisotropy,
                                                             &MaterialLayers::anisotropy_rotation,
                                                             &MaterialLayers::iridescence,
                                                             &MaterialLayers::iridescence_ior,
                                                             &MaterialLayers::iridescence_thickness_least,
                                                             &MaterialLayers::iridescence_thickness_most,
                                                             &MaterialLayers::thickness,
                                                             &MaterialLayers::attenuation_distance,
                                                             &MaterialLayers::dispersion,
                                                             &MaterialLayers::emission_inner,
                                                             &MaterialLayers::emission_outer};
inline constexpr glm::vec3 MaterialLayers::*k_layer_colors[] = {
    &MaterialLayers::specular_color, &MaterialLayers::sheen_color, &MaterialLayers::attenuation_color};
inline constexpr TextureUse MaterialLayers::*k_layer_textures[] = {
    &MaterialLayers::specular_texture,         &MaterialLayers::specular_color_texture,
    &MaterialLayers::clearcoat_texture,        &MaterialLayers::clearcoat_roughness_texture,
    &MaterialLayers::clearcoat_normal_texture, &MaterialLayers::sheen_color_texture,
    &MaterialLayers::sheen_roughness_texture,  &MaterialLayers::anisotropy_texture,
    &MaterialLayers::iridescence_texture,      &MaterialLayers::iridescence_thickness_texture,
    &MaterialLayers::transmission_texture,     &MaterialLayers::thickness_texture};

/// Whether two blocks have the same values, bit for bit.
bool same_values(const MaterialLayers& a, const MaterialLayers& b);

}   // namespace gnomon::scene
