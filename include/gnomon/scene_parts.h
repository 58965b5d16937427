// SPDX-License-Identifier: Apache-2.0
#pragma once
// What a scene consists of, as a host describes it: meshes, textures, materials, lights, cameras.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gnomon/ids.h"
#include "gnomon/math.h"
#include "gnomon/types.h"

namespace gnomon {

/// Whether a host may move an object later, as tracks do in a file. What is fixed is stored for fast rays, and its
/// shadows are remembered. What is declared fixed and changes all the same is promoted: in that frame the renderer
/// starts anew, and from then on its images are those of a scene that declared the object so.
enum class Mobility : std::uint8_t {
    fixed,
    may_move,     // transform and visibility may change
    may_deform,   // vertices and weights of morph targets may change, too
};

/// The joints of four influences on a vertex, as indices into Skin::joints.
struct Joints {
    std::array<std::uint16_t, 4> joint{};
};

/// Offsets from the mesh's vertices. Each array is empty or has one element per vertex.
struct MorphTarget {
    std::span<const Vec3> positions{}, normals{}, tangents{};
};

/// A run of triangles with a material of its own.
struct MeshPart {
    MaterialId material{};
    std::uint32_t first_triangle = 0, triangle_count = 0;
};

/// A triangle mesh. The arrays are copied. All but the first two are empty or have one element per vertex.
struct Mesh {
    std::span<const Vec3> positions{};          // in object space, metres
    std::span<const std::uint32_t> indices{};   // three per triangle, counter-clockwise seen from the front; empty: the
                                                // vertices in order
    std::span<const Vec3> normals{};            // scaled to unit length, 0: of the triangles around; empty: faceted
    std::span<const Vec4> tangents{};           // of normal maps: xyz scaled to unit length, w = -1 or 1
    std::array<std::span<const Vec2>, 2> texcoords{};   // v from the top
    std::span<const Vec4> colors{};                     // linear RGBA; multiplies the base colour
    std::span<const MeshPart> parts{};                  // cover all triangles in order; empty: one material throughout
    std::span<const MorphTarget> morph_targets{};
    std::span<const float> morph_weights{};            // one per target; empty: all 0
    std::array<std::span<const Joints>, 2> joints{};   // of a skin; the second four of a vertex are optional
    std::array<std::span<const Vec4>, 2> weights{};    // of the joints; scaled to a sum of 1
    std::string name{};
};

/// Joints that deform skinned meshes by linear blending.
struct Skin {
    std::vector<NodeId> joints{};
    std::vector<Transform> inverse_bind{};   // one per joint: from the mesh's space to the joint's at rest
    std::string name{};
};

/// What a texture shows outside of 0 to 1.
enum class Wrap : std::uint8_t { repeat, mirror, clamp };
/// How a texture is read between its texels.
enum class Filter : std::uint8_t { nearest, linear };

/// An 8-bit image for materials; copied. Row 0 is the upper edge, where v = 0.
struct Texture {
    int width = 0, height = 0;
    int channels = 4;                         // 1: grey, 2: grey and alpha, 3: RGB, 4: RGBA
    std::span<const std::uint8_t> pixels{};   // channels interleaved
    std::ptrdiff_t row_bytes = 0;             // from one row to the next; 0: width * channels
    bool srgb = true;                         // colour is sRGB-encoded; false: linear data, such as normals
    Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
    Filter magnify = Filter::linear, minify = Filter::linear;
    bool mipmaps = true;
    std::string name{};
};

/// A texture as a material uses it: coordinates are scaled, rotated, then moved (KHR_texture_transform).
struct TextureUse {
    TextureId texture{};   // none: a constant 1
    int texcoord = 0;      // the mesh's first or second coordinates
    Vec2 offset{}, scale{1, 1};
    float rotation = 0;   // radians, counter-clockwise
    friend bool operator==(const TextureUse&, const TextureUse&) = default;
};

/// How a surface reflects: by glTF's metallic-roughness model, by Whitted's, or not at all (it shows its base colour).
enum class ShadingModel : std::uint8_t { metallic_roughness, whitted, unlit };
/// What alpha means: nothing; where the surface is cut out (`mask`); how much it covers of what is behind (`blend`).
enum class AlphaMode : std::uint8_t { opaque, mask, blend };

/// What a metallic-roughness material may have beside its base: layers above it, a specular lobe of its own, and what
/// light meets inside. The values are those of glTF's extensions KHR_materials_specular, clearcoat, sheen, anisotropy,
/// iridescence, transmission, volume and dispersion.
struct MaterialLayers {
    float specular = 1;              // 0 to 1: scales the dielectric's reflectance
    TextureUse specular_texture{};   // in A
    Vec3 specular_color{1, 1, 1};    // scales its reflectance at normal incidence; may exceed 1
    TextureUse specular_color_texture{};

