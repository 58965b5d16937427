// SPDX-License-Identifier: Apache-2.0
#include "shading/surface.h"

#include <algorithm>

#include "ray/origin.h"
#include "ray/smooth_surface.h"
#include "scene/emission_cone.h"
#include "scene/footprint.h"
#include "scene/material_layers.h"
#include "shading/layers.h"
#include "shading/lobe_shared.h"

namespace gnomon::shading {

namespace {

constexpr float k_least_sine = 1e-4f;     // least sine at which a ray has a direction along the surface
constexpr float k_least_cosine = 0.02f;   // least cosine between ray and normal; limits grazing footprints

glm::vec3 unit_or(const glm::vec3& v, const glm::vec3& otherwise)
{
    const float square = glm::dot(v, v);
    return square > 0 && std::isfinite(square) ? v * (1.0f / std::sqrt(square)) : otherwise;
}

// The triangle's data for texture look-ups.
struct TextureFrame {
    const scene::Scene& scene;
    const ray::ObjectGeometry& geometry;
    const scene::Mesh& mesh;
    glm::uvec3 index;
    float u, v;
    // The pixel's footprint: two diameters of an ellipse, each as steps in u and v.
    glm::vec2 along{0}, across{0};

    glm::vec2 texcoord(int set) const
    {
        const auto& t = mesh.texcoords[set];
        return (1 - u - v) * t[index[0]] + u * t[index[1]] + v * t[index[2]];
    }
    bool has(const scene::TextureUse& use) const { return use.used() && !mesh.texcoords[use.texcoord].empty(); }

