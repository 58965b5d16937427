// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "hostile/made_scenes.h"

namespace gnomon::test {

namespace {
using Json = nlohmann::json;

// The offset of each piece of data in the only buffer, in floats.
struct Sound {
    Json json;
    std::vector<float> data;
    std::map<std::string, std::size_t> begin;
};

void add_accessor(Sound& s, const char* name, const char* type, const std::vector<float>& values, std::size_t width,
                  bool bounds = false)
{
    const std::size_t begin = s.data.size(), count = values.size() / width;
    s.begin[name] = begin;
    s.data.insert(s.data.end(), values.begin(), values.end());
    Json view{{"buffer", 0}, {"byteOffset", 4 * begin}, {"byteLength", 4 * values.size()}};
    Json accessor{
        {"bufferView", s.json["bufferViews"].size()}, {"componentType", 5126}, {"type", type}, {"count", count}};
    if (bounds)
        for (std::size_t k = 0; k < width; ++k) {
            float low = values[k], high = values[k];
            for (std::size_t i = k; i < values.size(); i += width)
                low = std::min(low, values[i]), high = std::max(high, values[i]);
            accessor["min"].push_back(low), accessor["max"].push_back(high);
        }
    s.json["bufferViews"].push_back(view);
    s.json["accessors"].push_back(accessor);
}

// A floor and a square that moves, bends and morphs above it; a camera, three lights, a texture.
Sound sound()
{
    Sound s;
    s.json = Json::parse(R"({"asset":{"version":"2.0"},"bufferViews":[],"accessors":[],"scene":0,
        "scenes":[{"nodes":[0,1,2,3,4,5,6,7]}],
        "extensionsUsed":["KHR_lights_punctual","KHR_texture_transform","KHR_materials_emissive_strength","KHR_materials_ior",
                          "KHR_materials_transmission"],
        "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":20,"range":50,"color":[1,1,1]},
            {"type":"spot","intensity":20,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.7}},
            {"type":"directional","intensity":1}]}},
        "images":[{"uri":"t.png"}],"samplers":[{"magFilter":9729,"minFilter":9987,"wrapS":10497,"wrapT":33648}],
        "textures":[{"source":0,"sampler":0}],
        "materials":[{"pbrMetallicRoughness":{"baseColorFactor":[0.8,0.8,0.8,1],"metallicFactor":0.1,"roughnessFactor":0.6,
            "baseColorTexture":{"index":0,"texCoord":0,"extensions":{"KHR_texture_transform":{"offset":[0.1,0],"rotation":0.3,
            "scale":[2,2]}}}},"normalTexture":{"index":0,"scale":1},"emissiveFactor":[0.1,0,0],"alphaMode":"MASK",
            "alphaCutoff":0.5,"doubleSided":true,"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":2},
            "KHR_materials_ior":{"ior":1.5},"KHR_materials_transmission":{"transmissionFactor":0.2}}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":10,"material":0}]},
            {"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2,"JOINTS_0":11,"WEIGHTS_0":3},"indices":10,
             "material":0,"targets":[{"POSITION":4}]}],"weights":[0.5]}],
        "skins":[{"joints":[5],"inverseBindMatrices":5}],
        "nodes":[{"mesh":0,"scale":[4,4,4],"translation":[0,-1,0]},{"mesh":1,"skin":0},{"camera":0,"translation":[0,0.5,5]},
            {"translation":[1,3,2],"extensions":{"KHR_lights_punctual":{"light":0}}},
            {"translation":[0,4,0],"rotation":[-0.7071068,0,0,0.7071068],"extensions":{"KHR_lights_punctual":{"light":1}}},
            {"children":[8]},{"extensions":{"KHR_lights_punctual":{"light":2}}},{"mesh":0,"translation":[1,0,0]},{}],
        "cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1,"zfar":100,"aspectRatio":1.33}}],
        "animations":[{"samplers":[{"input":6,"output":7},{"input":6,"output":8},{"input":6,"output":9}],"channels":[
            {"sampler":0,"target":{"node":7,"path":"translation"}},{"sampler":1,"target":{"node":5,"path":"rotation"}},
            {"sampler":2,"target":{"node":1,"path":"weights"}}]}]})");
    add_accessor(s, "positions", "VEC3", {-1, 0, -1, 1, 0, -1, 1, .2f, 1, -1, 0, 1}, 3, true);
    add_accessor(s, "normals", "VEC3", {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, 3);
    add_accessor(s, "texture coordinates", "VEC2", {0, 0, 1, 0, 1, 1, 0, 1}, 2);
    add_accessor(s, "weights", "VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 4);
    add_accessor(s, "morph target", "VEC3", {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, .5f, 0}, 3, true);
    add_accessor(s, "bind matrix", "MAT4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 16);
    add_accessor(s, "times", "SCALAR", {0, 1, 2}, 1, true);
    add_accessor(s, "moves", "VEC3", {1, 0, 0, 1, 1, 0, 0, 1, 1}, 3);
    add_accessor(s, "turns", "VEC4", {0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0}, 4);
    add_accessor(s, "morph weights", "SCALAR", {0, 1, .5f}, 1);
    // Indices and joints, as bytes at the positions of floats.
    float bytes[2 + 4];
    const std::uint8_t indices[8] = {0, 2, 1, 0, 3, 2, 0, 0}, joints[16] = {};
    std::memcpy(bytes, indices, 8);
    std::memcpy(bytes + 2, joints, 16);
    const std::size_t begin = s.data.size();
    s.data.insert(s.data.end(), bytes, bytes + 6);
    s.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 4 * begin}, {"byteLength", 6}});
    s.json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 4 * begin + 8}, {"byteLength", 16}});
    s.json["accessors"].push_back({{"bufferView", 10}, {"componentType", 5121}, {"type", "SCALAR"}, {"count", 6}});
    s.json["accessors"].push_back({{"bufferView", 11}, {"componentType", 5121}, {"type", "VEC4"}, {"count", 4}});
    s.json["buffers"] = {{{"byteLength", 4 * s.data.size()}, {"uri", "data.bin"}}};
    return s;
}

