// SPDX-License-Identifier: Apache-2.0
#include "api/convert.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/one_line.h"
#include "gnomon/error.h"
#include "gnomon/ranges.h"
#include "scene/material_layers.h"

namespace gnomon::api {

namespace {

// Rejects a value that is not within a range; NaN is in none.
void require_range(double value, double low, double high, std::string_view owner, std::string_view what)
{
    if (!(value >= low && value <= high))
        throw UsageError(fmt::format("{}: {} is {}: expected {} to {}", owner, what, value, low, high));
}

void require_finite(double value, std::string_view owner, std::string_view what)
{
    if (!std::isfinite(value)) throw UsageError(fmt::format("{}: {} is not finite", owner, what));
}

void require_color(const Vec3& c, std::string_view owner, std::string_view what)
{
    for (const float value : {c.x, c.y, c.z})
        if (!(value >= 0) || !std::isfinite(value))
            throw UsageError(fmt::format("{}: {} ({} {} {}) is negative or not finite", owner, what, c.x, c.y, c.z));
}

scene::TextureUse to_scene(const TextureUse& use, const SceneStamps& stamps, std::string_view owner)
{
    scene::TextureUse result;
    if (use.texture) result.texture = require(stamps.textures, use.texture, fmt::format("{}: the texture", owner));
    require_range(use.texcoord, 0, 1, owner, "the index of texture coordinates");
    for (const float value : {use.offset.x, use.offset.y, use.scale.x, use.scale.y, use.rotation})
        require_finite(value, owner, "a texture transform");
    result.texcoord = use.texcoord;
    result.offset = {use.offset.x, use.offset.y};
    result.scale = {use.scale.x, use.scale.y};
    result.rotation = use.rotation;
    return result;
}

TextureUse from_scene(const scene::TextureUse& use, const SceneStamps& stamps)
{
    TextureUse result;
    if (use.used()) result.texture = stamps.textures.id<TextureId>(use.texture);
    result.texcoord = use.texcoord;
    result.offset = {use.offset.x, use.offset.y};
    result.scale = {use.scale.x, use.scale.y};
    result.rotation = use.rotation;
    return result;
}

// The textures of a material, on both sides.
struct TexturePair {
    TextureUse Material::*outer;
    scene::TextureUse scene::Material::*inner;
};
constexpr TexturePair k_textures[] = {
    {&Material::base_color_texture, &scene::Material::base_color_texture},
    {&Material::metallic_roughness_texture, &scene::Material::metallic_roughness_texture},
    {&Material::normal_texture, &scene::Material::normal_texture},
    {&Material::occlusion_texture, &scene::Material::occlusion_texture},
    {&Material::emissive_texture, &scene::Material::emissive_texture}};

struct LayerTexturePair {
    TextureUse MaterialLayers::*outer;
    scene::TextureUse scene::MaterialLayers::*inner;
};
constexpr LayerTexturePair k_layer_textures[] = {
    {&MaterialLayers::specular_texture, &scene::MaterialLayers::specular_texture},
    {&MaterialLayers::specular_color_texture, &scene::MaterialLayers::specular_color_texture},
    {&MaterialLayers::clearcoat_texture, &scene::MaterialLayers::clearcoat_texture},
    {&MaterialLayers::clearcoat_roughness_texture, &scene::MaterialLayers::clearcoat_roughness_texture},
    {&MaterialLayers::clearcoat_normal_texture, &scene::MaterialLayers::clearcoat_normal_texture},
    {&MaterialLayers::sheen_color_texture, &scene::MaterialLayers::sheen_color_texture},
    {&MaterialLayers::sheen_roughness_texture, &scene::MaterialLayers::sheen_roughness_texture},
    {&MaterialLayers::anisotropy_texture, &scene::MaterialLayers::anisotropy_texture},
    {&MaterialLayers::iridescence_texture, &scene::MaterialLayers::iridescence_texture},
    {&MaterialLayers::iridescence_thickness_texture, &scene::MaterialLayers::iridescence_thickness_texture},
    {&MaterialLayers::transmission_texture, &scene::MaterialLayers::transmission_texture},
    {&MaterialLayers::thickness_texture, &scene::MaterialLayers::thickness_texture}};
static_assert(std::size(k_layer_textures) == std::size(scene::k_layer_textures));

template <class From, class To>
void copy_layer_values(const From& from, To& to)
{
    to.specular = from.specular;
    to.specular_color = vec(from.specular_color);
    to.clearcoat = from.clearcoat;
    to.clearcoat_roughness = from.clearcoat_roughness;
    to.clearcoat_normal_scale = from.clearcoat_normal_scale;
    to.sheen_color = vec(from.sheen_color);
    to.sheen_roughness = from.sheen_roughness;
    to.anisotropy = from.anisotropy;
    to.anisotropy_rotation = from.anisotropy_rotation;
    to.iridescence = from.iridescence;
    to.iridescence_ior = from.iridescence_ior;
    to.iridescence_thickness_least = from.iridescence_thickness_least;
    to.iridescence_thickness_most = from.iridescence_thickness_most;
    to.thin_walled = from.thin_walled;
    to.thickness = from.thickness;
    to.attenuation_color = vec(from.attenuation_color);
    to.attenuation_distance = from.attenuation_distance;
    to.dispersion = from.dispersion;
    to.emission_inner = from.emission_inner;
    to.emission_outer = from.emission_outer;
}

// Copies what both sides' materials call by the same name, and mean by it.
template <class From, class To>
void copy_values(const From& from, To& to)
{
    to.name = from.name;
    to.base_color = vec(from.base_color);
    to.emissive = vec(from.emissive);
    to.ambient = vec(from.ambient);
    to.specular = vec(from.specular);
    to.double_sided = from.double_sided;
    to.alpha = from.alpha;
    to.alpha_cutoff = from.alpha_cutoff;
    to.metallic = from.metallic;
    to.roughness = from.roughness;
    to.normal_scale = from.normal_scale;
    to.occlusion_strength = from.occlusion_strength;
    to.transmission = from.transmission;
    to.ior = from.ior;
    to.shine = from.shine;
    to.transmittance = from.transmittance;
    to.outline = from.outline;
    to.hidden_from_camera = from.hidden_from_camera;
}

constexpr double k_any = 1e9;   // upper limit of numbers that have none by their meaning

std::shared_ptr<const scene::MaterialLayers> layers_to_scene(const MaterialLayers& m, const SceneStamps& stamps,
                                                             const std::string& owner)
{
    require_color(m.specular_color, owner, "the specular colour of the layers");
    require_color(m.sheen_color, owner, "the sheen colour");
    require_color(m.attenuation_color, owner, "the attenuation colour");
    for (const float value : {m.sheen_color.x, m.sheen_color.y, m.sheen_color.z})
        require_range(value, 0, 1, owner, "the sheen colour");
    require_range(m.specular, 0, 1, owner, "specular");
    require_range(m.clearcoat, 0, 1, owner, "clearcoat");
    require_range(m.clearcoat_roughness, 0, 1, owner, "the roughness of the clearcoat");
    require_range(m.clearcoat_normal_scale, -k_any, k_any, owner, "the scale of the clearcoat's normals");
    require_range(m.sheen_roughness, 0, 1, owner, "the roughness of the sheen");
    require_range(m.anisotropy, 0, 1, owner, "anisotropy");
    require_range(m.anisotropy_rotation, -k_any, k_any, owner, "the rotation of anisotropy");
    require_range(m.iridescence, 0, 1, owner, "iridescence");
    require_range(m.iridescence_ior, 1, k_any, owner, "the thin film's index of refraction");
    require_range(m.iridescence_thickness_least, 0, k_any, owner, "the thin film's thickness");
    require_range(m.iridescence_thickness_most, 0, k_any, owner, "the thin film's thickness");
    require_range(m.thickness, 0, k_any, owner, "the thickness");
    require_range(m.attenuation_distance, 0, std::numeric_limits<float>::max(), owner, "the attenuation distance");
    require_range(m.dispersion, 0, k_any, owner, "dispersion");
    require_range(m.emission_inner, 0, k_pi / 2, owner, "the inner angle of the emission");
    require_range(m.emission_outer, 0, k_pi / 2 + 1e-6, owner, "the outer angle of the emission");
    if (m.emission_outer > 0)
        require_range(m.emission_outer, m.emission_inner, k_pi / 2 + 1e-6, owner, "the outer angle of the emission");
    scene::MaterialLayers result;
    copy_layer_values(m, result);
    for (const auto& [outer, inner] : k_layer_textures) result.*inner = to_scene(m.*outer, stamps, owner);
    return std::make_shared<const scene::MaterialLayers>(result);
}

}   // namespace

std::string titled(std::string_view kind, const std::string& name)
{
    return name.empty() ? std::string(kind) : fmt::format("{} '{}'", kind, shown_name(name));
}

void refuse_value(int value, std::string_view owner, std::string_view what)
{
    throw UsageError(fmt::format("{}: {} is {}, which its type does not have", owner, what, value));
}

void refuse_id(std::string_view what, bool given)
{
    throw UsageError(given ? fmt::format("{} is not in this scene: it was removed, or belongs to another one", what)
                           : fmt::format("{} is missing: its id refers to nothing", what));
}

glm::dmat4 matrix_of(const Transform& transform, std::string_view what)
{
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = transform.m[static_cast<std::size_t>(i)];
    for (const double value : transform.m)
        if (!std::isfinite(value)) throw UsageError(fmt::format("{}: the transform is not finite", what));
    if (matrix[0][3] != 0 || matrix[1][3] != 0 || matrix[2][3] != 0 || matrix[3][3] != 1)
        throw UsageError(fmt::format("{}: the transform is not affine: its last row is not 0 0 0 1", what));
    return matrix;
}

Transform transform_of(const glm::dmat4& matrix)
{
    Transform result;
    for (int i = 0; i < 16; ++i) result.m[static_cast<std::size_t>(i)] = matrix[i / 4][i % 4];
    return result;
}

scene::Material to_scene(const Material& m, const SceneStamps& stamps)
{
    const std::string owner = titled("material", m.name);
    require_known(m.model, ShadingModel::unlit, owner, "the shading model");
    require_known(m.alpha_mode, AlphaMode::blend, owner, "the alpha mode");
    require_color(m.base_color, owner, "the base colour");
    require_color(m.emissive, owner, "the emission");
    require_color(m.ambient, owner, "the ambient colour");
    require_color(m.specular, owner, "the specular colour");
    require_range(m.alpha, 0, 1, owner, "alpha");
    require_range(m.alpha_cutoff, 0, k_any, owner, "the alpha cutoff");
    require_range(m.metallic, 0, 1, owner, "metallic");
    require_range(m.roughness, 0, 1, owner, "roughness");
    require_range(m.transmission, 0, 1, owner, "transmission");
    require_range(m.transmittance, 0, 1, owner, "transmittance");
    require_range(m.ior, 1, k_any, owner, "the index of refraction");
    require_range(m.shine, 0, k_any, owner, "shine");
    require_range(m.occlusion_strength, 0, 1, owner, "the strength of occlusion");
    require_range(m.normal_scale, -k_any, k_any, owner, "the scale of normals");

    scene::Material result;
    copy_values(m, result);
    result.model = static_cast<scene::ShadingModel>(m.model);
    result.alpha_mode = static_cast<scene::AlphaMode>(m.alpha_mode);
    for (const auto& [outer, inner] : k_textures) result.*inner = to_scene(m.*outer, stamps, owner);
    if (m.layers) result.layers = layers_to_scene(*m.layers, stamps, owner);
    return result;
}

Material from_scene(const scene::Material& m, const SceneStamps& stamps)
{
    Material result;
    copy_values(m, result);
    result.model = static_cast<ShadingModel>(m.model);
    result.alpha_mode = static_cast<AlphaMode>(m.alpha_mode);
    for (const auto& [outer, inner] : k_textures) result.*outer = from_scene(m.*inner, stamps);
    if (m.layers) {
        MaterialLayers& layers = result.layers.emplace();
        copy_layer_values(*m.layers, layers);
        for (const auto& [outer, inner] : k_layer_textures) layers.*outer = from_scene(*m.layers.*inner, stamps);
    }
    return result;
}

scene::Light to_scene(const Light& light)
{
    const std::string owner = titled("light", light.name);
    require_known(light.type, LightType::directional, owner, "the type");
    require_known(light.falloff, Falloff::constant, owner, "the falloff");
    require_known(light.profile, SpotProfile::smooth_cosine, owner, "the profile");
    require_color(light.color, owner, "the colour");
    require_range(light.inner_angle, 0, k_pi / 2, owner, "the inner angle");
    require_range(light.outer_angle, light.inner_angle, k_pi / 2 + 1e-6, owner, "the outer angle");
    require_range(light.range, 0, std::numeric_limits<float>::max(), owner, "the range");
    scene::Light result;
    result.name = light.name;
    result.type = static_cast<scene::LightType>(light.type);
    result.color = vec(light.color);
    result.falloff = static_cast<scene::Falloff>(light.falloff);
    result.profile = static_cast<scene::SpotProfile>(light.profile);
    result.inner_angle = light.inner_angle;
    result.outer_angle = light.outer_angle;
    result.range = light.range;
    return result;
}

Light from_scene(const scene::Light& light)
{
    Light result;
    result.name = light.name;
    result.type = static_cast<LightType>(light.type);
    result.color = vec(light.color);
    result.falloff = static_cast<Falloff>(light.falloff);
    result.profile = static_cast<SpotProfile>(light.profile);
    result.inner_angle = light.inner_angle;
    result.outer_angle = light.outer_angle;
    result.range = light.range;
    return result;
}

scene::Camera to_scene(const Camera& camera)
{
    const std::string owner = titled("camera", camera.name);
    require_range(camera.near, 0, k_any, owner, "the near distance");
    require_finite(camera.far, owner, "the far distance");
    const auto [width, height] = camera.resolution;
    const bool fits = ranges::image_side.contains(width) && ranges::image_side.contains(height) &&
                      std::int64_t{width} * height <= ranges::k_max_pixels;
    if (!fits && !(width == 0 && height == 0))
        throw UsageError(fmt::format("{}: the resolution {} x {} is out of range", owner, width, height));
    if (camera.far != 0 && !(camera.far > camera.near))
        throw UsageError(
            fmt::format("{}: far is {}: expected more than near, {}, or 0", owner, camera.far, camera.near));
    require_finite(camera.shift_x, owner, "the shift");
    require_finite(camera.shift_y, owner, "the shift");
    if (!(camera.vertical_fov > 0 && camera.vertical_fov < k_pi))
        throw UsageError(
            fmt::format("{}: the field of view is {}: expected above 0 and below pi", owner, camera.vertical_fov));
    if (camera.orthographic_height && !(*camera.orthographic_height > 0 && *camera.orthographic_height <= k_any))
        throw UsageError(
            fmt::format("{}: the orthographic height is {}: expected above 0", owner, *camera.orthographic_height));
    scene::Camera result;
    result.name = camera.name;
    result.vertical_fov = camera.vertical_fov;
    result.orthographic_height = camera.orthographic_height.value_or(0);
    result.near = camera.near;
    result.far = camera.far;
    result.resolution = camera.resolution;
    result.shift = {camera.shift_x, camera.shift_y};
    if (camera.intrinsics) {
        const Intrinsics& in = *camera.intrinsics;
        if (!(in.fx > 0 && in.fx <= k_any && in.fy > 0 && in.fy <= k_any))
            throw UsageError(
                fmt::format("{}: the focal lengths are {} and {} pixels: expected above 0", owner, in.fx, in.fy));
        require_finite(in.cx, owner, "the principal point");
        require_finite(in.cy, owner, "the principal point");
        if (in.size.width < 0 || in.size.height < 0 || (in.size.width == 0) != (in.size.height == 0))
            throw UsageError(fmt::format("{}: the intrinsics' size is {} x {}", owner, in.size.width, in.size.height));
        result.intrinsics = in;
    }
    if (camera.matrix) {
        for (const double value : camera.matrix->m) require_finite(value, owner, "the projection matrix");
        glm::dmat4 matrix;
        for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = camera.matrix->m[static_cast<std::size_t>(i)];
        result.projection = matrix;
        if (!scene::is_projection(matrix))
            throw UsageError(fmt::format(
                "{}: the projection matrix is skewed, sees nothing in front of the camera, or is neither a perspective "
                "nor orthographic",
                owner));
    }
    return result;
}

Camera from_scene(const scene::Camera& camera, const glm::dmat4& transform)
{
    Camera result;
    result.name = camera.name;
    result.transform = transform_of(transform);
    result.vertical_fov = camera.vertical_fov;
    if (camera.orthographic_height > 0) result.orthographic_height = camera.orthographic_height;
    result.intrinsics = camera.intrinsics;
    if (camera.projection) result.matrix = transform_of(*camera.projection);
    result.shift_x = camera.shift.x, result.shift_y = camera.shift.y;
    result.near = camera.near;
    result.far = camera.far;
    result.resolution = camera.resolution;
    return result;
}

}   // namespace gnomon::api