    float clearcoat = 0, clearcoat_roughness = 0;                    // 0 to 1; a coat of index 1.5
    TextureUse clearcoat_texture{}, clearcoat_roughness_texture{};   // in R; in G
    TextureUse clearcoat_normal_texture{};
    float clearcoat_normal_scale = 1;

    Vec3 sheen_color{};                                            // of fibres, 0 to 1; 0: none
    float sheen_roughness = 0;                                     // 0 to 1
    TextureUse sheen_color_texture{}, sheen_roughness_texture{};   // the second in A

    float anisotropy = 0;              // 0 to 1: how much wider highlights are along the grain
    float anisotropy_rotation = 0;     // of the grain from the tangent, radians, counter-clockwise
    TextureUse anisotropy_texture{};   // direction in RG, strength in B

    float iridescence = 0;                                                       // 0 to 1: of a thin film
    TextureUse iridescence_texture{};                                            // in R
    float iridescence_ior = 1.3f;                                                // of the thin film, 1 or more
    float iridescence_thickness_least = 100, iridescence_thickness_most = 400;   // nanometres
    TextureUse iridescence_thickness_texture{};   // in G: from the least to the most; none: the most

    TextureUse transmission_texture{};   // in R
    bool thin_walled = false;            // light passes without refraction, tinted by the base colour
    float thickness = 0;                 // of the body, metres; used where refracted rays are not traced
    TextureUse thickness_texture{};      // in G
    Vec3 attenuation_color{1, 1, 1};     // 0 to 1: white light after `attenuation_distance` inside
    float attenuation_distance = 0;      // metres; 0: nothing is absorbed
    float dispersion = 0;                // 20 divided by the Abbe number

    /// The cone around the instance's -Z within which the surface emits: radians from the axis. The light falls off as
    /// that of a spot with SpotProfile::smooth_cosine. Outer 0: it emits in all directions.
    float emission_inner = 0, emission_outer = 0;   // 0 to pi / 2

    friend bool operator==(const MaterialLayers&, const MaterialLayers&) = default;
};

/// A surface: glTF 2.0's metallic-roughness model, or the model of Whitted that the scenes of BART have. Colours are
/// linear.
struct Material {
    std::string name{};
    ShadingModel model = ShadingModel::metallic_roughness;
    Vec3 base_color{0.8f, 0.8f, 0.8f};   // whitted: the diffuse colour
    TextureUse base_color_texture{};
    bool double_sided = false;

    // metallic_roughness
    float alpha = 1;
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;   // AlphaMode::mask: the surface is there where alpha reaches it
    float metallic = 0, roughness = 0.8f;
    TextureUse metallic_roughness_texture{};   // roughness in G, metallic in B
    TextureUse normal_texture{};
    float normal_scale = 1;
    TextureUse occlusion_texture{};   // in R; darkens ambient light only
    float occlusion_strength = 1;
    Vec3 emissive{};   // radiance in nits
    TextureUse emissive_texture{};
    float transmission = 0;   // 0 to 1: glass, which refracts by `ior` unless its layers say that it is thin
    float ior = 1.5f;         // index of refraction inside; of both models

    // whitted
    Vec3 ambient{}, specular{};   // specular: of highlights and reflections
    float shine = 0;              // exponent of highlights; 0: none
    float transmittance = 0;      // 0 to 1

    std::optional<MaterialLayers> layers{};   // metallic_roughness
    bool outline = false;              // of an inverted hull, drawn around a body as its outline: it casts no shadow
    bool hidden_from_camera = false;   // traced frames: cameras see what is behind it; mirrors and light meet it

