// SPDX-License-Identifier: Apache-2.0
// Imports small glTF documents that are made here.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "gltf_document.h"
#include "gnomon/error.h"
#include "io/image/image_file.h"
#include "io/load.h"
#include "scene/state.h"
#include "support.h"

namespace gnomon {
namespace {

using test::Document;
using test::one_mesh;

const std::vector<float> k_square = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

TEST(GltfImport, ReadsIndicesOfEachWidth)
{
    Document d;
    const int p = d.positions(k_square);
    const int a = d.accessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5121, 1);
    const int b = d.accessor<std::uint16_t>({0, 1, 2}, "SCALAR", 5123, 1);
    const int c = d.accessor<std::uint32_t>({1, 2, 3}, "SCALAR", 5125, 1);
    std::string primitives;
    for (const int i : {a, b, c})
        primitives += fmt::format(R"({}{{"attributes":{{"POSITION":{}}},"indices":{}}})", i == a ? "" : ",", p, i);
    const scene::Scene s = d.load(one_mesh(primitives));
    ASSERT_EQ(s.meshes.size(), 1u);
    ASSERT_EQ(s.meshes[0].triangles.size(), 4u);
    EXPECT_EQ(s.meshes[0].triangles[1], glm::uvec3(0, 2, 3));
    EXPECT_EQ(s.meshes[0].triangles[3], glm::uvec3(9, 10, 11));
    EXPECT_EQ(s.meshes[0].positions[11], glm::vec3(0, 1, 0));
    EXPECT_EQ(s.meshes[0].parts.size(), 3u);
    EXPECT_TRUE(s.meshes[0].normals.empty());
    // No material: the default of the specification.
    EXPECT_EQ(s.materials.at(0).metallic, 1);
    EXPECT_EQ(s.materials.at(0).base_color, glm::vec3(1));
}

TEST(GltfImport, StripsAndFansKeepTheirWinding)
{
    Document d;
    const int strip = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
    const int fan = d.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    const scene::Scene s = d.load(one_mesh(fmt::format(
        R"({{"attributes":{{"POSITION":{}}},"mode":5}},{{"attributes":{{"POSITION":{}}},"mode":6}},{{"attributes":{{"POSITION":{}}},"mode":1}})",
        strip, fan, fan)));
    const scene::Mesh& m = s.meshes.at(0);
    ASSERT_EQ(m.triangles.size(), 5u);
    for (const glm::uvec3& t : m.triangles)
        EXPECT_GT(glm::cross(m.positions[t.y] - m.positions[t.x], m.positions[t.z] - m.positions[t.x]).z, 0);
    EXPECT_EQ(s.warnings.size(), 1u);   // lines
}

TEST(GltfImport, MixedPrimitivesGetFlatNormalsAndFilledAttributes)
{
    Document d;
    const int p = d.positions(k_square);
    const int n = d.floats({1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0}, "VEC3", 3);
    const int c = d.accessor<std::uint8_t>({255, 0, 51, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 5121, 4,
                                           ",\"normalized\":true");
    const int i = d.accessor<std::uint8_t>({0, 1, 2, 0, 2, 3}, "SCALAR", 5121, 1);
    const scene::Scene s = d.load(one_mesh(fmt::format(
        R"({{"attributes":{{"POSITION":{0},"NORMAL":{1},"COLOR_0":{2}}},"indices":{3}}},{{"attributes":{{"POSITION":{0}}},"indices":{3}}})",
        p, n, c, i)));
    const scene::Mesh& m = s.meshes.at(0);
    EXPECT_EQ(m.positions.size(), 4u + 6u);
    EXPECT_EQ(m.normals[0], glm::vec3(1, 0, 0));
    EXPECT_EQ(m.normals[9], glm::vec3(0, 0, 1));
    EXPECT_EQ(m.colors[0], glm::vec4(1, 0, 0.2f, 1));
    EXPECT_EQ(m.colors[9], glm::vec4(1));
}

TEST(GltfImport, ReadsQuantizedMeshes)
{
    // Three 16-bit integers per vertex, tightly packed: unaligned, so the extension must be required.
    Document packed;
    packed.accessor<std::int16_t>({-32768, 0, 32767, 0, 32767, 0, 0, 0, 0}, "VEC3", 5122, 3,
                                  R"(,"normalized":true,"min":[-32768,0,0],"max":[0,32767,32767])");
    const std::string mesh = one_mesh(R"({"attributes":{"POSITION":0}})"),
                      used = R"("extensionsUsed":["KHR_mesh_quantization"],)";
    const std::string required = R"("extensionsRequired":["KHR_mesh_quantization"],)";
    EXPECT_THROW(packed.load(mesh, used + required, {.strict = true}), InputError);
    EXPECT_THROW(packed.load(mesh, used, {.strict = true}), InputError);

    const test::ScratchFolder folder;
    std::ofstream(folder / "q.bin", std::ios::binary) << std::string("\x80\x7f\0\0\0\x7f\x40\0\0\0\0\0", 12);
    std::ofstream(folder / "q.gltf") << R"({"asset":{"version":"2.0"},)" + used + required +
                                            R"("buffers":[{"byteLength":12,"uri":"q.bin"}],"bufferViews":[{"buffer":0,
        "byteLength":12,"byteStride":4}],"accessors":[{"bufferView":0,"type":"VEC3","componentType":5120,"normalized":true,
        "count":3,"min":[-128,0,0],"max":[0,127,64]}],)" +
                                            mesh + "}";
    const scene::Scene s = io::load_gltf(folder / "q.gltf");
    EXPECT_EQ(s.meshes.at(0).positions[0], glm::vec3(-1, 1, 0));
    EXPECT_FLOAT_EQ(s.meshes.at(0).positions[1].z, 64 / 127.0f);
}

