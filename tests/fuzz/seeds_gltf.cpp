// SPDX-License-Identifier: Apache-2.0
// glTF documents with all features that the importer reads. They refer to t.png and data.bin, which targets.cpp puts
// into the same folder.
#include <fmt/format.h>

#include <cstring>
#include <string>

#include "fuzz/seeds.h"

namespace gnomon::fuzz {

namespace {

// Builds a document: all data goes into one buffer, with a view and an accessor for each piece.
class Document {
 public:
    template <class T>
    int accessor(const std::vector<T>& values, const char* type, int component, std::size_t count,
                 const std::string& more = "")
    {
        const int in_view = view(values);
        accessors_ += fmt::format(R"({}{{"bufferView":{},"type":"{}","componentType":{},"count":{}{}}})",
                                  accessors_.empty() ? "" : ",", in_view, type, component, count, more);
        return accessor_count_++;
    }
    template <class T>
    int view(const std::vector<T>& values)
    {
        bytes_.resize((bytes_.size() + 3) / 4 * 4);
        const std::size_t begin = bytes_.size(), size = values.size() * sizeof(T);
        bytes_.resize(begin + size);
        std::memcpy(&bytes_[begin], values.data(), size);
        views_ +=
            fmt::format(R"({}{{"buffer":0,"byteOffset":{},"byteLength":{}}})", views_.empty() ? "" : ",", begin, size);
        return view_count_++;
    }
    int floats(const std::vector<float>& values, const char* type, std::size_t count, const std::string& more = "")
    {
        return accessor(values, type, 5126, count, more);
    }
    /// An accessor with the given JSON.
    int raw_accessor(const std::string& json)
    {
        accessors_ += "," + json;
        return accessor_count_++;
    }

    std::string json(const std::string& rest, const std::string& buffer_uri) const
    {
        const std::string uri = buffer_uri.empty() ? "" : fmt::format(R"(,"uri":"{}")", buffer_uri);
        return fmt::format(R"({{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}{}}}],)"
                           R"("bufferViews":[{}],"accessors":[{}],{}}})",
                           bytes_.size(), uri, views_, accessors_, rest);
    }
    Bytes as_gltf(const std::string& rest) const
    {
        const std::string text = json(rest, "data:application/octet-stream;base64," + base64());
        return {text.begin(), text.end()};
    }
    Bytes as_glb(const std::string& rest) const
    {
        std::string text = json(rest, "");
        text.resize((text.size() + 3) / 4 * 4, ' ');
        Bytes data = bytes_;
        data.resize((data.size() + 3) / 4 * 4);
        Bytes glb;
        const auto word = [&](std::size_t v) {
            for (int i = 0; i < 4; ++i) glb.push_back(static_cast<std::uint8_t>(v >> (8 * i)));
        };
        word(0x46546c67), word(2), word(28 + text.size() + data.size());
        word(text.size()), word(0x4e4f534a);
        glb.insert(glb.end(), text.begin(), text.end());
        word(data.size()), word(0x004e4942);
        glb.insert(glb.end(), data.begin(), data.end());
        return glb;
    }

 private:
    std::string base64() const
    {
        constexpr const char* k_digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string text;
        for (std::size_t i = 0; i < bytes_.size(); i += 3) {
            std::uint32_t three = 0;
            for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes_.size() ? bytes_[i + k] : 0u);
            for (std::size_t k = 0; k < 4; ++k)
                text += i + k > bytes_.size() ? '=' : k_digits[three >> (18 - 6 * k) & 63];
        }
        return text;
    }