    friend bool operator==(const Material&, const Material&) = default;
};

/// Where light comes from: a point, a point within a cone, or one direction, as that of the sun.
enum class LightType : std::uint8_t { point, spot, directional };
/// How irradiance depends on distance: by the inverse square, or not at all (BART).
enum class Falloff : std::uint8_t { inverse_square, constant };
/// The profile of a spot: smooth between the inner and the outer angle (glTF), the cosine from the axis, or that cosine
/// with smooth steps between the angles (Blender).
enum class SpotProfile : std::uint8_t { smooth, cosine, smooth_cosine };

/// A light without size, at its node's origin and directed along the node's -Z.
struct Light {
    std::string name{};
    LightType type = LightType::point;
    Vec3 color{1, 1, 1};   // candela (point and spot), lux (directional); with constant falloff, the irradiance itself
    Falloff falloff = Falloff::inverse_square;
    SpotProfile profile = SpotProfile::smooth;
    float inner_angle = 0, outer_angle = 0.7853982f;   // of a spot: radians from the axis
    float range = 0;                                   // metres beyond which it is dark; 0: unlimited
    friend bool operator==(const Light&, const Light&) = default;
};

/// The shape of a light with size, around its node's origin: a rectangle or a disc across the node's Z axis, or a
/// sphere.
enum class AreaLightShape : std::uint8_t { rectangle, disc, sphere };

/// A light with size: a surface of one radiance, which mirrors see as well, and cameras unless it is hidden from them.
struct AreaLight {
    std::string name{};
    AreaLightShape shape = AreaLightShape::rectangle;
    float width = 1, height = 1;       // metres along X and Y; of a disc and a sphere, `width` is the diameter
    Vec3 radiance{1, 1, 1};            // nits
    bool two_sided = false;            // rectangle and disc: it emits along +Z, too; otherwise along -Z alone
    bool hidden_from_camera = false;   // see Material
    /// The cone around -Z within which it emits, as a spot does: see MaterialLayers::emission_inner. Outer 0: none.
    float inner_angle = 0, outer_angle = 0;   // 0 to pi / 2
    friend bool operator==(const AreaLight&, const AreaLight&) = default;
};

/// Focal lengths and principal point in pixels, as cameras are calibrated. Pixel centres are at (0.5, 0.5) from the top
/// left corner.
struct Intrinsics {
    double fx = 0, fy = 0;
    double cx = 0, cy = 0;
    Size size{};   // of the image that these pixels belong to; 0 x 0: of the rendered image
    friend bool operator==(const Intrinsics&, const Intrinsics&) = default;
};

/// A camera. It looks along the -Z of its space, with +Y up. The first of `matrix`, `intrinsics` and
/// `orthographic_height` that is given decides the projection; otherwise it is a perspective by `vertical_fov`.
struct Camera {
    std::string name{};
    /// From camera space to the world, or to its node's parent in a scene. Its scale is ignored.
    Transform transform{};
    double vertical_fov = 0.8;                     // whole angle, radians; the width follows from the image
    std::optional<double> orthographic_height{};   // metres
    std::optional<Intrinsics> intrinsics{};
    /// A projection as OpenGL has it: from camera space to clip space, w = -z for a perspective. It may be off-centre,
    /// and decides `near` and `far`; it must not be skewed.
    std::optional<Transform> matrix{};
    double shift_x = 0, shift_y = 0;   // moves the image plane right and up, as a fraction of the image's height
    double near = 0.01, far = 0;       // metres along the view axis; far 0: unlimited
    Size resolution{};                 // at which it is rendered if no size is given; 0 x 0: 1280 x 720
    friend bool operator==(const Camera&, const Camera&) = default;
};

/// An environment map: longitude by latitude, its upper edge towards +Y, its centre towards -Z and its right quarter
/// towards +X. The pixels are copied.
struct EnvironmentImage {
    int width = 0, height = 0;
    std::span<const float> pixels{};   // three per pixel: radiance in nits; negative values and NaN count as 0
};

}   // namespace gnomon