TEST(GltfImport, SparseAccessorsOverrideZeros)
{
    const test::ScratchFolder folder;
    std::ofstream(folder / "s.bin", std::ios::binary)
        << std::string("\1\0\2\0", 4) << std::string("\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0", 24);
    std::ofstream(folder / "s.gltf")
        << R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":28,"uri":"s.bin"}],"bufferViews":[{"buffer":0,"byteLength":4},
            {"buffer":0,"byteOffset":4,"byteLength":24}],"accessors":[{"type":"VEC3","componentType":5126,"count":3,
            "min":[0,0,0],"max":[1,1,0],"sparse":{"count":2,"indices":{"bufferView":0,"componentType":5123},
            "values":{"bufferView":1}}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}]})";
    const scene::Scene s = io::load_gltf(folder / "s.gltf");
    EXPECT_EQ(s.meshes.at(0).positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_TRUE(s.warnings.empty());
}

TEST(GltfImport, ReadsMorphTargetsAndTheirAnimation)
{
    Document d;
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int t = d.positions({0, 0, 2, 0, 0, 2, 0, 0, 2});
    const int time = d.times({0, 1});
    const int weights = d.floats({0, 1}, "SCALAR", 1);
    auto s = std::make_shared<scene::Scene>(
        d.load(one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}},"targets":[{{"POSITION":{}}}]}})", p, t),
                        R"(,"weights":[0.25])") +
               fmt::format(R"(,"animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}],)"
                           R"("samplers":[{{"input":{},"output":{}}}]}}])",
                           time, weights)));
    EXPECT_TRUE(s->objects.at(0).dynamic && s->objects.at(0).deforming);
    EXPECT_EQ(s->timeline.frames, 25);
    scene::SceneState state(s, 0.5);
    EXPECT_EQ(state.deformed(0).positions[1], glm::vec3(1, 0, 1));
}

TEST(GltfImport, SkinsDeformMeshes)
{
    Document d;
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int j = d.accessor<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4", 5121, 4);
    const int w = d.floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4", 4);
    const int time = d.times({0, 1});
    const int moved = d.floats({0, 0, 0, 0, 0, 4}, "VEC3", 3);
    auto s = std::make_shared<scene::Scene>(d.load(fmt::format(
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{},"JOINTS_0":{},"WEIGHTS_0":{}}}}}]}}],)"
        R"("skins":[{{"joints":[1,2]}}],"nodes":[{{"mesh":0,"skin":0}},{{"children":[2]}},{{}}],"animations":[{{"channels":)"
        R"([{{"sampler":0,"target":{{"node":2,"path":"translation"}}}}],"samplers":[{{"input":{},"output":{}}}]}}])",
        p, j, w, time, moved)));
    scene::SceneState state(s, 0);
    state.advance(1);
    const auto& positions = state.deformed(0).positions;
    EXPECT_EQ(positions[0], glm::vec3(0, 0, 0));
    EXPECT_EQ(positions[1], glm::vec3(1, 0, 4));
    EXPECT_EQ(positions[2], glm::vec3(0, 1, 2));
}