    Bytes bytes_;
    std::string views_, accessors_;
    int view_count_ = 0, accessor_count_ = 0;
};

const std::vector<float> k_square = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
constexpr const char* k_square_bounds = R"(,"min":[0,0,0],"max":[1,1,0])";

// Meshes with every kind of attribute, a skin, morph targets, animations of all paths and interpolations.
std::pair<Document, std::string> moving()
{
    Document d;
    const int position = d.floats(k_square, "VEC3", 4, k_square_bounds);
    const int normal = d.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", 4);
    const int tangent = d.floats({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, "VEC4", 4);
    const int texcoord = d.floats({0, 0, 1, 0, 1, 1, 0, 1}, "VEC2", 4);
    const int color = d.accessor<std::uint8_t>(Bytes(16, 200), "VEC4", 5121, 4, R"(,"normalized":true)");
    const int joints = d.accessor<std::uint8_t>({0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 5121, 4);
    const int weights = d.floats({.5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    const int bytes = d.accessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5121, 6);
    const int shorts = d.accessor<std::uint16_t>({0, 1, 2, 3}, "SCALAR", 5123, 4);
    const int words = d.accessor<std::uint32_t>({1, 2, 3}, "SCALAR", 5125, 3);
    const int delta = d.floats({0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, .5f}, "VEC3", 4, R"(,"min":[0,0,0],"max":[0,0,1])");
    std::vector<float> identity(32, 0);
    for (std::size_t i = 0; i < 32; i += i % 16 == 15 ? 1 : 5) identity[i] = 1;
    const int bind = d.floats(identity, "MAT4", 2);
    const int times = d.floats({0, 1, 2}, "SCALAR", 3, R"(,"min":[0],"max":[2])");
    const int moves = d.floats({0, 0, 0, 1, 0, 0, 1, 1, 0}, "VEC3", 3);
    const int turns = d.floats({0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0}, "VEC4", 3);
    const int cubic = d.floats(std::vector<float>(27, .5f), "VEC3", 9);
    const int morphs = d.floats({0, .5f, 1}, "SCALAR", 3);
    const int sparse_index = d.view<std::uint16_t>({1, 3}), sparse_value = d.view<float>({2, 0, 0, 0, 2, 0});
    const int sparse = d.raw_accessor(
        fmt::format(R"({{"componentType":5126,"type":"VEC3","count":4,"min":[0,0,0],"max":[2,2,0],"sparse":{{)"
                    R"("count":2,"indices":{{"bufferView":{},"componentType":5123}},"values":{{"bufferView":{}}}}}}})",
                    sparse_index, sparse_value));

    const std::string all = fmt::format(
        R"({{"attributes":{{"POSITION":{},"NORMAL":{},"TANGENT":{},"TEXCOORD_0":{},"COLOR_0":{},"JOINTS_0":{},)"
        R"("WEIGHTS_0":{}}},"indices":{},"targets":[{{"POSITION":{}}}]}})",
        position, normal, tangent, texcoord, color, joints, weights, bytes, delta);
    const auto plain = [&](int at, int indices, int mode) {
        return fmt::format(R"({{"attributes":{{"POSITION":{}}},"indices":{},"mode":{}}})", at, indices, mode);
    };
    const auto sampler = [&](int values, const char* how) {
        return fmt::format(R"({{"input":{},"output":{},"interpolation":"{}"}})", times, values, how);
    };
    std::string rest = fmt::format(
        R"("meshes":[{{"primitives":[{}],"weights":[0.25]}},{{"primitives":[{},{},{},{}]}}],)", all,
        plain(position, shorts, 5), plain(position, shorts, 6), plain(sparse, words, 4), plain(position, shorts, 1));
    rest += fmt::format(R"("skins":[{{"inverseBindMatrices":{},"joints":[1,2],"skeleton":1}}],)", bind);
    rest +=
        R"("nodes":[{"mesh":0,"skin":0},{"children":[2],"translation":[0,1,0],"rotation":[0,0,0,1],"scale":[1,2,1]},)"
        R"({"name":"tip"},{"mesh":1,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,1,1]},{"camera":0},)"
        R"({"mesh":1,"camera":1,"children":[4]}],)"
        R"("cameras":[{"type":"perspective","perspective":{"yfov":0.7,"znear":0.1,"zfar":10,"aspectRatio":1.5}},)"
        R"({"type":"orthographic","orthographic":{"xmag":1,"ymag":1,"znear":0,"zfar":9}}],)"
        R"("scenes":[{"nodes":[0,1,3,5]}],"scene":0,)";
    rest += fmt::format(R"("animations":[{{"samplers":[{},{},{},{}],"channels":[)", sampler(moves, "LINEAR"),
                        sampler(turns, "STEP"), sampler(cubic, "CUBICSPLINE"), sampler(morphs, "LINEAR"));
    rest +=
        R"({"sampler":0,"target":{"node":1,"path":"translation"}},{"sampler":1,"target":{"node":1,"path":"rotation"}},)"
        R"({"sampler":2,"target":{"node":5,"path":"scale"}},{"sampler":3,"target":{"node":0,"path":"weights"}}]}])";
    return {d, rest};
}

// Materials, images and lights, with every extension that is read.
std::pair<Document, std::string> shaded()
{
    Document d;
    const int position = d.floats(k_square, "VEC3", 4, k_square_bounds);
    const int texcoord =
        d.accessor<std::uint16_t>({0, 0, 65535, 0, 65535, 65535, 0, 65535}, "VEC2", 5123, 4, R"(,"normalized":true)");
    const int image = d.view(png_seeds()[1]);
    const std::string info = R"({"index":0,"texCoord":0,"extensions":{"KHR_texture_transform":{"offset":[0.5,0],)"
                             R"("rotation":1,"scale":[2,2],"texCoord":0}}})";
    std::string rest = fmt::format(
        R"("images":[{{"uri":"t.png"}},{{"bufferView":{},"mimeType":"image/png"}}],"samplers":[{{"magFilter":9728,)"
        R"("minFilter":9987,"wrapS":33071,"wrapT":33648}}],"textures":[{{"source":0,"sampler":0}},{{"source":1}}],)",
        image);
    rest += R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.5,0.5],"metallicFactor":0.5,)"
            R"("roughnessFactor":0.5,"baseColorTexture":)" +
            info +
            R"(,"metallicRoughnessTexture":{"index":1}},"normalTexture":{"index":0,"scale":0.5},)"
            R"("occlusionTexture":{"index":1,"strength":0.5},"emissiveTexture":{"index":0},"emissiveFactor":[1,1,1],)"
            R"("alphaMode":"MASK","alphaCutoff":0.3,"doubleSided":true,"extensions":{"KHR_materials_ior":{"ior":1.4},)"
            R"("KHR_materials_emissive_strength":{"emissiveStrength":3},"KHR_materials_transmission":)"
            R"({"transmissionFactor":0.5},"KHR_materials_specular":{"specularFactor":0.5},)"
            R"("KHR_materials_clearcoat":{"clearcoatFactor":1},"KHR_materials_volume":{"thicknessFactor":1}}},)"
            R"({"alphaMode":"BLEND","extensions":{"KHR_materials_unlit":{}}}],)";
    rest += fmt::format(R"("meshes":[{{"name":"a","primitives":[{{"attributes":{{"POSITION":{0},"TEXCOORD_0":{1}}},)"
                        R"("mode":6,"material":0}},{{"attributes":{{"POSITION":{0},"TEXCOORD_0":{1}}},"mode":5,)"
                        R"("material":1}}]}}],)",
                        position, texcoord);
    rest += R"("extensionsUsed":["KHR_texture_transform","KHR_materials_ior","KHR_materials_emissive_strength",)"
            R"("KHR_materials_transmission","KHR_materials_specular","KHR_materials_clearcoat","KHR_materials_volume",)"
            R"("KHR_materials_unlit","KHR_lights_punctual"],"extensionsRequired":["KHR_lights_punctual"],)"
            R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":10,"range":5,)"
            R"("color":[1,0.5,0]},{"type":"spot","spot":{"innerConeAngle":0.2,"outerConeAngle":0.5}},)"
            R"({"type":"directional"}]}},"nodes":[{"mesh":0},{"extensions":{"KHR_lights_punctual":{"light":0}}},)"
            R"({"extensions":{"KHR_lights_punctual":{"light":1}}},{"extensions":{"KHR_lights_punctual":{"light":2}}}])";
    return {d, rest};
}

}   // namespace

std::vector<Bytes> gltf_seeds()
{
    const auto [d, animated] = moving();
    const auto [e, lit] = shaded();
    const std::string beside =
        R"({"asset":{"version":"2.0","minVersion":"2.0"},"buffers":[{"byteLength":48,"uri":"data.bin"}],"bufferViews":)"
        R"([{"buffer":0,"byteLength":48,"byteStride":16,"target":34962}],"accessors":[{"bufferView":0,"byteOffset":4,)"
        R"("componentType":5126,"type":"VEC3","count":3,"min":[0.75,0.75,0.75],"max":[0.75,0.75,0.75]}],"meshes":[)"
        R"({"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"extras":{}})";
    return {d.as_gltf(animated), e.as_gltf(lit), Bytes(beside.begin(), beside.end())};
}

std::vector<Bytes> glb_seeds()
{
    const auto [d, animated] = moving();
    const auto [e, lit] = shaded();
    return {d.as_glb(animated), e.as_glb(lit)};
}

}   // namespace gnomon::fuzz
