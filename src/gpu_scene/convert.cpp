// SPDX-License-Identifier: Apache-2.0
#include "gpu_scene/convert.h"

#include <algorithm>
#include <array>
#include <glm/gtc/packing.hpp>
#include <limits>

#include "base/check.h"
#include "gnomon/error.h"
#include "scene/emission_cone.h"
#include "scene/material_layers.h"

namespace gnomon::gpu_scene {

namespace {

using shared::GpuTextureUse;

GpuTextureUse convert_use(const scene::TextureUse& use)
{
    return {
        use.texture,           static_cast<std::uint32_t>(use.texcoord), use.offset, use.scale, std::cos(use.rotation),
        std::sin(use.rotation)};
}

// Half floats of the 256 values of 8 bits.
std::array<std::uint16_t, 256> halves_of(bool srgb)
{
    std::array<std::uint16_t, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
        table[i] = glm::packHalf1x16(srgb ? linear_from_srgb8()[i] : static_cast<float>(i) / 255.0f);
    return table;
}

}   // namespace

shared::GpuMaterial convert(const scene::Material& m)
{
    shared::GpuMaterial g{};
    g.base_color = m.base_color;
    g.alpha = m.alpha;
    g.emissive = m.emissive;
    g.alpha_cutoff = m.alpha_cutoff;
    g.ambient = m.ambient;
    g.metallic = m.metallic;
    g.specular = m.specular;
    g.roughness = m.roughness;
    g.shine = m.shine;
    g.transmittance = m.transmittance;
    g.transmission = m.transmission;
    g.ior = m.ior;
    g.normal_scale = m.normal_scale;
    g.occlusion_strength = m.occlusion_strength;
    g.model = m.catches_shadows ? GNOMON_MODEL_CATCHER : static_cast<std::uint32_t>(m.model);
    g.alpha_mode = static_cast<std::uint32_t>(m.alpha_mode);
    g.layered = m.layers ? 1 : 0;
    g.base_color_texture = convert_use(m.base_color_texture);
    g.metallic_roughness_texture = convert_use(m.metallic_roughness_texture);
    g.normal_texture = convert_use(m.normal_texture);
    g.occlusion_texture = convert_use(m.occlusion_texture);
    g.emissive_texture = convert_use(m.emissive_texture);
    return g;
}

shared::GpuLayers convert_layers(const scene::Material& material)
{
    shared::GpuLayers g{};
    if (!material.layers) return g;
    const scene::MaterialLayers& m = *material.layers;
    g.specular_color = m.specular_color;
    g.specular = m.specular;
    g.sheen_color = m.sheen_color;
    g.sheen_roughness = m.sheen_roughness;
    g.absorption = m.absorption();
    g.thickness = m.thickness;
    g.clearcoat = m.clearcoat;
    g.clearcoat_roughness = m.clearcoat_roughness;
    g.iridescence = m.iridescence;
    g.iridescence_ior = m.iridescence_ior;
    g.iridescence_thickness_least = m.iridescence_thickness_least;
    g.iridescence_thickness_most = m.iridescence_thickness_most;
    g.thin_walled = m.thin_walled ? 1 : 0;
    const scene::EmissionCone cone = scene::emission_cone(material, {0, 0, -1});
    g.emission_outer = cone.limits() ? cone.cosines.outer : GNOMON_NO_CONE;
    g.emission_inner = cone.cosines.inner;
    g.specular_texture = convert_use(m.specular_texture);
    g.specular_color_texture = convert_use(m.specular_color_texture);
    g.clearcoat_texture = convert_use(m.clearcoat_texture);
    g.clearcoat_roughness_texture = convert_use(m.clearcoat_roughness_texture);
    g.sheen_color_texture = convert_use(m.sheen_color_texture);
    g.sheen_roughness_texture = convert_use(m.sheen_roughness_texture);
    g.iridescence_texture = convert_use(m.iridescence_texture);
    g.iridescence_thickness_texture = convert_use(m.iridescence_thickness_texture);
    g.transmission_texture = convert_use(m.transmission_texture);
    g.thickness_texture = convert_use(m.thickness_texture);
    return g;
}

shared::GpuLight convert(const scene::Light& light, const scene::LightState& state)
{
    shared::GpuLight g{};
    g.color = light.color;
    g.type = static_cast<std::uint32_t>(light.type);
    g.position = state.position;
    g.range = light.range;
    g.direction = state.direction;
    g.shown = state.visible ? 1 : 0;
    g.cos_outer = std::cos(light.outer_angle);
    g.cos_inner = std::cos(std::min(light.inner_angle, light.outer_angle));
    g.constant_falloff = light.falloff == scene::Falloff::constant ? 1 : 0;
    g.profile = static_cast<std::uint32_t>(light.profile);
    g.of_environment = light.of_environment ? 1 : 0;
    return g;
}

TexelPool convert(const scene::SharedList<scene::Texture>& textures)
{
    static_assert(static_cast<int>(scene::Wrap::repeat) == 0 && static_cast<int>(scene::Wrap::mirror) == 1);
    static_assert(static_cast<int>(scene::Filter::nearest) == 0);
    static const std::array<std::uint16_t, 256> plain = halves_of(false), linear = halves_of(true);
    TexelPool pool;
    // Count the texels.
    std::uint64_t total = 0;
    for (const scene::Texture& texture : textures)
        for (const Image8& level : texture.levels()) total += static_cast<std::uint64_t>(level.width) * level.height;
    if (total > std::numeric_limits<std::int32_t>::max())
        throw MissingError("Vulkan: the scene's textures have more texels than can be addressed");
    pool.halves.reserve(4 * total);
    // Convert all levels of all textures to half floats.
    for (const scene::Texture& texture : textures) {
        shared::GpuTexture& g = pool.textures.emplace_back();
        g.width = static_cast<std::uint32_t>(texture.width());
        g.height = static_cast<std::uint32_t>(texture.height());
        g.levels = static_cast<std::uint32_t>(texture.levels().size());
        GNOMON_CHECK(g.levels <= GNOMON_MAX_LEVELS);
        const scene::Sampler& sampler = texture.sampler();
        g.wrap_u = static_cast<std::uint32_t>(sampler.wrap_u);
        g.wrap_v = static_cast<std::uint32_t>(sampler.wrap_v);
        g.magnify = static_cast<std::uint32_t>(sampler.magnify);
        g.minify = static_cast<std::uint32_t>(sampler.minify);
        const auto& color = texture.srgb() ? linear : plain;
        for (std::size_t l = 0; l < texture.levels().size(); ++l) {
            const Image8& level = texture.levels()[l];
            GNOMON_CHECK(static_cast<std::uint32_t>(level.width) == std::max(g.width >> l, 1u));
            g.first[l] = static_cast<std::uint32_t>(pool.halves.size() / 4);
            for (std::size_t i = 0; i < level.data.size(); i += 4) {
                for (std::size_t c = 0; c < 3; ++c) pool.halves.push_back(color[level.data[i + c]]);
                pool.halves.push_back(plain[level.data[i + 3]]);
            }
        }
    }
    return pool;
}

}   // namespace gnomon::gpu_scene