TEST(GltfImport, ReadsMaterialsTexturesAndExtensions)
{
    Document d;
    Image8 image(2, 1, 3);
    image.data = {255, 0, 0, 0, 0, 255};
    io::write_png(d.folder() / "two.png", image);
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int uv = d.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    const scene::Scene s = d.load(
        one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"material":0}})", p, uv)) +
            R"(,"images":[{"uri":"two.png"}],"samplers":[{"magFilter":9728,"minFilter":9729,"wrapS":33071,"wrapT":33648}],
            "textures":[{"source":0,"sampler":0}],"materials":[{"name":"m","pbrMetallicRoughness":{"baseColorFactor":[1,0.5,0.25,0.75],
            "metallicFactor":0.5,"roughnessFactor":0.25,"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":
            {"offset":[0.5,0],"scale":[2,3],"rotation":1.5}}},"metallicRoughnessTexture":{"index":0}},"alphaMode":"MASK",
            "alphaCutoff":0.3,"doubleSided":true,"emissiveFactor":[1,0.5,0],"normalTexture":{"index":0,"scale":2},
            "extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4},"KHR_materials_ior":{"ior":1.33},
            "KHR_materials_transmission":{"transmissionFactor":0.9}}}])",
        R"("extensionsUsed":["KHR_texture_transform","KHR_materials_emissive_strength","KHR_materials_ior","KHR_materials_transmission"],)");
    const scene::Material& m = s.materials.at(0);
    EXPECT_EQ(m.base_color, glm::vec3(1, 0.5f, 0.25f));
    EXPECT_EQ(m.alpha, 0.75f);
    EXPECT_EQ(m.metallic, 0.5f);
    EXPECT_EQ(m.roughness, 0.25f);
    EXPECT_EQ(m.alpha_mode, scene::AlphaMode::mask);
    EXPECT_EQ(m.alpha_cutoff, 0.3f);
    EXPECT_TRUE(m.double_sided);
    EXPECT_EQ(m.emissive, glm::vec3(4, 2, 0));
    EXPECT_EQ(m.ior, 1.33f);
    EXPECT_EQ(m.transmission, 0.9f);
    EXPECT_EQ(m.normal_scale, 2);
    EXPECT_EQ(m.base_color_texture.offset, glm::vec2(0.5f, 0));
    EXPECT_EQ(m.base_color_texture.scale, glm::vec2(2, 3));
    EXPECT_EQ(m.base_color_texture.rotation, 1.5f);
    // One image used as colour and as data gives two textures; normal and metallic-roughness share one.
    ASSERT_EQ(s.textures.size(), 2u);
    EXPECT_TRUE(s.textures[m.base_color_texture.texture].srgb());
    EXPECT_FALSE(s.textures[m.normal_texture.texture].srgb());
    EXPECT_EQ(m.normal_texture.texture, m.metallic_roughness_texture.texture);
    EXPECT_EQ(s.textures[0].sampler().magnify, scene::Filter::nearest);
    EXPECT_EQ(s.textures[0].sampler().wrap_u, scene::Wrap::clamp);
    EXPECT_EQ(s.textures[0].sampler().wrap_v, scene::Wrap::mirror);
    EXPECT_FALSE(s.textures[0].sampler().mipmaps);
    EXPECT_TRUE(s.warnings.empty()) << s.warnings.front();
}

