// SPDX-License-Identifier: Apache-2.0
// glTF extensions that change what a document says: specular-glossiness, variants of materials, instances, and textures
// with a fallback.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "gltf_document.h"
#include "gnomon/error.h"
#include "image_bytes.h"
#include "io/gltf/specular_glossiness.h"

namespace gnomon {
namespace {

using io::gltf::metallic_from_specular;
using test::Document;
using test::one_mesh;

const std::vector<float> k_triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};

// Every metallic-roughness surface, written as specular-glossiness, is found again.
TEST(SpecularGlossiness, ConvertsMetalsAndDielectricsBack)
{
    for (const float metallic : {0.0f, 0.25f, 0.5f, 1.0f})
        for (const glm::vec3 base : {glm::vec3(.5f), glm::vec3(.8f), glm::vec3(.2f)}) {
            const glm::vec3 specular = glm::mix(glm::vec3(.04f), base, metallic);
            const glm::vec3 diffuse = base * (1 - .04f) * (1 - metallic) / (1 - specular.x);
            const io::gltf::MetallicRoughness m = metallic_from_specular(diffuse, specular);
            EXPECT_NEAR(m.metallic, metallic, .02f) << base.x;
            EXPECT_NEAR(m.base_color.x, base.x, .02f) << metallic;
        }
    const io::gltf::MetallicRoughness gold = metallic_from_specular({0, 0, 0}, {1, .77f, .34f});
    EXPECT_NEAR(gold.metallic, 1, 1e-3f);
    EXPECT_NEAR(gold.base_color.y, .77f, .01f);
    EXPECT_NEAR(gold.base_color.z, .34f, .01f);
    EXPECT_EQ(metallic_from_specular({.5f, .5f, .5f}, {0, 0, 0}).metallic, 0);
}

TEST(SpecularGlossiness, FactorsAndTexturesAreConverted)
{
    Document d;
    const int p = d.positions(k_triangle), uv = d.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    const std::string used = R"("extensionsUsed":["KHR_materials_pbrSpecularGlossiness"],)"
                             R"("extensionsRequired":["KHR_materials_pbrSpecularGlossiness"],)";
    const std::string mesh =
        one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"material":0}})", p, uv));
    const auto material = [](const std::string& values) {
        return R"("materials":[{"extensions":{"KHR_materials_pbrSpecularGlossiness":{)" + values + "}}}],";
    };
    const scene::Scene plain = d.load(
        material(R"("diffuseFactor":[0,0,0,0.5],"specularFactor":[1,0.5,0.25],"glossinessFactor":0.75)") + mesh, used);
    EXPECT_TRUE(plain.warnings.empty());
    EXPECT_EQ(plain.materials.at(0).roughness, .25f);
    EXPECT_EQ(plain.materials.at(0).alpha, .5f);
    EXPECT_NEAR(plain.materials.at(0).metallic, 1, 1e-3f);
    EXPECT_NEAR(plain.materials.at(0).base_color.z, .25f, .01f);

    // A dielectric in the left texel and a metal in the right one, whose glossiness is in alpha.
    const auto write = [&](const char* name, int width, int type, const std::vector<std::uint8_t>& row) {
        const auto png = test::png_bytes({width, 1, 8, type}, {row});
        std::ofstream(d.folder() / name, std::ios::binary)
            .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    };
    write("d.png", 2, PNG_COLOR_TYPE_RGB, {188, 188, 188, 0, 0, 0});
    write("s.png", 2, PNG_COLOR_TYPE_RGBA, {56, 56, 56, 255, 255, 0, 0, 51});
    const scene::Scene textured =
        d.load(R"("images":[{"uri":"d.png"},{"uri":"s.png"}],"textures":[{"source":0},{"source":1}],)" +
                   material(R"("diffuseTexture":{"index":0},"specularGlossinessTexture":{"index":1})") + mesh,
               used);
    EXPECT_TRUE(textured.warnings.empty());
    const scene::Material& m = textured.materials.at(0);
    ASSERT_TRUE(m.base_color_texture.used() && m.metallic_roughness_texture.used());
    EXPECT_EQ(textured.textures.size(), 2u);
    const Image8& base = textured.textures[m.base_color_texture.texture].levels().at(0);
    const Image8& rough = textured.textures[m.metallic_roughness_texture.texture].levels().at(0);
    EXPECT_NEAR(base.pixel(0, 0)[0], 188, 3);
    EXPECT_EQ(rough.pixel(0, 0)[1], 0);
    EXPECT_LT(rough.pixel(0, 0)[2], 4);
    EXPECT_GT(base.pixel(1, 0)[0], 250);
    EXPECT_LT(base.pixel(1, 0)[1], 5);
    EXPECT_EQ(rough.pixel(1, 0)[1], 204);
    EXPECT_GT(rough.pixel(1, 0)[2], 250);
}

