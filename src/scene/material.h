// SPDX-License-Identifier: Apache-2.0
#pragma once
// Materials: glTF's metallic-roughness model and AFF's Whitted model. Colours are linear.

#include <memory>
#include <string>
#include <vector>

#include "base/math.h"
#include "scene/texture.h"

namespace gnomon::scene {

struct MaterialLayers;
struct MaterialTrack;

enum class ShadingModel : std::uint8_t { metallic_roughness, whitted, unlit };
enum class AlphaMode : std::uint8_t { opaque, mask, blend };

/// The surface class decides how rays treat a hit; the triangles of a mesh are sorted by it.
enum class SurfaceClass : std::uint8_t {
    opaque,        // occludes light
    masked,        // occludes light where alpha reaches the cutoff
    transparent,   // does not occlude light for shadow rays: AFF T > 0, glTF transmission, alpha mode BLEND, outlines;
                   // what thins light (see thins_light()) is asked for apart
};

struct Material {
    std::string name;
    ShadingModel model = ShadingModel::metallic_roughness;

    // Both models. In the Whitted model, base_color is the diffuse colour, and its texture multiplies ambient and
    // diffuse.
    glm::vec3 base_color{0.8f};
    TextureUse base_color_texture;
    bool double_sided = false;
    /// A surface that is seen as what lies beyond the scene behind it, darker where objects keep light from it: the
    /// ground under objects. Its colour counts for bounced light alone.
    bool catches_shadows = false;

    // glTF
    float alpha = 1;
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
    float metallic = 0;
    float roughness = 0.8f;
    TextureUse metallic_roughness_texture;   // roughness in G, metallic in B
    TextureUse normal_texture;
    float normal_scale = 1;
    TextureUse occlusion_texture;   // in R; darkens ambient light only
    float occlusion_strength = 1;
    glm::vec3 emissive{0};   // strength already multiplied in
    TextureUse emissive_texture;
    float transmission = 0;                         // glass; refracts with `ior` unless the layers say that it is thin
    std::shared_ptr<const MaterialLayers> layers;   // material_layers.h; null: none
    bool outline = false;                           // of an inverted hull: drawn, but casts no shadow
    bool hidden_from_camera = false;                // traced frames: straight camera rays pass

    // AFF [aff-format, `fm`]
    glm::vec3 ambient{0};
    glm::vec3 specular{0};     // colour of highlights and reflections
    float shine = 0;           // Phong exponent; 0: no highlight
    float transmittance = 0;   // T
    float ior = 1.5f;          // index of refraction inside

    std::shared_ptr<const MaterialTrack> track{};   // value_tracks.h; null: the values do not change by themselves

    SurfaceClass surface_class() const
    {
        if (transmittance > 0 || transmission > 0 || alpha_mode == AlphaMode::blend || outline)
            return SurfaceClass::transparent;
        return alpha_mode == AlphaMode::mask ? SurfaceClass::masked : SurfaceClass::opaque;
    }
    /// Whether camera and reflected rays hit the counter-clockwise side only.
    bool one_sided() const { return !double_sided && (outline || surface_class() != SurfaceClass::transparent); }
};

/// Whether a surface that does not occlude light lets only a part of it through: alpha mode BLEND, tinted sheets of
/// glass, and glass whose transmission a texture limits. See let_through() in ray/light_through.h.
bool thins_light(const Material& material);
/// All textures that a material may use.
std::vector<const TextureUse*> texture_uses(const Material& material);

/// Whether two materials have the same values, bit for bit; names and tracks aside.
bool same_values(const Material& a, const Material& b);
/// Whether rays meet the same surfaces with either material: the class and the visible sides are the same, and of
/// masked ones the holes. Only a material that is the same to rays may take the place of another in a SceneState.
bool same_to_rays(const Material& a, const Material& b);

}   // namespace gnomon::scene