using Files = std::map<std::string, std::string>;

Files files_of(const std::string& json, const std::vector<float>& data)
{
    std::string bytes(4 * data.size(), '\0');
    std::memcpy(bytes.data(), data.data(), bytes.size());
    return {{"scene.gltf", json}, {"data.bin", bytes}, {"t.png", made_png(8, 8, true)}};
}

class Maker {
 public:
    std::vector<MadeScene> scenes;

    void add(const std::string& name, Expected expected, const std::function<void(Sound&)>& change)
    {
        scenes.push_back({"gltf/" + name, expected, "scene.gltf", [change] {
                              Sound s = sound();
                              change(s);
                              return files_of(s.json.dump(), s.data);
                          }});
    }
    /// The value is JSON text, which need not be valid itself.
    void set(const std::string& pointer, const std::string& value, Expected expected = Expected::either)
    {
        scenes.push_back(
            {fmt::format("gltf{} = {}", pointer, value.substr(0, 24)), expected, "scene.gltf", [pointer, value] {
                 Sound s = sound();
                 s.json[Json::json_pointer(pointer)] = "@@";
                 std::string text = s.json.dump();
                 text.replace(text.find("\"@@\""), 4, value);
                 return files_of(text, s.data);
             }});
    }
};

// Replaces every number of the document by every kind of bad number. The importer's own tests decide which are valid;
// here each loads or is refused.
void add_numbers(Maker& m)
{
    const char* const k_values[] = {"-1",
                                    "0",
                                    "0.5",
                                    "1e-300",
                                    "1e38",
                                    "1e300",
                                    "1e999",
                                    "2147483648",
                                    "4294967295",
                                    "9007199254740993",
                                    "18446744073709551616",
                                    "null",
                                    "\"1\"",
                                    "[]",
                                    "{}",
                                    "NaN"};
    std::size_t turn = 0;
    for (const char* pointer :
         {"/accessors/0/count",
          "/accessors/0/byteOffset",
          "/accessors/0/bufferView",
          "/accessors/0/componentType",
          "/accessors/6/count",
          "/accessors/10/count",
          "/accessors/11/componentType",
          "/accessors/0/min/0",
          "/accessors/0/max/2",
          "/bufferViews/0/byteOffset",
          "/bufferViews/0/byteLength",
          "/bufferViews/0/byteStride",
          "/bufferViews/0/buffer",
          "/buffers/0/byteLength",
          "/scene",
          "/scenes/0/nodes/0",
          "/nodes/0/mesh",
          "/nodes/1/skin",
          "/nodes/2/camera",
          "/nodes/5/children/0",
          "/nodes/0/scale/1",
          "/nodes/2/translation/2",
          "/nodes/4/rotation/3",
          "/meshes/0/primitives/0/attributes/POSITION",
          "/meshes/0/primitives/0/attributes/NORMAL",
          "/meshes/0/primitives/0/indices",
          "/meshes/0/primitives/0/material",
          "/meshes/0/primitives/0/mode",
          "/meshes/1/weights/0",
          "/skins/0/joints/0",
          "/skins/0/inverseBindMatrices",
          "/cameras/0/perspective/yfov",
          "/cameras/0/perspective/znear",
          "/cameras/0/perspective/zfar",
          "/cameras/0/perspective/aspectRatio",
          "/animations/0/channels/0/sampler",
          "/animations/0/channels/0/target/node",
          "/animations/0/samplers/0/input",
          "/animations/0/samplers/0/output",
          "/materials/0/pbrMetallicRoughness/baseColorFactor/1",
          "/materials/0/pbrMetallicRoughness/metallicFactor",
          "/materials/0/pbrMetallicRoughness/roughnessFactor",
          "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
          "/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord",
          "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/scale/0",
          "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/rotation",
          "/materials/0/normalTexture/scale",
          "/materials/0/emissiveFactor/0",
          "/materials/0/alphaCutoff",
          "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength",
          "/materials/0/extensions/KHR_materials_ior/ior",
          "/materials/0/extensions/KHR_materials_transmission/transmissionFactor",
          "/textures/0/source",
          "/textures/0/sampler",
          "/samplers/0/wrapS",
          "/samplers/0/minFilter",
          "/extensions/KHR_lights_punctual/lights/0/intensity",
          "/extensions/KHR_lights_punctual/lights/0/range",
          "/extensions/KHR_lights_punctual/lights/0/color/0",
          "/extensions/KHR_lights_punctual/lights/1/spot/outerConeAngle",
          "/extensions/KHR_lights_punctual/lights/1/spot/innerConeAngle",
          "/extensions/KHR_lights_punctual/lights/2/intensity",
          "/nodes/3/extensions/KHR_lights_punctual/light"})
        for (int k = 0; k < 5; ++k) m.set(pointer, k_values[turn++ % std::size(k_values)]);
}