// Images are decoded several at a time, some before a material asks for them.
class GltfImages : public testing::Test {
 protected:
    static constexpr int k_images = 40;
    // Materials with two images each, used by meshes from the last one on, but for material 3.
    scene::Scene load(const io::ReadOptions& options = {})
    {
        const int p = d_.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
        const int uv = d_.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
        std::string parts, images, textures, materials;
        for (int i = 0; i < k_images; ++i) {
            const char* const comma = i ? "," : "";
            images += fmt::format(R"({}{{"uri":"{}.png"}})", comma, i);
            textures += fmt::format(R"({}{{"source":{}}})", comma, i);
        }
        for (int m = 0; m < k_images / 2; ++m) {
            const int last = k_images / 2 - 1 - m;
            if (last != 3)
                parts += fmt::format(R"({}{{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"material":{}}})",
                                     m ? "," : "", p, uv, last);
            materials += fmt::format(R"({}{{"name":"{}","pbrMetallicRoughness":{{"baseColorTexture":{{"index":{}}}}},
                            "normalTexture":{{"index":{}}}}})",
                                     m ? "," : "", m, 2 * m, 2 * m + 1);
        }
        return d_.load(one_mesh(parts) + fmt::format(R"(,"images":[{}],"textures":[{}],"materials":[{}])", images,
                                                     textures, materials),
                       "", options);
    }
    std::filesystem::path file(int image) { return d_.folder() / fmt::format("{}.png", image); }
    void SetUp() override
    {
        for (int i = 0; i < k_images; ++i) {
            Image8 image(3 + i, 2, 3);
            std::fill(image.data.begin(), image.data.end(), static_cast<std::uint8_t>(5 * i));
            io::write_png(file(i), image);
        }
    }
    static void expect_images(const scene::Scene& s)
    {
        ASSERT_EQ(s.materials.size(), std::size_t{k_images / 2 - 1});
        for (const scene::Material& material : s.materials) {
            const int first = 2 * std::stoi(material.name);
            const scene::Texture &color = s.textures[material.base_color_texture.texture],
                                 &normal = s.textures[material.normal_texture.texture];
            EXPECT_EQ(color.width(), 3 + first);
            EXPECT_EQ(color.levels()[0].data[0], 5 * first);
            EXPECT_EQ(normal.width(), 4 + first);
            EXPECT_EQ(normal.levels()[0].data[0], 5 * (first + 1));
        }
    }
    Document d_;
};

TEST_F(GltfImages, DecodedAheadAreThoseOfTheirTextures)
{
    expect_images(load());
}

TEST_F(GltfImages, AreDecodedOneByOneIfThereIsLittleMemory)
{
    scene::Scene most = load();
    std::uint64_t bytes = 0;
    for (const scene::Texture& texture : most.textures)
        for (const Image8& level : texture.levels()) bytes += level.data.size();
    for (const std::uint64_t more : {150'000, 300'000, 1'000'000}) expect_images(load({.memory = bytes + more}));
}

TEST_F(GltfImages, AreRefusedAtTheirPlaceIfBroken)
{
    const std::uintmax_t size = std::filesystem::file_size(file(20));
    std::filesystem::resize_file(file(20), size - 20);
    std::filesystem::resize_file(file(6), 8);   // not used
    try {
        load();
        FAIL() << "a broken image was read";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("/images/20"), std::string::npos) << error.what();
    }
}

// The alpha of an opaque material has no effect, and must not weight the colours in coarser mipmap levels.
TEST(GltfImport, UnusedAlphaDoesNotWeightMipmaps)
{
    Document d;
    Image8 image(2, 1, 4);
    image.data = {255, 255, 255, 0, 0, 0, 0, 255};
    io::write_png(d.folder() / "two.png", image);
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int uv = d.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    const auto part = [&](int material) {
        return fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"material":{}}})", p, uv, material);
    };
    const scene::Scene s = d.load(
        one_mesh(part(0) + "," + part(1)) +
        R"(,"images":[{"uri":"two.png"}],"textures":[{"source":0}],"materials":[{"name":"opaque","normalTexture":{"index":0},
        "pbrMetallicRoughness":{"baseColorTexture":{"index":0}}},{"name":"blend","alphaMode":"BLEND",
        "pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}])");
    const auto from_afar = [&](const scene::TextureUse& use) {
        return s.textures[use.texture].sample({0.5f, 0.5f}, 2);
    };
    ASSERT_EQ(s.materials.size(), 2u);
    const bool first = s.materials[0].name == "opaque";
    const scene::Material &opaque = s.materials[first ? 0 : 1], &blend = s.materials[first ? 1 : 0];
    EXPECT_NEAR(from_afar(opaque.base_color_texture).x, 0.5f, 0.01f);
    EXPECT_NEAR(from_afar(opaque.normal_texture).x, 0.5f, 0.01f);
    EXPECT_NEAR(from_afar(blend.base_color_texture).x, 0, 0.01f);
    EXPECT_NEAR(from_afar(blend.base_color_texture).w, 0.5f, 0.01f);
}

