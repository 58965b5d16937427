// SPDX-License-Identifier: Apache-2.0
#pragma once
// A glTF document as plain structures, reduced to what the importer uses, with defaults filled in. Indices are in range
// (the schema check ensures that); no other guarantee holds before check_model().

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/math.h"
#include "io/gltf/context.h"

namespace gnomon::io::gltf {

using Index = std::uint32_t;
inline constexpr Index k_absent = 0xffffffffu;

enum class Component : std::uint8_t { unknown, i8, u8, i16, u16, u32, f32 };
enum class Shape : std::uint8_t { unknown, scalar, vec2, vec3, vec4, mat2, mat3, mat4 };

struct Sparse {
    std::uint64_t count = 0;
    Index index_view = k_absent, value_view = k_absent;
    std::uint64_t index_offset = 0, value_offset = 0;
    Component index_type = Component::unknown;
};

struct Accessor {
    Index view = k_absent;   // absent: zeros
    std::uint64_t offset = 0, count = 0;
    Component component = Component::unknown;
    Shape shape = Shape::unknown;
    bool normalized = false;
    std::vector<double> min, max;
    std::optional<Sparse> sparse;

    std::uint64_t component_bytes() const;
    /// Number of components in an element.
    int components() const;
    /// Bytes of an element: columns of matrices are aligned to multiples of four; padding after the last does not
    /// count.
    std::uint64_t element_bytes() const;
    /// Distance between tightly packed elements.
    std::uint64_t packed_stride() const;
    /// Offset of a component within an element.
    std::uint64_t component_offset(int component) const;
    bool known() const { return component != Component::unknown && shape != Shape::unknown; }
    /// "VEC3 of float", for messages.
    std::string format() const;
};

/// By EXT_meshopt_compression: where the compressed bytes of a buffer view are. The uncompressed ones may be missing.
struct Compression {
    Index buffer = 0;
    std::uint64_t offset = 0, length = 0, stride = 1, count = 0;
    std::string mode, filter = "NONE";
};

struct BufferView {
    Index buffer = 0;
    std::uint64_t offset = 0, length = 0, stride = 0;   // 0: tightly packed
    int target = 0;
    std::optional<Compression> compression;
};

struct Buffer {
    std::optional<std::string> uri;
    std::uint64_t length = 0;
};

struct Image {
    std::optional<std::string> uri;
    Index view = k_absent;
    std::string mime_type, name;
    bool extended = false;   // its data is in an extension
};

struct Sampler {
    int magnify = 0, minify = 0;   // 0: not given
    int wrap_s = 10497, wrap_t = 10497;
};

struct Texture {
    Index sampler = k_absent, source = k_absent;
    std::string name;
    bool compressed = false;   // KHR_texture_basisu; `source` is the fallback
};

struct TextureInfo {
    Index texture = k_absent;
    std::uint64_t texcoord = 0;
    glm::vec2 offset{0}, scale{1};
    float rotation = 0;
    float factor = 1;   // normal scale, occlusion strength
};

/// KHR_materials_pbrSpecularGlossiness.
struct Glossiness {
    std::array<float, 4> diffuse{1, 1, 1, 1};
    std::array<float, 3> specular{1, 1, 1};
    float glossiness = 1;
    TextureInfo diffuse_texture, specular_texture;
};

/// KHR_materials_specular, clearcoat, sheen, anisotropy, iridescence, volume, dispersion, and the texture of
/// transmission. Members as in scene::MaterialLayers.
struct Layers {
    float specular = 1;
    std::array<float, 3> specular_color{1, 1, 1};
    float clearcoat = 0, clearcoat_roughness = 0;
    std::array<float, 3> sheen_color{0, 0, 0};
    float sheen_roughness = 0, anisotropy = 0, anisotropy_rotation = 0;
    float iridescence = 0, iridescence_ior = 1.3f, iridescence_thickness_least = 100, iridescence_thickness_most = 400;
    float thickness = 0, attenuation_distance = 0, dispersion = 0;
    std::array<float, 3> attenuation_color{1, 1, 1};
    TextureInfo specular_texture, specular_color_texture, clearcoat_texture, clearcoat_roughness_texture,
        clearcoat_normal_texture, sheen_color_texture, sheen_roughness_texture, anisotropy_texture, iridescence_texture,
        iridescence_thickness_texture, transmission_texture, thickness_texture;
};

/// The textures of the layers, with the property of the file that each is read from.
struct LayerTexture {
    TextureInfo Layers::*info;
    const char* extension;
    const char* property;
};
inline constexpr LayerTexture k_layer_textures[] = {
    {&Layers::specular_texture, "KHR_materials_specular", "specularTexture"},
    {&Layers::specular_color_texture, "KHR_materials_specular", "specularColorTexture"},
    {&Layers::clearcoat_texture, "KHR_materials_clearcoat", "clearcoatTexture"},
    {&Layers::clearcoat_roughness_texture, "KHR_materials_clearcoat", "clearcoatRoughnessTexture"},
    {&Layers::clearcoat_normal_texture, "KHR_materials_clearcoat", "clearcoatNormalTexture"},
    {&Layers::sheen_color_texture, "KHR_materials_sheen", "sheenColorTexture"},
    {&Layers::sheen_roughness_texture, "KHR_materials_sheen", "sheenRoughnessTexture"},
    {&Layers::anisotropy_texture, "KHR_materials_anisotropy", "anisotropyTexture"},
    {&Layers::iridescence_texture, "KHR_materials_iridescence", "iridescenceTexture"},
    {&Layers::iridescence_thickness_texture, "KHR_materials_iridescence", "iridescenceThicknessTexture"},
    {&Layers::transmission_texture, "KHR_materials_transmission", "transmissionTexture"},
    {&Layers::thickness_texture, "KHR_materials_volume", "thicknessTexture"}};

struct Material {
    std::string name;
    std::array<float, 4> base_color{1, 1, 1, 1};
    float metallic = 1, roughness = 1;
    std::array<float, 3> emissive{0, 0, 0};
    TextureInfo base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture, emissive_texture;
    std::string alpha_mode = "OPAQUE";
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
    bool unlit = false;
    float emissive_strength = 1, ior = 1.5f, transmission = 0;
    std::optional<Glossiness> glossiness;   // replaces metallic-roughness
    std::optional<Layers> layers;
};

using Attributes = std::map<std::string, Index>;

struct Primitive {
    Attributes attributes;
    Index indices = k_absent, material = k_absent;
    int mode = 4;
    std::vector<Attributes> targets;
    struct Draco {
        Index view = k_absent;
        Attributes attributes;   // ids of compressed attributes, not accessors
    };
    std::optional<Draco> draco;   // KHR_draco_mesh_compression
    struct Mapping {
        Index material = k_absent;
        std::vector<Index> variants;
    };
    std::vector<Mapping> mappings;   // KHR_materials_variants
    bool has(const char* semantic) const { return attributes.contains(semantic); }
    Index find(const std::string& semantic) const;
};

struct Mesh {
    std::string name;
    std::vector<Primitive> primitives;
    std::optional<std::vector<float>> weights;