// NaN, infinite and extreme floats in the buffer.
void add_floats(Maker& m)
{
    const std::pair<const char*, float> values[] = {{"NaN", std::numeric_limits<float>::quiet_NaN()},
                                                    {"infinity", std::numeric_limits<float>::infinity()},
                                                    {"-infinity", -std::numeric_limits<float>::infinity()},
                                                    {"3e38", 3e38f},
                                                    {"-1e20", -1e20f},
                                                    {"1e-40", 1e-40f},
                                                    {"0", 0}};
    for (const auto& [piece, at] : sound().begin)
        for (const auto& [word, value] : values)
            for (const bool all : {false, true}) {
                const std::string name = fmt::format("{} {} {}", piece, all ? "all" : "one", word);
                // Of vertices, what is not finite is taken as zero, positions apart.
                const bool repaired = piece == "normals" || piece == "tangents" || piece == "colours" ||
                                      piece == "texture coordinates" || piece == "weights";
                const Expected expected = std::isfinite(value) ? Expected::either
                                          : repaired           ? Expected::image
                                                               : Expected::refused;
                m.add(name, expected, [piece = piece, value = value, all](Sound& s) {
                    std::size_t end = s.data.size() - 6;   // without indices and joints
                    for (const auto& [other, begin] : s.begin)
                        if (begin > s.begin[piece]) end = std::min(end, begin);
                    for (std::size_t i = s.begin[piece]; i < (all ? end : s.begin[piece] + 1); ++i) s.data[i] = value;
                });
            }
}
}   // namespace

