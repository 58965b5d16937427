// SPDX-License-Identifier: Apache-2.0
#include "scene/material.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/bits.h"
#include "scene/material_layers.h"
#include "scene/material_members.h"

namespace gnomon::scene {

namespace {

std::array<TextureUse, 5> uses_of(const Material& m)
{
    return {m.base_color_texture, m.metallic_roughness_texture, m.normal_texture, m.occlusion_texture,
            m.emissive_texture};
}

// Whether members of a table are the same, bit for bit.
template <class T, class Members>
bool same_members(const T& a, const T& b, const Members& members)
{
    return std::ranges::all_of(
        members, [&](const auto member) { return same_bits(std::array{a.*member}, std::array{b.*member}); });
}

}   // namespace

glm::vec3 MaterialLayers::absorption() const
{
    if (!(attenuation_distance > 0) || !std::isfinite(attenuation_distance)) return glm::vec3(0);
    constexpr float k_darkest = 1e-6f;   // of a colour: nothing absorbs infinitely
    return -glm::log(glm::clamp(attenuation_color, glm::vec3(k_darkest), glm::vec3(1))) / attenuation_distance;
}

bool same_values(const MaterialLayers& a, const MaterialLayers& b)
{
    const auto same = [&](const auto& members) { return same_members(a, b, members); };
    return a.thin_walled == b.thin_walled && same(k_layer_numbers) && same(k_layer_colors) && same(k_layer_textures);
}

bool thins_light(const Material& m)
{
    if (m.outline || m.model == ShadingModel::whitted) return false;
    if (m.alpha_mode == AlphaMode::blend) return true;
    return m.transmission > 0 && m.layers && (m.layers->thin_walled || m.layers->transmission_texture.used());
}

std::vector<const TextureUse*> texture_uses(const Material& m)
{
    std::vector<const TextureUse*> result{&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture,
                                          &m.occlusion_texture, &m.emissive_texture};
    if (m.layers)
        for (const auto member : k_layer_textures) result.push_back(&(*m.layers.*member));
    return result;
}

bool same_values(const Material& a, const Material& b)
{
    const auto same = [&](const auto& members) { return same_members(a, b, members); };
    if ((a.layers != nullptr) != (b.layers != nullptr) || a.outline != b.outline) return false;
    if (a.hidden_from_camera != b.hidden_from_camera) return false;
    if (a.layers && a.layers != b.layers && !same_values(*a.layers, *b.layers)) return false;
    return a.model == b.model && a.double_sided == b.double_sided && a.alpha_mode == b.alpha_mode &&
           same(k_material_numbers) && same(k_material_colors) && same_bits(uses_of(a), uses_of(b));
}

bool same_to_rays(const Material& a, const Material& b)
{
    if (a.surface_class() != b.surface_class() || a.one_sided() != b.one_sided()) return false;
    if (thins_light(a) != thins_light(b)) return false;
    if ((a.alpha_mode == AlphaMode::mask) != (b.alpha_mode == AlphaMode::mask)) return false;
    return a.alpha_mode != AlphaMode::mask ||
           (same_bits(a.alpha, b.alpha) && same_bits(a.alpha_cutoff, b.alpha_cutoff) &&
            same_bits(a.base_color_texture, b.base_color_texture));
}

}   // namespace gnomon::scene