    glm::vec4 look_up(const scene::TextureUse& use) const
    {
        const scene::Texture& texture = scene.textures[use.texture];
        const auto& t = mesh.texcoords[use.texcoord];
        const glm::vec2 a = t[index[1]] - t[index[0]], b = t[index[2]] - t[index[0]];
        return scene::sample_ellipse(texture, use.apply(texcoord(use.texcoord)),
                                     scene::apply_to_step(use, along.x * a + along.y * b),
                                     scene::apply_to_step(use, across.x * a + across.y * b));
    }
};

bool is_textured(const scene::Material& m)
{
    if (m.layers)
        for (const auto member : scene::k_layer_textures)
            if ((*m.layers.*member).used()) return true;
    return m.base_color_texture.used() || m.normal_texture.used() || m.metallic_roughness_texture.used() ||
           m.emissive_texture.used() || m.occlusion_texture.used();
}

// Finds the ellipse in which a cone of a given width meets the triangle: as wide as the cone, and longer along the ray.
void find_footprint(const glm::vec3 (&p)[3], float double_area, const glm::vec3& normal, const glm::vec3& direction,
                    float width, TextureFrame& frame)
{
    if (!(double_area > 0)) return;
    const glm::vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    // Choose two axes of equal length; the component of `forward` along the normal is irrelevant.
    glm::vec3 forward = direction, sideward = glm::cross(normal, direction);
    float square = glm::dot(sideward, sideward);
    if (square < k_least_sine * k_least_sine) {
        forward = e1, sideward = glm::cross(normal, e1);   // any direction will do, because the ellipse is a circle
        square = glm::dot(sideward, sideward);
        if (!(square > 0)) return;
    }
    const float across = width / (double_area * std::sqrt(square));
    const float along = across / std::max(std::abs(glm::dot(normal, direction)), k_least_cosine);
    // u and v are linear on the triangle. Use their gradients, which are perpendicular to the opposite edges.
    frame.along = along * glm::vec2(glm::dot(e2, sideward), -glm::dot(e1, sideward));
    frame.across = across * glm::vec2(-glm::dot(e2, forward), glm::dot(e1, forward));
}

// The tangent frame of normal maps across a normal; unit vectors, or 0 where there is none.
struct Tangents {
    glm::vec3 along{0}, up{0};   // of red, of green
};

// That of the file's own tangents, which ignore the texture's transform [glTF 2.0, 3.7.2.1].
Tangents file_tangents(const TextureFrame& frame, const glm::vec3& normal, bool front)
{
    const glm::vec4* t = frame.geometry.tangents;
    const glm::vec4 mean = std::max(0.0f, 1 - frame.u - frame.v) * t[frame.index[0]] + frame.u * t[frame.index[1]] +
                           frame.v * t[frame.index[2]];
    glm::vec3 along(mean);
    if (frame.geometry.to_world) along = glm::mat3(*frame.geometry.to_world) * along;
    along = unit_or(along - normal * glm::dot(normal, along), glm::vec3(0));
    // A mirrored mesh has a mirrored frame, too.
    const bool turned = (mean.w < 0) != frame.geometry.mirrored;
    return {along, glm::cross(normal, along) * (turned == front ? -1.0f : 1.0f)};
}

// That of the texture coordinates on the triangle, with the texture's transform.
Tangents texture_tangents(const scene::TextureUse& use, const TextureFrame& frame, const glm::vec3 (&p)[3],
                          const glm::vec3& normal)
{
    const auto& t = frame.mesh.texcoords[use.texcoord];
    const glm::vec2 a = scene::apply_to_step(use, t[frame.index[1]] - t[frame.index[0]]),
                    b = scene::apply_to_step(use, t[frame.index[2]] - t[frame.index[0]]);
    const float determinant = a.x * b.y - a.y * b.x;
    if (determinant == 0) return {};
    const glm::vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    const glm::vec3 along_u = (e1 * b.y - e2 * a.y) / determinant;
    const glm::vec3 along_v = (e2 * a.x - e1 * b.x) / determinant;
    const glm::vec3 along = unit_or(along_u - normal * glm::dot(normal, along_u), glm::vec3(0));
    // In glTF, green points up, against v, which runs down.
    const glm::vec3 up = glm::cross(normal, along);
    return {along, glm::dot(up, along_v) > 0 ? -up : up};
}

// Perturbs the shading normal by a normal map.
glm::vec3 mapped_normal(const scene::TextureUse& use, float normal_scale, const TextureFrame& frame,
                        const glm::vec3 (&p)[3], const glm::vec3& normal, bool front)
{
    const Tangents tangents =
        frame.geometry.tangents ? file_tangents(frame, normal, front) : texture_tangents(use, frame, p, normal);
    if (tangents.along == glm::vec3(0)) return normal;
    const glm::vec4 texel = frame.look_up(use);
    // A bump on the front is a dent on the back [glTF 2.0, 3.9.6: the whole normal is reversed].
    const float scale = front ? normal_scale : -normal_scale;
    const glm::vec3 n = glm::vec3(2 * texel.x - 1, 2 * texel.y - 1, 2 * texel.z - 1) * glm::vec3(scale, scale, 1);
    return unit_or(tangents.along * n.x + tangents.up * n.y + normal * n.z, normal);
}

void fill_whitted(const scene::Material& material, const TextureFrame& frame, SurfacePoint& s)
{
    glm::vec3 tint(1);
    if (frame.has(material.base_color_texture)) tint = glm::vec3(frame.look_up(material.base_color_texture));
    s.diffuse = material.base_color * tint;
    s.ambient = material.ambient * tint;
    s.specular = material.specular;
    s.shine = material.shine;
    if (material.transmittance > 0) {
        s.transmitted = glm::vec3(material.transmittance);
        s.ior = material.ior;
    }
}

// @param lit  what the surface's light needs beside its reflectance is filled in, too
void fill_metallic_roughness(const scene::Material& material, const TextureFrame& frame, bool lit, SurfacePoint& s)
{
    glm::vec3 base = material.base_color;
    float alpha = material.alpha;
    // Multiply vertex colours and textures into the material's factors.
    if (!frame.mesh.colors.empty()) {
        const auto& c = frame.mesh.colors;
        const glm::vec4 color =
            (1 - frame.u - frame.v) * c[frame.index[0]] + frame.u * c[frame.index[1]] + frame.v * c[frame.index[2]];
        base *= glm::vec3(color);
        alpha *= color.w;
    }
    if (frame.has(material.base_color_texture)) {
        const glm::vec4 texel = frame.look_up(material.base_color_texture);
        base *= glm::vec3(texel);
        alpha *= texel.w;
    }
    float metallic = material.metallic, roughness = material.roughness;
    if (frame.has(material.metallic_roughness_texture)) {
        const glm::vec4 texel = frame.look_up(material.metallic_roughness_texture);
        roughness *= texel.y;
        metallic *= texel.z;
    }
    s.emissive = material.emissive;
    if (lit && s.emissive != glm::vec3(0) && frame.has(material.emissive_texture))
        s.emissive *= glm::vec3(frame.look_up(material.emissive_texture));
    if (material.alpha_mode == scene::AlphaMode::blend) {
        s.coverage = std::clamp(alpha, 0.0f, 1.0f);
        s.uncovered = 1 - s.coverage;
    }

    if (material.model == scene::ShadingModel::unlit) {
        s.emissive = base;
        return;
    }
    // Split the base colour into specular, diffuse and transmitted light.
    const float f0 = (material.ior - 1) / (material.ior + 1);
    glm::vec3 dielectric(f0 * f0);
    float transmission = material.transmission;
    if (material.layers) {
        const scene::MaterialLayers& layers = *material.layers;
        const float strength =
            layers.specular * (frame.has(layers.specular_texture) ? frame.look_up(layers.specular_texture).w : 1);
        glm::vec3 color = layers.specular_color;
        if (frame.has(layers.specular_color_texture)) color *= glm::vec3(frame.look_up(layers.specular_color_texture));
        dielectric = strength * glm::min(f0 * f0 * color, glm::vec3(1));
        s.f90 = glm::mix(strength, 1.0f, metallic);
        if (frame.has(layers.transmission_texture)) transmission *= frame.look_up(layers.transmission_texture).x;
    }
    s.specular = glm::mix(dielectric, base, metallic);
    s.diffuse = base * ((1 - metallic) * (1 - transmission));
    s.transmitted = base * ((1 - metallic) * transmission);
    s.ior = material.ior;
    s.roughness = std::clamp(roughness, 0.0f, 1.0f);
    s.ambient = s.diffuse;
    if (lit && frame.has(material.occlusion_texture)) {
        const float occlusion = frame.look_up(material.occlusion_texture).x;
        s.ambient *= 1 + material.occlusion_strength * (occlusion - 1);
    }
}

// The outer side of a triangle. A mirroring transform reverses the winding, but does not swap inside and outside.
// @param normal  by its winding
glm::vec3 outward_of(const ray::ObjectGeometry& geometry, const glm::vec3& normal)
{
    return geometry.mirrored ? -normal : normal;
}

// Bends a shading normal that looks away from the viewer back to the horizon, and one that is seen so edge-on that it
// would have no lobe.
glm::vec3 to_viewers_side(const SurfacePoint& s, const glm::vec3& normal)
{
    const float facing = glm::dot(normal, s.to_viewer);
    return facing < GNOMON_LOBE_LEAST_VIEW
               ? unit_or(normal - (facing - GNOMON_BENT_VIEW) * s.to_viewer, s.geometric_normal)
               : normal;
}

// The direction of u on the surface, unit; 0 without texture coordinates.
glm::vec3 tangent_of(const scene::TextureUse& use, const TextureFrame& frame, const glm::vec3 (&p)[3],
                     const glm::vec3& normal)
{
    const auto& t = frame.mesh.texcoords[use.used() ? use.texcoord : 0];
    if (t.empty()) return glm::vec3(0);
    const glm::vec2 a = t[frame.index[1]] - t[frame.index[0]], b = t[frame.index[2]] - t[frame.index[0]];
    const float determinant = a.x * b.y - a.y * b.x;
    if (determinant == 0) return glm::vec3(0);
    const glm::vec3 along = ((p[1] - p[0]) * b.y - (p[2] - p[0]) * a.y) / determinant;
    return unit_or(along - normal * glm::dot(normal, along), glm::vec3(0));
}

// Fills in the layers above and inside the surface, and takes from the base what those above reflect.
// @param coat_normal  on the viewer's side
void fill_layers(const scene::Material& material, const TextureFrame& frame, const glm::vec3 (&p)[3],
                 const glm::vec3& coat_normal, SurfacePoint& s)
{
    const scene::MaterialLayers& m = *material.layers;
    const auto channel = [&](const scene::TextureUse& use, int i) {
        return frame.has(use) ? frame.look_up(use)[i] : 1;
    };
    LayerPoint& layers = s.layers;
    s.layered = true;
    const float cosine = std::clamp(glm::dot(s.normal, s.to_viewer), 0.0f, 1.0f);

    // A thin film changes the reflectance of the base.
    if (const float thin_film = m.iridescence * channel(m.iridescence_texture, 0); thin_film > 0) {
        const float thickness = glm::mix(m.iridescence_thickness_least, m.iridescence_thickness_most,
                                         channel(m.iridescence_thickness_texture, 1));
        const glm::vec3 seen = thin_film_reflectance(s.specular, cosine, m.iridescence_ior, thickness);
        // The reflectance at normal incidence from which Schlick's approximation makes it.
        const float x = 1 - cosine, rise = std::min(x * x * x * x * x, 0.9999f);
        const glm::vec3 f0 = glm::clamp((seen - s.f90 * rise) / (1 - rise), 0.0f, 1.0f);
        s.specular = glm::mix(s.specular, f0, thin_film);
    }
    if (m.anisotropy > 0) {
        glm::vec2 way(1, 0);
        layers.anisotropy = m.anisotropy;
        if (frame.has(m.anisotropy_texture)) {
            const glm::vec4 texel = frame.look_up(m.anisotropy_texture);
            way = 2.0f * glm::vec2(texel) - 1.0f;
            layers.anisotropy *= texel.z;
        }
        const float c = std::cos(m.anisotropy_rotation), sn = std::sin(m.anisotropy_rotation);
        way = {c * way.x - sn * way.y, sn * way.x + c * way.y};
        Tangents tangents;
        if (frame.geometry.tangents) {
            tangents = file_tangents(frame, s.normal, s.front);
        } else {
            tangents.along = tangent_of(m.anisotropy_texture, frame, p, s.normal);
            tangents.up = glm::cross(s.normal, tangents.along);
        }
        if (tangents.along == glm::vec3(0)) make_basis(s.normal, tangents.along, tangents.up);
        layers.grain = unit_or(way.x * tangents.along + way.y * tangents.up, tangents.along);
    }
    if (m.emission_outer > 0)
        s.emissive *= scene::emission_cone(material, frame.geometry.world_axis()).share(s.to_viewer);
    layers.thin = m.thin_walled;
    layers.absorption = m.absorption();
    layers.thickness = m.thickness * channel(m.thickness_texture, 1);
    layers.dispersion = m.dispersion;

    // Sheen takes light from the base; the coat takes it from both.
    const float alpha = s.coverage;
    float below_coat = alpha;
    if (const float coat = m.clearcoat * channel(m.clearcoat_texture, 0); coat > 0) {
        layers.coat_normal = coat_normal;
        layers.coat_roughness =
            std::clamp(m.clearcoat_roughness * channel(m.clearcoat_roughness_texture, 1), 0.0f, 1.0f);
        const float mirrored = coat * coat_fresnel(glm::dot(coat_normal, s.to_viewer));
        layers.coat = alpha * mirrored;
        below_coat = alpha * (1 - mirrored);
    }
    s.coverage = below_coat;
    if (m.sheen_color != glm::vec3(0)) {
        glm::vec3 color = m.sheen_color;
        if (frame.has(m.sheen_color_texture)) color *= glm::vec3(frame.look_up(m.sheen_color_texture));
        layers.sheen = below_coat * color;
        layers.sheen_roughness = std::clamp(m.sheen_roughness * channel(m.sheen_roughness_texture, 3), 0.0f, 1.0f);
        layers.sheen_albedo = sheen_albedo(cosine, layers.sheen_roughness);
        s.coverage *= 1 - std::max({color.x, color.y, color.z}) * layers.sheen_albedo;
    }
}

}   // namespace

TriangleReflectance::TriangleReflectance(const scene::Scene& scene, const ray::ObjectGeometry& geometry,
                                         std::uint32_t triangle)
    : scene_(scene),
      geometry_(geometry),
      material_(scene.materials[geometry.mesh->part_of(triangle).material]),
      index_(geometry.mesh->triangles[triangle])
{
    geometry.corners(triangle, corners_);
    const glm::vec3 cross = glm::cross(corners_[1] - corners_[0], corners_[2] - corners_[0]);
    double_area_ = std::sqrt(glm::dot(cross, cross));
    outward_ = outward_of(geometry, double_area_ > 0 ? cross / double_area_ : cross);
}

void TriangleReflectance::find(float u, float v, float distance, const glm::vec3& direction, const RayCone& cone,
                               SurfacePoint& s) const
{
    const glm::vec3 normal = glm::dot(outward_, direction) < 0 ? outward_ : -outward_;
    TextureFrame frame{scene_, geometry_, *geometry_.mesh, index_, u, v};
    if (is_textured(material_))
        find_footprint(corners_, double_area_, normal, direction, cone.width + distance * cone.spread, frame);
    s.model = material_.model;
    if (material_.model == scene::ShadingModel::whitted)
        fill_whitted(material_, frame, s);
    else
        fill_metallic_roughness(material_, frame, false, s);
}

void surface_at(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u,
                float v, float distance, const glm::vec3& direction, const RayCone& cone, SurfacePoint& s)
{
    const scene::Mesh& mesh = *geometry.mesh;
    const glm::uvec3 index = mesh.triangles[triangle];
    const scene::Material& material = scene.materials[mesh.part_of(triangle).material];

    // Interpolate the position from the corners, not along the ray, so that it lies on the triangle at any distance.
    glm::vec3 p[3];
    geometry.corners(triangle, p);
    const float w = std::max(0.0f, 1 - u - v);
    s.position = w * p[0] + u * p[1] + v * p[2];
    s.offset = ray::origin_lift(p);
    s.to_viewer = -direction;

    // Find the side that was hit.
    const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float double_area = std::sqrt(glm::dot(cross, cross));
    const glm::vec3 outward = outward_of(geometry, double_area > 0 ? cross / double_area : -direction);
    s.front = glm::dot(outward, direction) < 0;
    s.winding_front = s.front != geometry.mirrored;
    s.geometric_normal = s.front ? outward : -outward;

    // Interpolate the shading normal, and keep it on the viewer's side.
    s.normal = s.geometric_normal;
    if (geometry.normals) {
        glm::vec3 n = w * geometry.normals[index[0]] + u * geometry.normals[index[1]] + v * geometry.normals[index[2]];
        if (geometry.normal_to_world) n = *geometry.normal_to_world * n;
        s.normal = unit_or(s.front ? n : -n, s.geometric_normal);
    }

    s.cone.width = cone.width + distance * cone.spread;
    s.cone.spread = cone.spread;
    TextureFrame frame{scene, geometry, mesh, index, u, v};
    if (is_textured(material)) find_footprint(p, double_area, s.geometric_normal, direction, s.cone.width, frame);
    const glm::vec3 smooth_normal = s.normal;
    if (frame.has(material.normal_texture))
        s.normal = mapped_normal(material.normal_texture, material.normal_scale, frame, p, s.normal, s.front);

    // Bend a shading normal that looks away from the viewer back to the horizon.
    s.normal = to_viewers_side(s, s.normal);
    s.smooth_normal = s.geometric_normal;
    if (geometry.normals) s.smooth_normal = ray::smooth_horizon(s.geometric_normal, to_viewers_side(s, smooth_normal));

    s.model = material.model;
    s.catches_shadows = material.catches_shadows;
    if (material.model == scene::ShadingModel::whitted)
        fill_whitted(material, frame, s);
    else
        fill_metallic_roughness(material, frame, true, s);
    if (material.layers && material.model == scene::ShadingModel::metallic_roughness) {
        glm::vec3 coat_normal = smooth_normal;
        if (frame.has(material.layers->clearcoat_normal_texture))
            coat_normal = mapped_normal(material.layers->clearcoat_normal_texture,
                                        material.layers->clearcoat_normal_scale, frame, p, smooth_normal, s.front);
        fill_layers(material, frame, p, to_viewers_side(s, coat_normal), s);
    }
}

glm::vec3 smooth_origin(const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u, float v,
                        const SurfacePoint& s)
{
    return s.position + s.offset * s.geometric_normal + ray::smooth_lift(geometry, triangle, u, v, s.geometric_normal);
}

}   // namespace gnomon::shading