    /// The number of morph targets, which is that of each primitive.
    std::size_t targets() const { return primitives.empty() ? 0 : primitives.front().targets.size(); }
};

struct Node {
    std::string name;
    std::vector<Index> children;
    Index mesh = k_absent, skin = k_absent, camera = k_absent, light = k_absent;
    std::optional<std::array<double, 16>> matrix;
    std::optional<std::array<double, 3>> translation, scale;
    std::optional<std::array<double, 4>> rotation;   // x y z w
    std::optional<std::vector<float>> weights;
    std::optional<Attributes> instances;   // EXT_mesh_gpu_instancing
    bool visible = true;                   // KHR_node_visibility; with everything below
};

struct Skin {
    std::string name;
    Index inverse_bind = k_absent, skeleton = k_absent;
    std::vector<Index> joints;
};

enum class Path : std::uint8_t { translation, rotation, scale, weights, visibility, pointer, unknown };
/// What a pointer of KHR_animation_pointer may animate beside nodes; see pointers.h.
enum class Property : std::uint8_t {
    none,   // not supported, or it does not exist
    light_color,
    light_intensity,
    light_range,
    light_inner,
    light_outer,
    base_color,
    metallic,
    roughness,
    emissive,
    emissive_strength,
    yfov,
    ymag,
    camera_near,
    camera_far,
    first_part   // from here on: the rows of material_parts()
};
enum class Interpolation : std::uint8_t { linear, step, cubic_spline, unknown };

struct Channel {
    std::uint64_t sampler = 0;
    Index node = k_absent;
    Path path = Path::unknown;
    std::string path_word;
    bool has_pointer = false;   // KHR_animation_pointer, to something that is not a property of a node
    std::string pointer;
    Property property = Property::none;
    Index owner = k_absent;   // the light, material or camera that has the property
};

struct AnimationSampler {
    Index input = 0, output = 0;
    Interpolation interpolation = Interpolation::linear;
};

struct Animation {
    std::string name;
    std::vector<Channel> channels;
    std::vector<AnimationSampler> samplers;
};

struct Camera {
    std::string name, type;
    bool has_perspective = false, has_orthographic = false;
    std::optional<double> aspect, far;
    double yfov = 0, near = 0, xmag = 0, ymag = 0;
};

struct Light {
    std::string name, type;
    std::array<float, 3> color{1, 1, 1};
    float intensity = 1;
    float range = 0;   // 0: unlimited
    bool has_spot = false;
    float inner = 0, outer = static_cast<float>(k_pi / 4);
};

struct SceneEntry {
    std::string name;
    std::vector<Index> nodes;
};

struct Model {
    std::string version, min_version;
    std::vector<std::string> extensions_used, extensions_required;
    std::vector<Accessor> accessors;
    std::vector<BufferView> views;
    std::vector<Buffer> buffers;
    std::vector<Image> images;
    std::vector<Sampler> samplers;
    std::vector<Texture> textures;
    std::vector<Material> materials;
    std::vector<Mesh> meshes;
    std::vector<Node> nodes;
    std::vector<Skin> skins;
    std::vector<Animation> animations;
    std::vector<Camera> cameras;
    std::vector<Light> lights;
    std::vector<std::string> variants;   // names
    std::vector<SceneEntry> scenes;
    std::optional<Index> scene;
};

/// @param document  must have passed check_schema()
Model read_model(const nlohmann::json& document);

}   // namespace gnomon::io::gltf
