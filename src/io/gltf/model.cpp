// SPDX-License-Identifier: Apache-2.0
#include "io/gltf/model.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "io/gltf/pointers.h"

namespace gnomon::io::gltf {

namespace {

using json = nlohmann::json;

const json* member(const json& object, const char* name)
{
    const auto found = object.find(name);
    return found == object.end() ? nullptr : &*found;
}

std::uint64_t integer(const json& object, const char* name, std::uint64_t otherwise = 0)
{
    const json* value = member(object, name);
    return value ? static_cast<std::uint64_t>(value->get<double>()) : otherwise;
}

Index index(const json& object, const char* name)
{
    return static_cast<Index>(integer(object, name, k_absent));
}

// Numbers are single precision unless glTF says otherwise; those that are too large become infinite and are rejected by
// check_model().
float real(const json& object, const char* name, float otherwise)
{
    const json* value = member(object, name);
    return value ? static_cast<float>(value->get<double>()) : otherwise;
}

std::optional<double> optional_real(const json& object, const char* name)
{
    const json* value = member(object, name);
    return value ? std::optional(value->get<double>()) : std::nullopt;
}

std::string text(const json& object, const char* name)
{
    const json* value = member(object, name);
    return value ? value->get<std::string>() : std::string();
}

bool flag(const json& object, const char* name)
{
    const json* value = member(object, name);
    return value && value->get<bool>();
}

template <class T, std::size_t n>
bool array(const json& object, const char* name, std::array<T, n>& out)
{
    const json* value = member(object, name);
    if (!value) return false;
    for (std::size_t i = 0; i < n; ++i) out[i] = static_cast<T>((*value)[i].get<double>());
    return true;
}

template <class T, std::size_t n>
std::optional<std::array<T, n>> optional_array(const json& object, const char* name)
{
    std::array<T, n> out{};
    return array(object, name, out) ? std::optional(out) : std::nullopt;
}

template <class T>
std::optional<std::vector<T>> list(const json& object, const char* name)
{
    const json* value = member(object, name);
    if (!value) return std::nullopt;
    std::vector<T> out;
    out.reserve(value->size());
    for (const json& element : *value) out.push_back(static_cast<T>(element.get<double>()));
    return out;
}

std::vector<std::string> strings(const json& object, const char* name)
{
    const json* value = member(object, name);
    return value ? value->get<std::vector<std::string>>() : std::vector<std::string>();
}

const json* extension(const json& object, const char* name)
{
    const json* extensions = member(object, "extensions");
    return extensions ? member(*extensions, name) : nullptr;
}

// Reads each element of an array.
template <class T, class Read>
void each(const json& object, const char* name, std::vector<T>& out, Read read)
{
    const json* value = member(object, name);
    if (!value) return;
    out.reserve(value->size());
    for (const json& element : *value) out.push_back(read(element));
}

Component component(std::uint64_t code)
{
    switch (code) {
        case 5120:
            return Component::i8;
        case 5121:
            return Component::u8;
        case 5122:
            return Component::i16;
        case 5123:
            return Component::u16;
        case 5125:
            return Component::u32;
        case 5126:
            return Component::f32;
        default:
            return Component::unknown;
    }
}

Shape shape(const std::string& word)
{
    static const std::map<std::string, Shape> shapes = {
        {"SCALAR", Shape::scalar}, {"VEC2", Shape::vec2}, {"VEC3", Shape::vec3}, {"VEC4", Shape::vec4},
        {"MAT2", Shape::mat2},     {"MAT3", Shape::mat3}, {"MAT4", Shape::mat4}};
    const auto found = shapes.find(word);
    return found == shapes.end() ? Shape::unknown : found->second;
}

Accessor read_accessor(const json& j)
{
    Accessor a;
    a.view = index(j, "bufferView");
    a.offset = integer(j, "byteOffset");
    a.count = integer(j, "count");
    a.component = component(integer(j, "componentType"));
    a.shape = shape(text(j, "type"));
    a.normalized = flag(j, "normalized");
    a.min = list<double>(j, "min").value_or(std::vector<double>());
    a.max = list<double>(j, "max").value_or(std::vector<double>());
    if (const json* s = member(j, "sparse")) {
        const json& indices = (*s)["indices"];
        const json& values = (*s)["values"];
        a.sparse = Sparse{integer(*s, "count"),          index(indices, "bufferView"),
                          index(values, "bufferView"),   integer(indices, "byteOffset"),
                          integer(values, "byteOffset"), component(integer(indices, "componentType"))};
    }
    return a;
}

BufferView read_view(const json& j)
{
    BufferView v;
    v.buffer = index(j, "buffer");
    v.offset = integer(j, "byteOffset");
    v.length = integer(j, "byteLength");
    v.stride = integer(j, "byteStride");
    v.target = static_cast<int>(integer(j, "target"));
    if (const json* e = extension(j, "EXT_meshopt_compression")) {
        Compression& c = v.compression.emplace();
        c.buffer = index(*e, "buffer");
        c.offset = integer(*e, "byteOffset", 0), c.length = integer(*e, "byteLength", 0);
        c.stride = integer(*e, "byteStride", 1), c.count = integer(*e, "count", 0);
        c.mode = text(*e, "mode");
        if (member(*e, "filter")) c.filter = text(*e, "filter");
    }
    return v;
}

TextureInfo read_texture_info(const json& parent, const char* name, const char* factor = nullptr)
{
    TextureInfo info;
    const json* j = member(parent, name);
    if (!j) return info;
    info.texture = index(*j, "index");
    info.texcoord = integer(*j, "texCoord");
    if (factor) info.factor = real(*j, factor, 1);
    if (const json* t = extension(*j, "KHR_texture_transform")) {
        std::array<float, 2> pair{0, 0};
        if (array(*t, "offset", pair)) info.offset = {pair[0], pair[1]};
        if (array(*t, "scale", pair)) info.scale = {pair[0], pair[1]};
        info.rotation = real(*t, "rotation", 0);
        info.texcoord = integer(*t, "texCoord", info.texcoord);
    }
    return info;
}

// Reads the extensions that add layers to a material; none if there is none of them.
std::optional<Layers> read_layers(const json& j)
{
    Layers l;
    bool any = false;
    const auto read = [&](const char* name) {
        const json* e = extension(j, name);
        if (!e) return e;
        any = true;
        for (const LayerTexture& texture : k_layer_textures)
            if (std::strcmp(texture.extension, name) == 0)
                l.*texture.info = read_texture_info(
                    *e, texture.property, texture.info == &Layers::clearcoat_normal_texture ? "scale" : nullptr);
        return e;
    };
    read("KHR_materials_transmission");
    if (const json* e = read("KHR_materials_specular")) {
        l.specular = real(*e, "specularFactor", 1);
        array(*e, "specularColorFactor", l.specular_color);
    }
    if (const json* e = read("KHR_materials_clearcoat")) {
        l.clearcoat = real(*e, "clearcoatFactor", 0);
        l.clearcoat_roughness = real(*e, "clearcoatRoughnessFactor", 0);
    }
    if (const json* e = read("KHR_materials_sheen")) {
        array(*e, "sheenColorFactor", l.sheen_color);
        l.sheen_roughness = real(*e, "sheenRoughnessFactor", 0);
    }
    if (const json* e = read("KHR_materials_anisotropy")) {
        l.anisotropy = real(*e, "anisotropyStrength", 0);
        l.anisotropy_rotation = real(*e, "anisotropyRotation", 0);
    }
    if (const json* e = read("KHR_materials_iridescence")) {
        l.iridescence = real(*e, "iridescenceFactor", 0);
        l.iridescence_ior = real(*e, "iridescenceIor", 1.3f);
        l.iridescence_thickness_least = real(*e, "iridescenceThicknessMinimum", 100);
        l.iridescence_thickness_most = real(*e, "iridescenceThicknessMaximum", 400);
    }
    if (const json* e = read("KHR_materials_volume")) {
        l.thickness = real(*e, "thicknessFactor", 0);
        l.attenuation_distance = real(*e, "attenuationDistance", 0);
        array(*e, "attenuationColor", l.attenuation_color);
    }
    if (const json* e = read("KHR_materials_dispersion")) l.dispersion = real(*e, "dispersion", 0);
    return any ? std::optional(l) : std::nullopt;
}

Material read_material(const json& j)
{
    Material m;
    m.name = text(j, "name");
    if (const json* pbr = member(j, "pbrMetallicRoughness")) {
        array(*pbr, "baseColorFactor", m.base_color);
        m.metallic = real(*pbr, "metallicFactor", 1);
        m.roughness = real(*pbr, "roughnessFactor", 1);
        m.base_color_texture = read_texture_info(*pbr, "baseColorTexture");
        m.metallic_roughness_texture = read_texture_info(*pbr, "metallicRoughnessTexture");
    }
    m.normal_texture = read_texture_info(j, "normalTexture", "scale");
    m.occlusion_texture = read_texture_info(j, "occlusionTexture", "strength");
    m.emissive_texture = read_texture_info(j, "emissiveTexture");
    array(j, "emissiveFactor", m.emissive);
    if (member(j, "alphaMode")) m.alpha_mode = text(j, "alphaMode");
    m.alpha_cutoff = real(j, "alphaCutoff", 0.5f);
    m.double_sided = flag(j, "doubleSided");
    m.unlit = extension(j, "KHR_materials_unlit") != nullptr;
    if (const json* e = extension(j, "KHR_materials_emissive_strength"))
        m.emissive_strength = real(*e, "emissiveStrength", 1);
    if (const json* e = extension(j, "KHR_materials_ior")) m.ior = real(*e, "ior", 1.5f);
    if (const json* e = extension(j, "KHR_materials_pbrSpecularGlossiness")) {
        Glossiness& g = m.glossiness.emplace();
        array(*e, "diffuseFactor", g.diffuse);
        array(*e, "specularFactor", g.specular);
        g.glossiness = real(*e, "glossinessFactor", 1);
        g.diffuse_texture = read_texture_info(*e, "diffuseTexture");
        g.specular_texture = read_texture_info(*e, "specularGlossinessTexture");
    }
    if (const json* e = extension(j, "KHR_materials_transmission")) m.transmission = real(*e, "transmissionFactor", 0);
    m.layers = read_layers(j);
    return m;
}

Attributes read_attributes(const json& j)
{
    Attributes attributes;
    for (auto item = j.begin(); item != j.end(); ++item)
        attributes[item.key()] = static_cast<Index>(std::min<double>(item.value().get<double>(), k_absent));
    return attributes;
}

Primitive read_primitive(const json& j)
{
    Primitive p;
    p.attributes = read_attributes(j["attributes"]);
    p.indices = index(j, "indices");
    p.material = index(j, "material");
    p.mode = static_cast<int>(std::min<std::uint64_t>(integer(j, "mode", 4), 7));   // 7: unknown
    each(j, "targets", p.targets, read_attributes);
    if (const json* d = extension(j, "KHR_draco_mesh_compression"))
        p.draco = Primitive::Draco{index(*d, "bufferView"), read_attributes((*d)["attributes"])};
    if (const json* v = extension(j, "KHR_materials_variants"))
        each(*v, "mappings", p.mappings, [](const json& m) {
            return Primitive::Mapping{index(m, "material"), list<Index>(m, "variants").value_or(std::vector<Index>())};
        });
    return p;
}

Node read_node(const json& j)
{
    Node n;
    n.name = text(j, "name");
    n.children = list<Index>(j, "children").value_or(std::vector<Index>());
    n.mesh = index(j, "mesh");
    n.skin = index(j, "skin");
    n.camera = index(j, "camera");
    if (const json* light = extension(j, "KHR_lights_punctual")) n.light = index(*light, "light");
    n.matrix = optional_array<double, 16>(j, "matrix");
    n.translation = optional_array<double, 3>(j, "translation");
    n.rotation = optional_array<double, 4>(j, "rotation");
    n.scale = optional_array<double, 3>(j, "scale");
    n.weights = list<float>(j, "weights");
    if (const json* e = extension(j, "KHR_node_visibility")) n.visible = !member(*e, "visible") || flag(*e, "visible");
    if (const json* e = extension(j, "EXT_mesh_gpu_instancing")) {
        const json* attributes = member(*e, "attributes");
        n.instances = attributes ? read_attributes(*attributes) : Attributes();
    }
    return n;
}

Animation read_animation(const json& j)
{
    Animation a;
    a.name = text(j, "name");
    each(j, "channels", a.channels, [](const json& c) {
        static const std::map<std::string, Path> paths = {{"translation", Path::translation},
                                                          {"rotation", Path::rotation},
                                                          {"scale", Path::scale},
                                                          {"weights", Path::weights},
                                                          {"pointer", Path::pointer}};
        Channel channel;
        channel.sampler = integer(c, "sampler");
        const json& target = c["target"];
        channel.node = index(target, "node");
        channel.path_word = text(target, "path");
        const auto found = paths.find(channel.path_word);
        channel.path = found == paths.end() ? Path::unknown : found->second;
        if (const json* e = extension(target, "KHR_animation_pointer")) {
            channel.has_pointer = true;
            channel.pointer = text(*e, "pointer");
        }
        return channel;
    });
    each(j, "samplers", a.samplers, [](const json& s) {
        AnimationSampler sampler{index(s, "input"), index(s, "output"), Interpolation::linear};
        const std::string word = member(s, "interpolation") ? text(s, "interpolation") : "LINEAR";
        if (word != "LINEAR")
            sampler.interpolation = word == "STEP"          ? Interpolation::step
                                    : word == "CUBICSPLINE" ? Interpolation::cubic_spline
                                                            : Interpolation::unknown;
        return sampler;
    });
    return a;
}

Camera read_camera(const json& j)
{
    Camera c;
    c.name = text(j, "name");
    c.type = text(j, "type");
    if (const json* p = member(j, "perspective")) {
        c.has_perspective = true;
        c.aspect = optional_real(*p, "aspectRatio");
        c.yfov = optional_real(*p, "yfov").value_or(0);
        c.near = optional_real(*p, "znear").value_or(0);
        c.far = optional_real(*p, "zfar");
    }
    if (const json* o = member(j, "orthographic")) {
        c.has_orthographic = true;
        c.xmag = optional_real(*o, "xmag").value_or(0);
        c.ymag = optional_real(*o, "ymag").value_or(0);
        c.near = optional_real(*o, "znear").value_or(0);
        c.far = optional_real(*o, "zfar");
    }
    return c;
}

Light read_light(const json& j)
{
    Light l;
    l.name = text(j, "name");
    l.type = text(j, "type");
    array(j, "color", l.color);
    l.intensity = real(j, "intensity", 1);
    l.range = real(j, "range", 0);
    if (const json* spot = member(j, "spot")) {
        l.has_spot = true;
        l.inner = real(*spot, "innerConeAngle", 0);
        l.outer = real(*spot, "outerConeAngle", l.outer);
    }
    return l;
}

}   // namespace

std::uint64_t Accessor::component_bytes() const
{
    switch (component) {
        case Component::i8:
        case Component::u8:
            return 1;
        case Component::i16:
        case Component::u16:
            return 2;
        default:
            return 4;
    }
}

int Accessor::components() const
{
    static constexpr int counts[] = {1, 1, 2, 3, 4, 4, 9, 16};
    return counts[static_cast<int>(shape)];
}

std::uint64_t Accessor::component_offset(int i) const
{
    const std::uint64_t size = component_bytes();
    const int rows = shape == Shape::mat2 ? 2 : shape == Shape::mat3 ? 3 : shape == Shape::mat4 ? 4 : 0;
    if (rows == 0) return static_cast<std::uint64_t>(i) * size;
    const std::uint64_t column = (static_cast<std::uint64_t>(rows) * size + 3) / 4 * 4;
    return static_cast<std::uint64_t>(i / rows) * column + static_cast<std::uint64_t>(i % rows) * size;
}

std::uint64_t Accessor::element_bytes() const
{
    return component_offset(components() - 1) + component_bytes();
}

std::uint64_t Accessor::packed_stride() const
{
    const std::uint64_t bytes = element_bytes();
    return shape >= Shape::mat2 ? (bytes + 3) / 4 * 4 : bytes;
}

std::string Accessor::format() const
{
    static constexpr const char* components[] = {"unknown",        "byte",         "unsigned byte", "short",
                                                 "unsigned short", "unsigned int", "float"};
    static constexpr const char* shapes[] = {"unknown", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
    return fmt::format("{} of {}{}", shapes[static_cast<int>(shape)], normalized ? "normalized " : "",
                       components[static_cast<int>(component)]);
}

Index Primitive::find(const std::string& semantic) const
{
    const auto found = attributes.find(semantic);
    return found == attributes.end() ? k_absent : found->second;
}

Model read_model(const json& document)
{
    Model m;
    m.version = text(document["asset"], "version");
    m.min_version = text(document["asset"], "minVersion");
    m.extensions_used = strings(document, "extensionsUsed");
    m.extensions_required = strings(document, "extensionsRequired");
    each(document, "accessors", m.accessors, read_accessor);
    each(document, "bufferViews", m.views, read_view);
    each(document, "buffers", m.buffers, [](const json& j) {
        Buffer b;
        if (member(j, "uri")) b.uri = text(j, "uri");
        b.length = integer(j, "byteLength");
        return b;
    });
    each(document, "images", m.images, [](const json& j) {
        Image i;
        if (member(j, "uri")) i.uri = text(j, "uri");
        i.view = index(j, "bufferView");
        i.mime_type = text(j, "mimeType");
        i.name = text(j, "name");
        i.extended = member(j, "extensions") != nullptr;
        return i;
    });
    each(document, "samplers", m.samplers, [](const json& j) {
        const auto code = [&](const char* name, std::uint64_t otherwise) {
            return static_cast<int>(std::min<std::uint64_t>(integer(j, name, otherwise), 65535));
        };
        return Sampler{code("magFilter", 0), code("minFilter", 0), code("wrapS", 10497), code("wrapT", 10497)};
    });
    each(document, "textures", m.textures, [](const json& j) {
        Texture texture{index(j, "sampler"), index(j, "source"), text(j, "name"),
                        extension(j, "KHR_texture_basisu") != nullptr};
        // An image that is there for readers without WebP shows the same.
        if (const json* webp = extension(j, "EXT_texture_webp"); webp && texture.source == k_absent)
            texture.source = index(*webp, "source");
        return texture;
    });
    each(document, "materials", m.materials, read_material);
    each(document, "meshes", m.meshes, [](const json& j) {
        Mesh mesh;
        mesh.name = text(j, "name");
        each(j, "primitives", mesh.primitives, read_primitive);
        mesh.weights = list<float>(j, "weights");
        return mesh;
    });
    each(document, "nodes", m.nodes, read_node);
    each(document, "skins", m.skins, [](const json& j) {
        return Skin{text(j, "name"), index(j, "inverseBindMatrices"), index(j, "skeleton"),
                    list<Index>(j, "joints").value_or(std::vector<Index>())};
    });
    each(document, "animations", m.animations, read_animation);
    each(document, "cameras", m.cameras, read_camera);
    if (const json* lights = extension(document, "KHR_lights_punctual")) each(*lights, "lights", m.lights, read_light);
    if (const json* variants = extension(document, "KHR_materials_variants"))
        each(*variants, "variants", m.variants, [](const json& j) { return text(j, "name"); });
    each(document, "scenes", m.scenes, [](const json& j) {
        return SceneEntry{text(j, "name"), list<Index>(j, "nodes").value_or(std::vector<Index>())};
    });
    if (member(document, "scene")) m.scene = index(document, "scene");
    resolve_pointers(m);
    return m;
}

}   // namespace gnomon::io::gltf
