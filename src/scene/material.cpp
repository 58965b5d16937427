// SPDX-License-Identifier: Apache-2.0
#include "scene/material.h"

#include <array>

#include "base/bits.h"

namespace gnomon::scene {

namespace {

std::array<float, 22> numbers_of(const Material& m)
{
    return {m.base_color.x, m.base_color.y, m.base_color.z, m.alpha,        m.alpha_cutoff, m.metallic,
            m.roughness,    m.normal_scale, m.emissive.x,   m.emissive.y,   m.emissive.z,   m.occlusion_strength,
            m.ambient.x,    m.ambient.y,    m.ambient.z,    m.transmission, m.specular.x,   m.specular.y,
            m.specular.z,   m.shine,        m.ior,          m.transmittance};
}

std::array<TextureUse, 5> uses_of(const Material& m)
{
    return {m.base_color_texture, m.metallic_roughness_texture, m.normal_texture, m.occlusion_texture,
            m.emissive_texture};
}

}   // namespace

bool same_values(const Material& a, const Material& b)
{
    return a.model == b.model && a.double_sided == b.double_sided && a.alpha_mode == b.alpha_mode &&
           same_bits(numbers_of(a), numbers_of(b)) && same_bits(uses_of(a), uses_of(b));
}

bool same_to_rays(const Material& a, const Material& b)
{
    if (a.surface_class() != b.surface_class() || a.one_sided() != b.one_sided()) return false;
    if ((a.alpha_mode == AlphaMode::mask) != (b.alpha_mode == AlphaMode::mask)) return false;
    return a.alpha_mode != AlphaMode::mask ||
           (same_bits(a.alpha, b.alpha) && same_bits(a.alpha_cutoff, b.alpha_cutoff) &&
            same_bits(a.base_color_texture, b.base_color_texture));
}

}   // namespace gnomon::scene