TEST(GltfVariants, AVariantIsChosenByName)
{
    Document d;
    const int p = d.positions(k_triangle);
    const std::string used = R"("extensionsUsed":["KHR_materials_variants"],)"
                             R"("extensionsRequired":["KHR_materials_variants"],)";
    const std::string rest =
        R"("extensions":{"KHR_materials_variants":{"variants":[{"name":"day"},{"name":"night"}]}},"materials":[)"
        R"({"name":"plain"},{"name":"dark"}],)" +
        one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}},"material":0,"extensions":{{"KHR_materials_variants":)"
                             R"({{"mappings":[{{"material":1,"variants":[1]}}]}}}}}})",
                             p));
    const auto name_of = [&](const std::string& variant) {
        const scene::Scene s = d.load(rest, used, {.variant = variant});
        EXPECT_EQ(s.variants, (std::vector<std::string>{"day", "night"}));
        EXPECT_TRUE(s.warnings.empty());
        return s.materials.at(s.meshes.at(0).parts.at(0).material).name;
    };
    EXPECT_EQ(name_of(""), "plain");
    EXPECT_EQ(name_of("day"), "plain");   // maps nothing
    EXPECT_EQ(name_of("night"), "dark");
    EXPECT_THROW(name_of("dusk"), UsageError);
}

TEST(GltfInstancing, EachInstanceIsAnObjectBelowItsNode)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int t = d.floats({0, 0, 0, 5, 0, 0}, "VEC3", 3), s = d.floats({1, 1, 1, 2, 2, 2}, "VEC3", 3);
    const int r = d.accessor<std::int8_t>({0, 0, 0, 127, 0, 0, 127, 0}, "VEC4", 5120, 4, R"(,"normalized":true)");
    const std::string used = R"("extensionsUsed":["EXT_mesh_gpu_instancing"],)"
                             R"("extensionsRequired":["EXT_mesh_gpu_instancing"],)";
    const auto rest = [&](const std::string& attributes) {
        return fmt::format(
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],"nodes":[{{"mesh":0,)"
            R"("translation":[0,1,0],"extensions":{{"EXT_mesh_gpu_instancing":{{"attributes":{{{}}}}}}}}}])",
            p, attributes);
    };
    const scene::Scene scene =
        d.load(rest(fmt::format(R"("TRANSLATION":{},"SCALE":{},"ROTATION":{},"_COLOR":{})", t, s, r, t)), used);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.objects.size(), 2u);
    EXPECT_EQ(scene.meshes.size(), 1u);
    const auto corner = [&](std::size_t object, const glm::dvec3& at) {
        return glm::dvec3(scene.world_matrix(scene.objects[object].node, 0) * glm::dvec4(at, 1));
    };
    EXPECT_EQ(corner(0, {1, 0, 0}), glm::dvec3(1, 1, 0));
    EXPECT_NEAR(glm::length(corner(1, {1, 0, 0}) - glm::dvec3(3, 1, 0)), 0,
                1e-9);   // turned half about z, twice as large
    EXPECT_THROW(d.load(rest(fmt::format(R"("TRANSLATION":{},"SCALE":{})", t, p)), used), InputError);
    EXPECT_THROW(d.load(rest(fmt::format(R"("ROTATION":{})", t)), used), InputError);
    // A few bytes that stand for many instances.
    const int many = d.raw_accessor(R"({"componentType":5126,"type":"VEC3","count":1000000000})");
    EXPECT_THROW(d.load(rest(fmt::format(R"("TRANSLATION":{})", many)), used), InputError);
}

TEST(GltfBasisu, TheFallbackIsReadAndItsLackIsExplained)
{
    Document d;
    const int p = d.positions(k_triangle), uv = d.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    const auto png = test::png_bytes({1, 1, 8, PNG_COLOR_TYPE_GRAY}, {{7}});
    std::ofstream(d.folder() / "f.png", std::ios::binary)
        .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
    std::ofstream(d.folder() / "k.ktx2", std::ios::binary) << "\xabKTX 20\xbb\r\n\x1a\n";
    const auto rest = [&](const std::string& source) {
        return R"("images":[{"uri":"f.png"},{"uri":"k.ktx2"}],"textures":[{)" + source +
               R"("extensions":{"KHR_texture_basisu":{"source":1}}}],"materials":[{"pbrMetallicRoughness":)"
               R"({"baseColorTexture":{"index":0}}}],)" +
               one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"material":0}})", p, uv));
    };
    const std::string used = R"("extensionsUsed":["KHR_texture_basisu"],)";
    const std::string required = used + R"("extensionsRequired":["KHR_texture_basisu"],)";
    for (const std::string& extensions : {used, required}) {
        const scene::Scene s = d.load(rest(R"("source":0,)"), extensions);
        EXPECT_TRUE(s.warnings.empty()) << s.warnings.at(0);
        EXPECT_TRUE(s.materials.at(0).base_color_texture.used());
    }
    const scene::Scene without = d.load(rest(""), used);
    EXPECT_FALSE(without.materials.at(0).base_color_texture.used());
    ASSERT_FALSE(without.warnings.empty());
    EXPECT_NE(without.warnings.back().find("convert"), std::string::npos) << without.warnings.back();
    try {
        d.load(rest(""), required);
        ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
        EXPECT_EQ(error.place(), "/extensionsRequired/0");
        EXPECT_NE(std::string(error.what()).find("PNG"), std::string::npos) << error.what();
    }
}

}   // namespace
}   // namespace gnomon