// LONG: a table of scenes, one a statement.
std::vector<MadeScene> made_gltf_scenes()
{
    Maker m;
    m.add("sound", Expected::image, [](Sound&) {});
    add_numbers(m);
    add_floats(m);

    // Graphs.
    const Expected refused = Expected::refused, image = Expected::image, either = Expected::either;
    m.add("a node that is its own child", refused, [](Sound& s) { s.json["nodes"][8]["children"] = {8}; });
    m.add("a cycle of two nodes", refused, [](Sound& s) { s.json["nodes"][8]["children"] = {5}; });
    m.add("a root of the scene that is a child", image, [](Sound& s) { s.json["nodes"][8]["children"] = {0}; });
    m.add("a node with two parents", refused, [](Sound& s) { s.json["nodes"][0]["children"] = {8}; });
    m.add("a child of a number beyond", refused, [](Sound& s) { s.json["nodes"][0]["children"] = {4000000000u}; });
    m.add("a joint below its own mesh", either, [](Sound& s) {
        s.json["nodes"][5].erase("children");
        s.json["nodes"][1]["children"] = {8};
        s.json["skins"][0]["joints"] = {8};
    });
    for (const int depth : {100, 10'000, 100'000})
        for (const double scale : {1.0, 2.0, 0.5})
            m.add(fmt::format("a chain of {} nodes, each scaled by {}", depth, scale), either,
                  [depth, scale](Sound& s) {
                      Json& nodes = s.json["nodes"];
                      nodes[8]["children"] = {9};
                      for (int i = 9; i < 9 + depth; ++i)
                          nodes.push_back({{"children", {i + 1}}, {"scale", {scale, scale, scale}}});
                      nodes.push_back({{"mesh", 0}});
                  });
    for (const int count : {1'000, 20'000})
        m.add(fmt::format("{} instances of one mesh in one place", count), either, [count](Sound& s) {
            Json& nodes = s.json["nodes"];
            for (int i = 0; i < count; ++i) {
                s.json["scenes"][0]["nodes"].push_back(nodes.size());
                nodes.push_back({{"mesh", 0}});
            }
        });
    for (const int count : {1'000, 100'000, 1'000'000})
        m.add(fmt::format("{} lights", count), either, [count](Sound& s) {
            Json& nodes = s.json["nodes"];
            for (int i = 0; i < count; ++i) {
                s.json["scenes"][0]["nodes"].push_back(nodes.size());
                nodes.push_back({{"extensions", {{"KHR_lights_punctual", {{"light", i % 3}}}}}});
            }
        });
    m.add("200 cameras in one place", image, [](Sound& s) {
        for (int i = 0; i < 200; ++i) {
            s.json["scenes"][0]["nodes"].push_back(s.json["nodes"].size());
            s.json["nodes"].push_back({{"camera", 0}});
        }
    });

    // Sizes of the scene.
    for (const char* size : {"0", "1e-30", "1e-6", "1e-4", "1e4", "1e6", "1e12", "1e30"})
        m.add(fmt::format("a world scaled by {}", size), either, [size](Sound& s) {
            const double k = std::stod(size);
            s.json["nodes"].push_back({{"scale", {k, k, k}}, {"children", {0, 1, 2, 3, 4, 5, 6, 7}}});
            s.json["scenes"][0]["nodes"] = {9};
        });
    for (const char* size : {"1e3", "1e6", "1e9", "1e30"})
        m.add(fmt::format("a world {} from the origin", size), either, [size](Sound& s) {
            s.json["nodes"].push_back(
                {{"translation", {std::stod(size), 0, 0}}, {"children", {0, 1, 2, 3, 4, 5, 6, 7}}});
            s.json["scenes"][0]["nodes"] = {9};
        });
    m.add("a speck and a planet", either, [](Sound& s) {
        s.json["nodes"][0]["scale"] = {1e7, 1e7, 1e7};
        s.json["nodes"][7]["scale"] = {1e-7, 1e-7, 1e-7};
    });
    for (const int axis : {0, 1, 2})
        m.add(fmt::format("a mesh flat in axis {}", axis), image, [axis](Sound& s) {
            for (std::size_t i = 0; i < 4; ++i)
                s.data[s.begin["positions"] + 3 * i + static_cast<std::size_t>(axis)] = 0;
            s.json["accessors"][0]["min"][static_cast<std::size_t>(axis)] = 0;
            s.json["accessors"][0]["max"][static_cast<std::size_t>(axis)] = 0;
        });
    m.add("every triangle a point", image, [](Sound& s) {
        s.json["nodes"][0]["scale"] = s.json["nodes"][7]["scale"] = {0, 0, 0};
    });
    m.add("turned inside out", image, [](Sound& s) { s.json["nodes"][0]["scale"] = {-4, 4, 4}; });
    m.add("a camera in the floor", image, [](Sound& s) { s.json["nodes"][2]["translation"] = {0.1, -1, 0.1}; });
    m.add("a camera on a vertex", image, [](Sound& s) { s.json["nodes"][2]["translation"] = {-4, -1, -4}; });
    m.add("a light in the floor", image, [](Sound& s) { s.json["nodes"][3]["translation"] = {0, -0.6, 0}; });
    m.add("a light on a vertex", image, [](Sound& s) { s.json["nodes"][3]["translation"] = {-4, -1, -4}; });
    m.add("a camera flattened", either, [](Sound& s) { s.json["nodes"][2]["scale"] = {1, 1, 0}; });
    m.add("a light flattened", either, [](Sound& s) { s.json["nodes"][4]["scale"] = {0, 0, 0}; });
    m.add("nothing but a camera", image, [](Sound& s) { s.json["scenes"][0]["nodes"] = {2}; });
    m.add("nothing at all", image, [](Sound& s) { s.json["scenes"][0].erase("nodes"); });
    m.add("a clip of 1e9 s", either, [](Sound& s) {
        s.data[s.begin["times"] + 2] = 1e9f;
        s.json["accessors"][6]["max"] = {1e9};
    });
    m.add("keys at one time", image, [](Sound& s) { s.data[s.begin["times"] + 1] = 0; });

    // Images.
    const auto image_scene = [&](const std::string& name, Expected expected,
                                 const std::function<std::string()>& bytes) {
        m.scenes.push_back({"gltf/" + name, expected, "scene.gltf", [bytes] {
                                Sound s = sound();
                                Files files = files_of(s.json.dump(), s.data);
                                files["t.png"] = bytes();
                                return files;
                            }});
    };
    image_scene("an image of 60000 x 60000 in a kilobyte", refused, [] { return made_png(60000, 60000, false); });
    image_scene("an image of 2147483647 x 1", refused, [] { return made_png(2147483647, 1, false); });
    image_scene("an image of 0 x 0", refused, [] { return made_png(0, 0, false); });
    image_scene("an image of 1 x 16384", either, [] { return made_png(1, 16384, true); });
    image_scene("an image of 5000 x 5000 of nothing", either, [] { return made_png(5000, 5000, true); });
    image_scene("an image that is cut off", refused, [] { return made_png(64, 64, true).substr(0, 60); });
    // An unknown format: a warning, and the image is omitted.
    image_scene("an image that is a text", either, [] { return std::string("hello"); });
    image_scene("an empty image", either, [] { return std::string(); });

    // File names.
    for (const char* place : {"/buffers/0/uri", "/images/0/uri"})
        for (const char* uri : {"",
                                ".",
                                "..",
                                "/",
                                "/etc/passwd",
                                "../../../../etc/passwd",
                                "file:///etc/passwd",
                                "%2e%2e/%2e%2e/etc/passwd",
                                "..%2fscene.gltf",
                                "http://127.0.0.1:9/a.bin",
                                "//server/share/a",
                                "C:\\\\a.bin",
                                "a\\\\..\\\\b",
                                "data:",
                                "data:,",
                                "data:;base64,",
                                "data:;base64,!!!!",
                                "data:application/octet-stream;base64,AAAA",
                                "data:image/png;base64,iVBORw0KGgo=",
                                "scene.gltf",
                                "./././data.bin",
                                "data.bin?x=1",
                                "data.bin#x",
                                "a%00b",
                                "%",
                                "%zz",
                                "\\u0000",
                                "\\u001b[31m",
                                "con",
                                "/dev/zero",
                                "/dev/stdin",
                                "/proc/self/mem",
                                "~/.bashrc",
                                "$(reboot)",
                                "`id`",
                                "*",
                                "data.bin/",
                                "dat\\u0430.bin"})
            m.set(place, fmt::format("\"{}\"", uri));
    m.set("/buffers/0/uri", fmt::format("\"{}\"", std::string(100'000, 'a')), refused);
    m.set("/buffers/0/uri", fmt::format("\"{}data.bin\"", [] {
              std::string deep;
              for (int i = 0; i < 5'000; ++i) deep += "./";
              return deep;
          }()));
    return std::move(m.scenes);
}

}   // namespace gnomon::test