TEST(GltfImport, ReadsCamerasLightsAndTheDefaultScene)
{
    Document d;
    const scene::Scene s = d.load(
        R"("scene":1,"scenes":[{"nodes":[0]},{"nodes":[1]}],"nodes":[{"name":"away"},{"name":"root","children":[2,3],
        "matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]},{"camera":0},{"camera":1,"extensions":{"KHR_lights_punctual":{"light":0}}}],
        "cameras":[{"type":"perspective","perspective":{"yfov":0.5,"znear":0.1}},{"name":"flat","type":"orthographic",
        "orthographic":{"xmag":3,"ymag":2,"znear":0,"zfar":9}}],"extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot",
        "color":[1,0.5,0],"intensity":10,"range":20,"spot":{"innerConeAngle":0.1,"outerConeAngle":0.2}}]}})",
        R"("extensionsUsed":["KHR_lights_punctual"],)");
    ASSERT_EQ(s.nodes.size(), 3u);
    EXPECT_EQ(s.nodes[0].name, "root");
    ASSERT_EQ(s.cameras.size(), 2u);
    EXPECT_EQ(s.cameras[0].vertical_fov, 0.5);
    EXPECT_EQ(s.cameras[1].orthographic_height, 4);
    EXPECT_EQ(s.cameras[1].name, "flat");
    ASSERT_EQ(s.lights.size(), 1u);
    EXPECT_EQ(s.lights[0].color, glm::vec3(10, 5, 0));
    EXPECT_EQ(s.lights[0].range, 20);
    EXPECT_EQ(s.lights[0].outer_angle, 0.2f);
    EXPECT_EQ(glm::dvec3(s.world_matrix(s.lights[0].node, 0)[3]), glm::dvec3(5, 6, 7));
}

TEST(GltfImport, AllAnimationsPlayAndTheLongestEndsTheClip)
{
    Document d;
    const int p = d.positions({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const int a = d.times({0, 1}), b = d.times({0.5f, 2.5f});
    const int v = d.floats({0, 0, 0, 1, 0, 0}, "VEC3", 3), w = d.floats({1, 1, 1, 2, 2, 2}, "VEC3", 3);
    const scene::Scene s = d.load(fmt::format(
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],"nodes":[{{"mesh":0,"scale":[1,1,1]}}],"animations":[)"
        R"({{"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}],"samplers":[{{"input":{},"output":{}}}]}},)"
        R"({{"channels":[{{"sampler":0,"target":{{"node":0,"path":"scale"}}}}],"samplers":[{{"input":{},"output":{}}}]}},)"
        R"({{"channels":[{{"sampler":0,"target":{{"node":0,"path":"scale"}}}}],"samplers":[{{"input":{},"output":{}}}]}}])",
        p, a, v, b, w, a, w));
    EXPECT_EQ(s.timeline.end, 2.5);
    EXPECT_EQ(s.timeline.frames, 61);
    EXPECT_TRUE(s.nodes[0].animated);
    const glm::dmat4 m = s.nodes[0].transform->evaluate(1.5);
    EXPECT_EQ(m[3].x, 1);
    EXPECT_EQ(m[0].x, 1.5);
    EXPECT_EQ(s.warnings.size(), 1u);   // the third animates the same target as the second
}

TEST(GltfImport, ErrorsNameFileAndPlace)
{
    Document d;
    const int p = d.positions(k_square);
    const int i = d.accessor<std::uint8_t>({0, 1, 4}, "SCALAR", 5121, 1);
    try {
        d.load(one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}},"indices":{}}})", p, i)));
        FAIL() << "accepted an index beyond the vertices";
    } catch (const InputError& error) {
        EXPECT_EQ(error.file(), (d.folder() / "a.gltf").string());
        EXPECT_EQ(error.place(), "/meshes/0/primitives/0/indices");
        EXPECT_NE(error.problem().find("vertex 4"), std::string::npos) << error.what();
    }
}

TEST(GltfImport, StopsWhenInterrupted)
{
    Document d;
    d.load(R"("nodes":[{}])");
    EXPECT_THROW(io::load_gltf(d.folder() / "a.gltf", [](const ProgressStep&) { return false; }), InterruptedError);
}

}   // namespace
}   // namespace gnomon
