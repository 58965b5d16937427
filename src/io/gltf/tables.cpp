// SPDX-License-Identifier: Apache-2.0
// The tables of glTF 2.0 and of the extensions whose structure the importer checks.
#include <array>
#include <numbers>

#include "io/gltf/schema.h"

namespace gnomon::io::gltf {

namespace {

constexpr double k_inf = std::numeric_limits<double>::infinity();

// Short names, so that a table reads like the specification's.
constexpr Rule need(Rule rule)
{
    return rule.required = true, rule;
}
constexpr Rule boolean(const char* name)
{
    return {.name = name, .kind = Kind::boolean};
}
constexpr Rule text(const char* name)
{
    return {.name = name, .kind = Kind::string};
}
constexpr Rule integer(const char* name, double low = 0, double high = k_inf)
{
    return {.name = name, .kind = Kind::integer, .low = low, .high = high};
}
constexpr Rule number(const char* name, double low = -k_inf, double high = k_inf)
{
    return {.name = name, .kind = Kind::number, .low = low, .high = high};
}
constexpr Rule above(const char* name, double low, double high = k_inf)
{
    return {.name = name, .kind = Kind::number, .low = low, .high = high, .above_low = true};
}
constexpr Rule factor(const char* name)
{
    return number(name, 0, 1);
}
constexpr Rule numbers(const char* name, std::size_t least, std::size_t most, double low = -k_inf, double high = k_inf)
{
    return {.name = name, .kind = Kind::numbers, .low = low, .high = high, .min_items = least, .max_items = most};
}
constexpr Rule index(const char* name, const char* target)
{
    return {.name = name, .kind = Kind::index, .target = target};
}
constexpr Rule indices(const char* name, const char* target)
{
    return {.name = name, .kind = Kind::indices, .target = target};
}
constexpr Rule object(const char* name, const Table& inner)
{
    return {.name = name, .kind = Kind::object, .inner = &inner};
}
constexpr Rule objects(const char* name, const Table& inner)
{
    return {.name = name, .kind = Kind::objects, .inner = &inner};
}
constexpr Rule code(const char* name, std::span<const int> codes)
{
    return {.name = name, .kind = Kind::code, .codes = codes};
}
constexpr Rule word(const char* name, std::span<const char* const> words)
{
    return {.name = name, .kind = Kind::word, .words = words};
}
constexpr Rule with(Rule rule, const char* other)
{
    return rule.needs = other, rule;
}

constexpr Rule or_empty(Rule rule)
{
    return rule.may_be_empty = true, rule;
}
constexpr Rule or_number(Rule rule)
{
    return rule.number_as_default = true, rule;
}

constexpr Rule or_zero(Rule rule)
{
    return rule.zero_as_absent = true, rule;
}

constexpr std::size_t k_most_extensions = 1000;   // they are compared with each other
constexpr const char* k_accessors = "/accessors";
constexpr const char* k_buffer_views = "/bufferViews";
constexpr const char* k_nodes = "/nodes";

// Accessors, buffers
constexpr int component_types[] = {5120, 5121, 5122, 5123, 5125, 5126};
constexpr int index_types[] = {5121, 5123, 5125};
constexpr const char* accessor_types[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
constexpr int view_targets[] = {34962, 34963};
constexpr Rule sparse_indices_rules[] = {need(index("bufferView", k_buffer_views)), integer("byteOffset"),
                                         need(code("componentType", index_types))};
constexpr Table sparse_indices{"sparse indices", sparse_indices_rules};
constexpr Rule sparse_values_rules[] = {need(index("bufferView", k_buffer_views)), integer("byteOffset")};
constexpr Table sparse_values{"sparse values", sparse_values_rules};
constexpr Rule sparse_rules[] = {need(integer("count", 1)), need(object("indices", sparse_indices)),
                                 need(object("values", sparse_values))};
constexpr Table sparse{"sparse", sparse_rules};
constexpr Rule accessor_rules[] = {index("bufferView", k_buffer_views),
                                   with(integer("byteOffset"), "bufferView"),
                                   need(code("componentType", component_types)),
                                   boolean("normalized"),
                                   need(integer("count", 1)),
                                   need(word("type", accessor_types)),
                                   numbers("max", 1, 16),
                                   numbers("min", 1, 16),
                                   object("sparse", sparse),
                                   text("name")};
constexpr Table accessor{"accessor", accessor_rules};
constexpr Rule buffer_rules[] = {text("uri"), need(integer("byteLength", 1)), text("name")};
constexpr Table buffer{"buffer", buffer_rules};
constexpr Rule view_rules[] = {need(index("buffer", "/buffers")), integer("byteOffset"),
                               need(integer("byteLength", 1)),    or_zero(integer("byteStride", 4, 252)),
                               code("target", view_targets),      text("name")};
constexpr Table buffer_view{"buffer view", view_rules};

// Animations
constexpr const char* paths[] = {"translation", "rotation", "scale", "weights", "pointer"};
constexpr const char* interpolations[] = {"LINEAR", "STEP", "CUBICSPLINE"};
constexpr Rule target_rules[] = {index("node", k_nodes), need(word("path", paths))};
constexpr Table channel_target{"channel target", target_rules};
constexpr Rule channel_rules[] = {need(index("sampler", nullptr)), need(object("target", channel_target))};
constexpr Table channel{"channel", channel_rules};
constexpr Rule animation_sampler_rules[] = {need(index("input", k_accessors)),
                                            or_number(word("interpolation", interpolations)),
                                            need(index("output", k_accessors))};
constexpr Table animation_sampler{"animation sampler", animation_sampler_rules};
constexpr Rule animation_rules[] = {or_empty(need(objects("channels", channel))),
                                    or_empty(need(objects("samplers", animation_sampler))), text("name")};
constexpr Table animation{"animation", animation_rules};

// Cameras
constexpr const char* camera_types[] = {"perspective", "orthographic"};
constexpr Rule orthographic_rules[] = {need(number("xmag")), need(number("ymag")), need(above("zfar", 0)),
                                       need(number("znear", 0))};
constexpr Table orthographic{"orthographic camera", orthographic_rules};
constexpr Rule perspective_rules[] = {above("aspectRatio", 0), need(above("yfov", 0)), above("zfar", 0),
                                      need(above("znear", 0))};
constexpr Table perspective{"perspective camera", perspective_rules};
constexpr Rule camera_rules[] = {object("orthographic", orthographic), object("perspective", perspective),
                                 need(word("type", camera_types)), text("name")};
constexpr Table camera{"camera", camera_rules};

// Textures, materials
constexpr const char* mime_types[] = {"image/jpeg", "image/png",        "image/webp",
                                      "image/ktx2", "image/vnd-ms.dds", "image/avif"};
constexpr int mag_filters[] = {9728, 9729};
constexpr int min_filters[] = {9728, 9729, 9984, 9985, 9986, 9987};
constexpr int wraps[] = {33071, 33648, 10497};
constexpr const char* alpha_modes[] = {"OPAQUE", "MASK", "BLEND"};
constexpr Rule image_rules[] = {text("uri"), word("mimeType", mime_types), index("bufferView", k_buffer_views),
                                text("name")};
constexpr Table image{"image", image_rules};
constexpr Rule sampler_rules[] = {code("magFilter", mag_filters), code("minFilter", min_filters), code("wrapS", wraps),
                                  code("wrapT", wraps), text("name")};
constexpr Table sampler{"sampler", sampler_rules};
constexpr Rule texture_rules[] = {index("sampler", "/samplers"), index("source", "/images"), text("name")};
constexpr Table texture{"texture", texture_rules};
constexpr Rule texture_info_rules[] = {need(index("index", "/textures")), integer("texCoord")};
constexpr Table texture_info{"texture info", texture_info_rules};
constexpr Rule normal_info_rules[] = {need(index("index", "/textures")), integer("texCoord"), number("scale")};
constexpr Table normal_info{"normal texture info", normal_info_rules};
constexpr Rule occlusion_info_rules[] = {need(index("index", "/textures")), integer("texCoord"), factor("strength")};
constexpr Table occlusion_info{"occlusion texture info", occlusion_info_rules};
constexpr Rule pbr_rules[] = {numbers("baseColorFactor", 4, 4, 0, 1), object("baseColorTexture", texture_info),
                              factor("metallicFactor"), factor("roughnessFactor"),
                              object("metallicRoughnessTexture", texture_info)};
constexpr Table pbr{"metallic-roughness", pbr_rules};
constexpr Rule material_rules[] = {object("pbrMetallicRoughness", pbr),
                                   object("normalTexture", normal_info),
                                   object("occlusionTexture", occlusion_info),
                                   object("emissiveTexture", texture_info),
                                   numbers("emissiveFactor", 3, 3, 0, 1),
                                   word("alphaMode", alpha_modes),
                                   number("alphaCutoff", 0),
                                   boolean("doubleSided"),
                                   text("name")};
constexpr Table material{"material", material_rules};

// Meshes, nodes, scenes, skins
constexpr int modes[] = {0, 1, 2, 3, 4, 5, 6};
constexpr Rule primitive_rules[] = {need({.name = "attributes", .kind = Kind::attributes, .target = k_accessors}),
                                    index("indices", k_accessors),
                                    index("material", "/materials"),
                                    code("mode", modes),
                                    {.name = "targets", .kind = Kind::attribute_lists, .target = k_accessors}};
constexpr Table primitive{"primitive", primitive_rules};
constexpr Rule mesh_rules[] = {or_empty(need(objects("primitives", primitive))), numbers("weights", 1, SIZE_MAX),
                               text("name")};
constexpr Table mesh{"mesh", mesh_rules};
constexpr Rule node_rules[] = {index("camera", "/cameras"),
                               indices("children", k_nodes),
                               with(index("skin", "/skins"), "mesh"),
                               numbers("matrix", 16, 16),
                               index("mesh", "/meshes"),
                               numbers("rotation", 4, 4, -1, 1),
                               numbers("scale", 3, 3),
                               numbers("translation", 3, 3),
                               with(numbers("weights", 1, SIZE_MAX), "mesh"),
                               text("name")};
constexpr Table node{"node", node_rules};
constexpr Rule scene_rules[] = {indices("nodes", k_nodes), text("name")};
constexpr Table scene{"scene", scene_rules};
constexpr Rule skin_rules[] = {index("inverseBindMatrices", k_accessors), index("skeleton", k_nodes),
                               need(indices("joints", k_nodes)), text("name")};
constexpr Table skin{"skin", skin_rules};

// The document
constexpr Rule asset_rules[] = {text("copyright"),
                                text("generator"),
                                need({.name = "version", .kind = Kind::version}),
                                {.name = "minVersion", .kind = Kind::version}};
constexpr Table asset{"asset", asset_rules};
constexpr Rule document_rules[] = {
    {.name = "extensionsUsed", .kind = Kind::strings, .max_items = k_most_extensions},
    with({.name = "extensionsRequired", .kind = Kind::strings, .max_items = k_most_extensions}, "extensionsUsed"),
    objects("accessors", accessor),
    objects("animations", animation),
    need(object("asset", asset)),
    objects("buffers", buffer),
    objects("bufferViews", buffer_view),
    objects("cameras", camera),
    objects("images", image),
    objects("materials", material),
    objects("meshes", mesh),
    objects("nodes", node),
    objects("samplers", sampler),
    index("scene", "/scenes"),
    objects("scenes", scene),
    objects("skins", skin),
    objects("textures", texture)};
constexpr Table document{"glTF", document_rules};

// KHR_lights_punctual
constexpr const char* light_types[] = {"directional", "point", "spot"};
constexpr double k_quarter = std::numbers::pi / 2;
constexpr Rule spot_rules[] = {number("innerConeAngle", 0, k_quarter), above("outerConeAngle", 0, k_quarter)};
constexpr Table spot{"spot", spot_rules};
constexpr Rule light_rules[] = {numbers("color", 3, 3, 0, 1), number("intensity", 0),          above("range", 0),
                                object("spot", spot),         need(word("type", light_types)), text("name")};
constexpr Table light{"light", light_rules};
constexpr Rule lights_rules[] = {or_empty(need(objects("lights", light)))};
constexpr Table lights{"lights", lights_rules};
constexpr Rule node_light_rules[] = {need(index("light", "/extensions/KHR_lights_punctual/lights"))};
constexpr Table node_light{"light of a node", node_light_rules};

// Extensions of materials
constexpr Rule transform_rules[] = {numbers("offset", 2, 2), number("rotation"), numbers("scale", 2, 2),
                                    integer("texCoord")};
constexpr Table texture_transform{"texture transform", transform_rules};
constexpr Table empty{"extension", {}};
constexpr Rule emissive_strength_rules[] = {number("emissiveStrength", 0)};
constexpr Table emissive_strength{"emissive strength", emissive_strength_rules};
constexpr Rule ior_rules[] = {number("ior", 0)};   // 0, or 1 and more: see check_schema
constexpr Table ior{"index of refraction", ior_rules};
constexpr Rule transmission_rules[] = {factor("transmissionFactor"), object("transmissionTexture", texture_info)};
constexpr Table transmission{"transmission", transmission_rules};
constexpr Rule specular_rules[] = {factor("specularFactor"), object("specularTexture", texture_info),
                                   numbers("specularColorFactor", 3, 3, 0),
                                   object("specularColorTexture", texture_info)};
constexpr Table specular{"specular", specular_rules};
constexpr Rule clearcoat_rules[] = {
    factor("clearcoatFactor"), object("clearcoatTexture", texture_info), factor("clearcoatRoughnessFactor"),
    object("clearcoatRoughnessTexture", texture_info), object("clearcoatNormalTexture", normal_info)};
constexpr Table clearcoat{"clearcoat", clearcoat_rules};
constexpr Rule sheen_rules[] = {numbers("sheenColorFactor", 3, 3, 0, 1), object("sheenColorTexture", texture_info),
                                factor("sheenRoughnessFactor"), object("sheenRoughnessTexture", texture_info)};
constexpr Table sheen{"sheen", sheen_rules};
constexpr Rule volume_rules[] = {number("thicknessFactor", 0), object("thicknessTexture", texture_info),
                                 above("attenuationDistance", 0), numbers("attenuationColor", 3, 3, 0, 1)};
constexpr Table volume{"volume", volume_rules};
constexpr Rule iridescence_rules[] = {factor("iridescenceFactor"),
                                      object("iridescenceTexture", texture_info),
                                      number("iridescenceIor", 1),
                                      number("iridescenceThicknessMinimum", 0),
                                      number("iridescenceThicknessMaximum", 0),
                                      object("iridescenceThicknessTexture", texture_info)};
constexpr Table iridescence{"iridescence", iridescence_rules};
constexpr Rule anisotropy_rules[] = {factor("anisotropyStrength"), number("anisotropyRotation"),
                                     object("anisotropyTexture", texture_info)};
constexpr Table anisotropy{"anisotropy", anisotropy_rules};
constexpr Rule dispersion_rules[] = {number("dispersion", 0)};
constexpr Table dispersion{"dispersion", dispersion_rules};
constexpr Rule glossiness_rules[] = {numbers("diffuseFactor", 4, 4, 0, 1), object("diffuseTexture", texture_info),
                                     numbers("specularFactor", 3, 3, 0, 1), factor("glossinessFactor"),
                                     object("specularGlossinessTexture", texture_info)};
constexpr Table glossiness{"specular-glossiness", glossiness_rules};

// Other extensions
constexpr Rule variant_rules[] = {need(text("name"))};
constexpr Table variant{"variant", variant_rules};
constexpr Rule variants_rules[] = {or_empty(need(objects("variants", variant)))};
constexpr Table variants{"variants", variants_rules};
constexpr Rule mapping_rules[] = {need(index("material", "/materials")),
                                  need(indices("variants", "/extensions/KHR_materials_variants/variants")),
                                  text("name")};
constexpr Table mapping{"mapping", mapping_rules};
constexpr Rule mappings_rules[] = {need(objects("mappings", mapping))};
constexpr Table mappings{"mappings", mappings_rules};
constexpr Rule visibility_rules[] = {boolean("visible")};
constexpr Table visibility{"visibility", visibility_rules};
constexpr Rule pointer_rules[] = {need(text("pointer"))};
constexpr Table animation_pointer{"animation pointer", pointer_rules};
constexpr Rule texture_source_rules[] = {index("source", "/images")};
constexpr Table texture_source{"texture source", texture_source_rules};
constexpr Rule draco_rules[] = {need(index("bufferView", k_buffer_views)),
                                need({.name = "attributes", .kind = Kind::attributes, .target = nullptr})};
constexpr Table draco{"compressed primitive", draco_rules};
constexpr Rule instancing_rules[] = {{.name = "attributes", .kind = Kind::attributes, .target = k_accessors}};
constexpr Table instancing{"instances", instancing_rules};
constexpr Rule meshopt_rules[] = {need(index("buffer", "/buffers")),
                                  integer("byteOffset"),
                                  need(integer("byteLength", 1)),
                                  need(integer("byteStride", 1, 256)),
                                  need(integer("count", 1)),
                                  need(text("mode")),
                                  text("filter")};
constexpr Table meshopt{"compressed buffer view", meshopt_rules};

constexpr ExtensionPlace places[] = {
    {"KHR_lights_punctual", &document, &lights},
    {"KHR_lights_punctual", &node, &node_light},
    {"KHR_texture_transform", &texture_info, &texture_transform},
    {"KHR_texture_transform", &normal_info, &texture_transform},
    {"KHR_texture_transform", &occlusion_info, &texture_transform},
    {"KHR_materials_unlit", &material, &empty},
    {"KHR_materials_emissive_strength", &material, &emissive_strength},
    {"KHR_materials_ior", &material, &ior},
    {"KHR_materials_transmission", &material, &transmission},
    {"KHR_materials_specular", &material, &specular},
    {"KHR_materials_clearcoat", &material, &clearcoat},
    {"KHR_materials_sheen", &material, &sheen},
    {"KHR_materials_volume", &material, &volume},
    {"KHR_materials_iridescence", &material, &iridescence},
    {"KHR_materials_anisotropy", &material, &anisotropy},
    {"KHR_materials_dispersion", &material, &dispersion},
    {"KHR_materials_pbrSpecularGlossiness", &material, &glossiness},
    {"KHR_materials_variants", &document, &variants},
    {"KHR_materials_variants", &primitive, &mappings},
    {"KHR_node_visibility", &node, &visibility},
    {"KHR_animation_pointer", &channel_target, &animation_pointer},
    {"EXT_texture_webp", &texture, &texture_source},
    {"KHR_texture_basisu", &texture, &texture_source},
    {"KHR_draco_mesh_compression", &primitive, &draco},
    {"EXT_mesh_gpu_instancing", &node, &instancing},
    {"EXT_meshopt_compression", &buffer_view, &meshopt},
    {"EXT_meshopt_compression", &buffer, &empty},
};

}   // namespace

const Table& document_table()
{
    return document;
}
std::span<const ExtensionPlace> extension_places()
{
    return places;
}

}   // namespace gnomon::io::gltf
