// SPDX-License-Identifier: Apache-2.0
// Errors of glTF files that are repaired: each gives one warning with a count, and is refused in strict mode.
// LONG: a test or more for each kind of fault.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "gltf_document.h"
#include "gnomon/error.h"
#include "scene/mesh_repairs.h"
#include "scene/state.h"

namespace gnomon {
namespace {

using test::Document;
using test::one_mesh;

const std::vector<float> k_triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
const std::vector<float> k_up = {0, 0, 1, 0, 0, 1, 0, 0, 1};

// Loads the document in both modes.
scene::Scene repaired(const Document& d, const std::string& rest, const std::string& warning,
                      const std::string& extensions = "")
{
    EXPECT_THROW(d.load(rest, extensions, {.strict = true}), InputError) << warning;
    scene::Scene scene = d.load(rest, extensions);
    EXPECT_EQ(scene.warnings.size(), 1u) << warning;
    if (!scene.warnings.empty()) {
        EXPECT_NE(scene.warnings[0].find(warning), std::string::npos) << scene.warnings[0];
    }
    return scene;
}

std::string skinned(int p, int j, int w, const std::string& skin = "")
{
    return fmt::format(
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{},"JOINTS_0":{},"WEIGHTS_0":{}}}}}]}}],)"
        R"("nodes":[{{"mesh":0,"skin":0}},{{}},{{"children":[1]}}],"skins":[{{"joints":[1]{}}}],"scenes":[{{"nodes":[0,2]}}])",
        p, j, w, skin);
}

TEST(GltfRepairs, WeightsAreScaledToASumOfOne)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int j = d.accessor<std::uint8_t>(std::vector<std::uint8_t>(12, 0), "VEC4", 5121, 4);
    const int w = d.floats({.5f, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    const scene::Scene s = repaired(d, skinned(p, j, w), "2 vertices whose weights do not sum to 1: renormalised");
    for (const glm::vec4& weight : s.meshes.at(0).skin->weights[0]) EXPECT_EQ(weight, glm::vec4(1, 0, 0, 0));
}

TEST(GltfRepairs, NormalsWithoutADirectionAreTheFaces)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int n = d.floats({0, 0, 0, 0, 3, 0, 0, 0, 4e-8f}, "VEC3", 3);
    const scene::Scene s = repaired(d, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"NORMAL":{}}}}})", p, n)),
                                    "3 normals are not of unit length");
    EXPECT_EQ(s.meshes.at(0).normals, (std::vector<glm::vec3>{{0, 0, 1}, {0, 1, 0}, {0, 0, 1}}));
}

TEST(GltfRepairs, TangentsWithoutADirectionLieAcrossTheNormal)
{
    Document d;
    const int p = d.positions(k_triangle), n = d.floats(k_up, "VEC3", 3);
    const int t = d.floats({0, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0}, "VEC4", 4);
    const scene::Scene s =
        repaired(d, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"NORMAL":{},"TANGENT":{}}}}})", p, n, t)),
                 "2 tangents are not of unit length");
    const glm::vec4 first = s.meshes.at(0).tangents.at(0);
    EXPECT_NEAR(glm::length(glm::vec3(first)), 1, 1e-6);
    EXPECT_EQ(first.z, 0);
    EXPECT_EQ(s.meshes.at(0).tangents.at(2), glm::vec4(1, 0, 0, 1));
}

TEST(GltfRepairs, ColoursThatNobodyPaintedAreWhite)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int partly = d.floats({0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1}, "VEC4", 4);
    const int without_opacity = d.floats({0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, "VEC4", 4);
    const auto mesh = [&](int colors) {
        return one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"COLOR_0":{}}}}})", p, colors));
    };
    const scene::Scene s = d.load(mesh(partly));
    EXPECT_EQ(s.meshes.at(0).colors, (std::vector<glm::vec4>{{1, 1, 1, 1}, {1, 0, 0, 1}, {0, 0, 0, 1}}));
    ASSERT_EQ(s.warnings.size(), 1u);
    EXPECT_NE(s.warnings[0].find("1 vertex whose colour is zero, opacity included: taken as white"), std::string::npos);
    // The format allows them.
    EXPECT_EQ(d.load(mesh(partly), "", {.strict = true}).meshes.at(0).colors.at(0), glm::vec4(0));
    EXPECT_EQ(d.load(mesh(without_opacity)).meshes.at(0).colors.at(0), glm::vec4(0));
}

TEST(GltfRepairs, EmptyArraysAreAbsent)
{
    const Document d;
    repaired(d, R"("samplers":[],"scenes":[{"nodes":[]}],"meshes":[],"nodes":[{"children":[]}])", "5 arrays are empty",
             R"("extensionsUsed":[],)");
    repaired(d, R"("nodes":[{}],"animations":[{"channels":[],"samplers":[]}])", "2 arrays are empty");
}

TEST(GltfRepairs, ANodeOfASceneNeedNotBeARoot)
{
    Document d;
    const int p = d.positions(k_triangle);
    const std::string mesh = fmt::format(R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],)", p);
    const scene::Scene s =
        repaired(d, mesh + R"("nodes":[{"children":[1],"translation":[5,0,0]},{"mesh":0}],"scenes":[{"nodes":[1]}])",
                 "1 node of a scene is not a root");
    EXPECT_EQ(s.objects.size(), 1u);
    EXPECT_EQ(s.bounds(0).low.x, 0);   // where the scene lists it, not below its parent
    // A listed node below another listed one stays there, and is drawn once.
    const scene::Scene both =
        repaired(d, mesh + R"("nodes":[{"children":[1],"translation":[5,0,0]},{"mesh":0}],"scenes":[{"nodes":[0,1]}])",
                 "1 node of a scene is not a root");
    EXPECT_EQ(both.objects.size(), 1u);
    EXPECT_EQ(both.bounds(0).low.x, 5);
}

TEST(GltfRepairs, ASceneWithoutMeshesIsReplacedByOneThatHasSome)
{
    Document d;
    const int p = d.positions(k_triangle);
    const std::string rest =
        fmt::format(R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],"nodes":[{{"mesh":0}},{{}}],)"
                    R"("scenes":[{{"nodes":[1]}},{{"nodes":[0]}}],"scene":0)",
                    p);
    EXPECT_EQ(d.load(rest, "", {.strict = true}).objects.size(), 0u) << "as the file says";
    const scene::Scene s = d.load(rest);
    EXPECT_EQ(s.objects.size(), 1u);
    ASSERT_EQ(s.warnings.size(), 1u);
    EXPECT_NE(s.warnings[0].find("has no meshes: scene 1 is read"), std::string::npos) << s.warnings[0];
}

TEST(GltfRepairs, OfManyCopiesInOnePlaceSomeAreLeftOut)
{
    Document d;
    const int p = d.positions(k_triangle);
    std::string nodes, list;
    for (int i = 0; i < 70; ++i) {
        nodes += std::string(i ? "," : "") + R"({"mesh":0})";
        list += (i ? "," : "") + std::to_string(i);
    }
    // These stand elsewhere.
    nodes += R"(,{"mesh":0,"translation":[1,0,0]},{"mesh":0,"scale":[2,2,2]})";
    const std::string rest = fmt::format(
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],"nodes":[{}],"scenes":[{{"nodes":[{},70,71]}}])",
        p, nodes, list);
    EXPECT_EQ(repaired(d, rest, "6 nodes repeat meshes in places where 64 others have them").objects.size(), 66u);
}

TEST(GltfRepairs, TheSkeletonIsAHint)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int j = d.accessor<std::uint8_t>(std::vector<std::uint8_t>(12, 0), "VEC4", 5121, 4);
    const int w = d.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    repaired(d, skinned(p, j, w, R"(,"skeleton":0)"), "1 joint is not below the root of its skeleton");
}

TEST(GltfRepairs, TheLastRowOfAnInverseBindMatrixIsReplaced)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int j = d.accessor<std::uint8_t>(std::vector<std::uint8_t>(12, 0), "VEC4", 5121, 4);
    const int w = d.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    const int m = d.floats({1, 0, 0, .1f, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, .9f}, "MAT4", 16);
    const scene::Scene s = repaired(d, skinned(p, j, w, fmt::format(",\"inverseBindMatrices\":{}", m)),
                                    "1 inverse bind matrix whose last row is not 0 0 0 1");
    EXPECT_EQ(s.skins.at(0).inverse_bind.at(0), glm::dmat4(1));
}

TEST(GltfRepairs, ATextureWithoutItsCoordinatesIsLeftOut)
{
    Document d;
    const int p = d.positions(k_triangle);
    const std::string rest =
        R"("images":[{"uri":"none.png"}],"textures":[{}],"materials":[{"pbrMetallicRoughness":{"baseColorTexture":)"
        R"({"index":0}},"emissiveFactor":[1,1,1],"emissiveTexture":{"index":0}}],)";
    const scene::Scene s =
        d.load(rest + one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}},"material":0}})", p)));
    ASSERT_EQ(s.warnings.size(), 2u);
    EXPECT_NE(s.warnings[0].find("2 textures without their texture coordinates: left out"), std::string::npos)
        << s.warnings[0];
    EXPECT_NE(s.warnings[1].find("1 image file does not exist"), std::string::npos) << s.warnings[1];
    EXPECT_EQ(s.materials.at(0).base_color_texture.texture, scene::none);
    EXPECT_EQ(s.materials.at(0).emissive, glm::vec3(0));   // only the texture says where it emits
}

TEST(GltfRepairs, AMissingImageIsANeutralTexelAndAMissingBufferAnError)
{
    Document d;
    const int p = d.positions(k_triangle), uv = d.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    const std::string rest =
        R"("images":[{"uri":"none.png"}],"textures":[{"source":0}],"materials":[{"pbrMetallicRoughness":{)"
        R"("baseColorFactor":[0.5,0.25,1,1],"baseColorTexture":{"index":0}},"normalTexture":{"index":0},)"
        R"("emissiveFactor":[1,1,1],"emissiveTexture":{"index":0}}],)" +
        one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"TEXCOORD_0":{}}},"material":0}})", p, uv));
    const scene::Scene s = repaired(d, rest, "1 image file does not exist: replaced by a neutral texel");
    EXPECT_EQ(s.materials.at(0).base_color, glm::vec3(.5f, .25f, 1));
    EXPECT_EQ(s.materials.at(0).normal_texture.texture, scene::none);
    EXPECT_EQ(s.materials.at(0).emissive, glm::vec3(0));
    const Document e;
    for (const bool strict : {false, true})
        EXPECT_THROW(e.load(R"("buffers":[{"byteLength":4,"uri":"none.bin"}])", "", {.strict = strict}), InputError);
}

TEST(GltfRepairs, FilesAreFoundUnderSimilarNames)
{
    test::ScratchFolder folder;
    std::filesystem::create_directory(folder / "Data");
    std::ofstream(folder / "Data" / "Mesh.bin") << std::string(8, 0);
    for (const char* const uri : {"data/mesh.BIN", "Data\\\\Mesh.bin", "data%2Fmesh.bin", "DATA/other/../Mesh.bin"}) {
        std::ofstream(folder / "a.gltf") << fmt::format(
            R"({{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":8,"uri":"{}"}}]}})", uri);
        const bool up = std::string(uri).find("..") != std::string::npos;   // no such folder
        if (up) {
            EXPECT_THROW(io::load_gltf(folder / "a.gltf"), InputError);
            continue;
        }
        const scene::Scene scene = io::load_gltf(folder / "a.gltf");
        ASSERT_EQ(scene.warnings.size(), 1u) << uri;
        EXPECT_NE(scene.warnings[0].find("1 file has another name than written"), std::string::npos);
        io::ReadOptions strict;
        strict.strict = true;
        EXPECT_THROW(io::load_gltf(folder / "a.gltf", {}, strict), InputError) << uri;
    }
}

TEST(GltfRepairs, StridesOfAnimationDataAreRead)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int t = d.times({0, 1, 2});
    const int v = d.raw_accessor(R"({"bufferView":2,"type":"VEC3","componentType":5126,"count":3})");
    d.accessor<float>({1, 2, 3, 99, 4, 5, 6, 99, 7, 8, 9, 99}, "VEC4", 5126, 4);
    d.extend_last_view(R"(,"byteStride":16)");
    const scene::Scene s = repaired(
        d,
        one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", p)) +
            fmt::format(R"(,"animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}],)"
                        R"("samplers":[{{"input":{},"output":{}}}]}}])",
                        t, v),
        "1 stride where there should be none");
    EXPECT_EQ(glm::dvec3(s.nodes.at(0).transform->evaluate(1)[3]), glm::dvec3(4, 5, 6));
}

TEST(GltfRepairs, BoundsAreComputed)
{
    Document d;
    const int missing = d.floats(k_triangle, "VEC3", 3);
    repaired(d, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", missing)),
             "1 accessor whose min and max are missing or wrong: computed");
    Document e;
    const int wrong = e.accessor(k_triangle, "VEC3", 5126, 3, R"(,"min":[0,0,0],"max":[1,2,0])");
    repaired(e, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", wrong)),
             "1 accessor whose min and max are missing or wrong: computed");
}

TEST(GltfRepairs, NumbersAreClampedAndInterpolationsAreLinear)
{
    const Document d;
    const scene::Scene plain = d.load(R"("nodes":[{}])");
    EXPECT_TRUE(plain.warnings.empty());
    repaired(d, R"("materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1.00000012,1,1,1]}}])",
             "1 number is out of range: clamped");
    Document e;
    const int p = e.positions(k_triangle), t = e.times({0, 1}), v = e.floats({0, 0, 0, 1, 0, 0}, "VEC3", 3);
    const scene::Scene s = repaired(
        e,
        one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", p)) +
            fmt::format(R"(,"animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}],)"
                        R"("samplers":[{{"input":{},"output":{},"interpolation":9729}}]}}])",
                        t, v),
        "1 interpolation is a number: taken as LINEAR");
    EXPECT_EQ(s.nodes.at(0).transform->evaluate(.5)[3].x, .5);
}

TEST(GltfRepairs, ATargetOfABufferViewIsAHint)
{
    Document d;
    const int p = d.positions(k_triangle);
    d.extend_last_view(R"(,"target":34963)");
    repaired(d, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", p)),
             "1 use of a buffer view for another kind of data");
}

TEST(GltfRepairs, OtherHarmlessErrors)
{
    Document d;
    const int p = d.positions(k_triangle);
    const std::string plain = one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", p));
    const auto mesh = [&](const std::string& attributes) {
        return one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}{}}}}})", p, attributes));
    };
    const scene::Scene turned = repaired(d, R"("nodes":[{"rotation":[0,0,0,0]},{"rotation":[0,0,0,0.5]}])",
                                         "2 rotations are not of unit length");
    EXPECT_EQ(turned.nodes[0].local, glm::dmat4(1));
    EXPECT_EQ(turned.nodes[1].local, glm::dmat4(1));
    const scene::Scene sheared = repaired(d, R"("nodes":[{"matrix":[1,0,0,0,1,1,0,0,0,0,1,0,0,0,0,1]}])",
                                          "1 matrix of a node is not made of translation, rotation and scale");
    EXPECT_EQ(sheared.nodes[0].local[1].x, 1);
    repaired(d, mesh(",\"FACE\":0"), "1 attribute that glTF does not have: left out");
    const int uv = d.floats({0, 0, 1, 0, 0, 1}, "VEC2", 2);
    repaired(d, mesh(fmt::format(",\"TEXCOORD_1\":{}", uv)), "1 set of attributes without the set before it");
    repaired(d, plain + R"(,"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":2,"zfar":1}}])",
             "1 camera whose far plane is not behind its near one");
    repaired(d,
             R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot","spot":{"innerConeAngle":0.5,)"
             R"("outerConeAngle":0.5}}]}})",
             "1 spot light whose outer angle is not beyond its inner one",
             R"("extensionsUsed":["KHR_lights_punctual"],)");
    repaired(d, R"("materials":[{"extensions":{"KHR_materials_unlit":{}}}])",
             "1 extension is not listed where it should be");
    repaired(d, R"("nodes":[{"extensions":{"KHR_materials_unlit":{}}}])",
             "1 extension where it has no meaning: left out", R"("extensionsUsed":["KHR_materials_unlit"],)");
    const Document e;
    repaired(e, R"("buffers":[{"byteLength":3,"uri":"data:;base64,AAAA"}])", "1 buffer in a data URI of another type");
}

TEST(GltfRepairs, OffsetsAndJointsAreReadAsTheyAre)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int c = d.accessor<std::uint8_t>(std::vector<std::uint8_t>(9, 255), "VEC3", 5121, 3, ",\"normalized\":true");
    const scene::Scene packed =
        repaired(d, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"COLOR_0":{}}}}})", p, c)),
                 "1 offset or stride is not aligned: read as declared");
    EXPECT_EQ(packed.meshes.at(0).colors.at(2), glm::vec4(1));
    const int twice = d.accessor<std::uint8_t>(std::vector<std::uint8_t>(12, 0), "VEC4", 5121, 4);
    const int halves = d.floats({.5f, .5f, 0, 0, .5f, .5f, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    repaired(d, skinned(p, twice, halves), "2 vertices that use a joint twice: its weights are added");
    const int j = d.accessor<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", 5121, 4);
    repaired(
        d,
        fmt::format(
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{},"JOINTS_0":{},"WEIGHTS_0":{}}}}}]}}],)"
            R"("nodes":[{{"mesh":0,"skin":0}},{{}},{{}}],"skins":[{{"joints":[1,2]}}],"scenes":[{{"nodes":[0,1,2]}}])",
            p, j, halves),
        "1 skin whose joints have no common root: used as they are");
    repaired(
        d,
        fmt::format(R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],)"
                    R"("nodes":[{{"mesh":0,"skin":0}},{{}}],"skins":[{{"joints":[1]}}],"scenes":[{{"nodes":[0,1]}}])",
                    p),
        "1 skin on a node whose mesh has no joints: left out");
}

TEST(GltfRepairs, ListsOfMorphTargetsAreMadeToFit)
{
    Document d;
    const int p = d.positions(k_triangle), n = d.floats(k_up, "VEC3", 3);
    const std::string target = fmt::format(R"("targets":[{{"POSITION":{}}}])", p);
    const auto mesh = [&](const std::string& targets, const std::string& more) {
        return fmt::format(
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}},{}}}]{}}}],"nodes":[{{"mesh":0}}])", p,
            targets, more);
    };
    repaired(d, mesh(target, R"(,"weights":[1,2])"),
             "1 list of weights is not as long as there are morph targets: cut");
    repaired(d, mesh(fmt::format(R"("targets":[{{"POSITION":{},"NORMAL":{}}}])", p, n), ""),
             "1 attribute of a morph target that the primitive lacks: left out");
}

TEST(GltfRepairs, ImagesTellTheirTypeThemselves)
{
    Document d;
    d.positions(k_triangle);
    repaired(d, R"("images":[{"bufferView":0}])", "1 image without its type, or with two sources or none");
    repaired(d, R"("images":[{}])", "1 image without its type, or with two sources or none");
}

TEST(GltfRepairs, AByteOrderMarkIsSkipped)
{
    test::ScratchFolder folder;
    std::ofstream(folder / "a.gltf") << "\xef\xbb\xbf"
                                        R"({"asset":{"version":"2.0"},"nodes":[{}]})";
    const scene::Scene scene = io::load_gltf(folder / "a.gltf");
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find("1 byte order mark before the JSON: skipped"), std::string::npos);
    io::ReadOptions strict;
    strict.strict = true;
    EXPECT_THROW(io::load_gltf(folder / "a.gltf", {}, strict), InputError);
}

// An animation of the translation of node 0 of a mesh.
std::string moving(int positions, int input, int output, const std::string& node = "",
                   const std::string& path = "translation")
{
    return fmt::format(R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],"nodes":[{{"mesh":0{}}}],)"
                       R"("animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"{}"}}}}],)"
                       R"("samplers":[{{"input":{},"output":{}}}]}}])",
                       positions, node, path, input, output);
}

TEST(GltfRepairs, KeysThatAreNotLaterAreLeftOut)
{
    Document d;
    const int p = d.positions(k_triangle), t = d.times({0, 1, 1, .5f, 2});
    const int v = d.floats({0, 0, 0, 1, 0, 0, 7, 0, 0, 8, 0, 0, 3, 0, 0}, "VEC3", 3);
    const scene::Scene s =
        repaired(d, moving(p, t, v), "2 keys of animations are not later than those before them: left out");
    EXPECT_EQ(s.nodes.at(0).transform->evaluate(1)[3].x, 1);
    EXPECT_EQ(s.nodes.at(0).transform->evaluate(1.5)[3].x, 2);
    EXPECT_EQ(s.timeline.end, 2);
}

TEST(GltfRepairs, KeysBeforeZeroAreUsed)
{
    Document d;
    const int p = d.positions(k_triangle), t = d.times({-1, 1}), v = d.floats({0, 0, 0, 4, 0, 0}, "VEC3", 3);
    const scene::Scene s = repaired(d, moving(p, t, v), "1 key of an animation has a negative time: used as they are");
    EXPECT_EQ(s.nodes.at(0).transform->evaluate(0)[3].x, 2);
    EXPECT_EQ(s.timeline.start, -1);
}

TEST(GltfRepairs, ChannelsWithoutAValueForEachKeyAreLeftOut)
{
    Document d;
    const int p = d.positions(k_triangle), t = d.times({0, 1, 2}), v = d.floats({0, 0, 0, 4, 0, 0}, "VEC3", 3);
    const int good = d.floats({0, 0, 0, 4, 0, 0, 5, 0, 0}, "VEC3", 3);
    const std::string rest = fmt::format(
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{0}}}}}]}}],"nodes":[{{"mesh":0}}],)"
        R"("animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"scale"}}}},)"
        R"({{"sampler":1,"target":{{"node":0,"path":"translation"}}}}],"samplers":[{{"input":{1},"output":{2}}},)"
        R"({{"input":{1},"output":{3}}}]}}])",
        p, t, v, good);
    const scene::Scene s =
        repaired(d, rest, "1 channel of an animation whose values are not as many as its keys: left out");
    EXPECT_EQ(s.nodes.at(0).transform->evaluate(1), glm::translate(glm::dmat4(1), glm::dvec3(4, 0, 0)));
}

TEST(GltfRepairs, AnimatedMatricesAreTakenApart)
{
    Document d;
    const int p = d.positions(k_triangle), t = d.times({0, 1}), v = d.floats({1, 2, 3, 4, 5, 6}, "VEC3", 3);
    // A quarter turn about z, scaled by 2, 3 and 4, mirrored.
    const scene::Scene s = repaired(d, moving(p, t, v, R"(,"matrix":[0,-2,0,0,-3,0,0,0,0,0,4,0,9,9,9,1])"),
                                    "1 matrix of a node that is animated");
    const glm::dmat4 m = s.nodes.at(0).transform->evaluate(0);
    const glm::dmat4 expected(0, -2, 0, 0, -3, 0, 0, 0, 0, 0, 4, 0, 1, 2, 3, 1);
    for (int c = 0; c < 4; ++c) EXPECT_LT(glm::length(m[c] - expected[c]), 1e-6) << c;
}

TEST(GltfRepairs, AMatrixBesideOtherPlacementsIsUsed)
{
    const Document d;
    const scene::Scene s =
        repaired(d, R"("nodes":[{"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1],"translation":[7,0,0]}])",
                 "1 node has a matrix beside translation, rotation or scale: the matrix is used");
    EXPECT_EQ(s.nodes.at(0).local[3].x, 5);
}

TEST(GltfRepairs, NullPropertiesAreAbsent)
{
    const Document d;
    const scene::Scene s =
        repaired(d, R"("nodes":[{"name":null,"extras":{"own":null}}],"materials":null,"cameras":null)",
                 "3 properties are null: taken as absent");
    EXPECT_EQ(s.nodes.size(), 1u);
}

TEST(GltfRepairs, AccessorsWithoutElementsLeaveOutWhatUsesThem)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int none = d.raw_accessor(R"({"type":"VEC3","componentType":5126,"count":0})");
    const int no_indices = d.raw_accessor(R"({"type":"SCALAR","componentType":5123,"count":0})");
    const scene::Scene s = repaired(
        d,
        fmt::format(
            R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":{0}}}}},{{"attributes":{{"POSITION":{1}}}}},)"
            R"({{"attributes":{{"POSITION":{0}}},"indices":{2}}}]}},{{"primitives":[{{"attributes":{{"POSITION":{1}}}}}]}}],)"
            R"("nodes":[{{"mesh":0}},{{"mesh":1}}])",
            p, none, no_indices),
        "2 accessors have no elements: what uses them is left out");
    EXPECT_EQ(s.meshes.size(), 1u);
    EXPECT_EQ(s.meshes.at(0).triangles.size(), 1u);
    Document e;
    const scene::Scene empty =
        repaired(e,
                 fmt::format(R"("meshes":[{{"primitives":[]}},{{"primitives":[{{"attributes":{{"POSITION":{}}}}}]}}],)"
                             R"("nodes":[{{"mesh":0}},{{"mesh":1}}])",
                             e.positions(k_triangle)),
                 "1 array is empty");
    EXPECT_EQ(empty.objects.size(), 1u);
}

TEST(GltfRepairs, ASpotWithoutAConeHasThatOfTheFormat)
{
    const Document d;
    const scene::Scene s = repaired(d,
                                    R"("extensions":{"KHR_lights_punctual":{"lights":[{"type":"spot"}]}},)"
                                    R"("nodes":[{"extensions":{"KHR_lights_punctual":{"light":0}}}])",
                                    "1 spot light has no cone: that of 45 degrees is used",
                                    R"("extensionsUsed":["KHR_lights_punctual"],)");
    EXPECT_NEAR(s.lights.at(0).outer_angle, .785398, 1e-6);
    EXPECT_EQ(s.lights.at(0).inner_angle, 0);
}

TEST(GltfRepairs, AttributesThatAreNotFiniteAreZeroAndPositionsAreRefused)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    Document d;
    const int p = d.positions(k_triangle), n = d.floats({nan, 0, 0, 0, 0, 1, 0, 0, 1}, "VEC3", 3);
    const int uv = d.floats({0, nan, 1, 0, 0, std::numeric_limits<float>::infinity()}, "VEC2", 2);
    const scene::Scene s = repaired(
        d, one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{},"NORMAL":{},"TEXCOORD_0":{}}}}})", p, n, uv)),
        "3 vectors of vertices are not finite: taken as zero");
    EXPECT_EQ(s.meshes.at(0).normals.at(0), glm::vec3(0, 0, 1));   // that of the face
    EXPECT_EQ(s.meshes.at(0).texcoords[0].at(0), glm::vec2(0));
    EXPECT_EQ(s.meshes.at(0).texcoords[0].at(1), glm::vec2(1, 0));
    const int bad = d.floats({nan, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
    for (const bool strict : {false, true})
        EXPECT_THROW(
            d.load(one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}}}})", bad)), "", {.strict = strict}),
            InputError);
}

TEST(GltfRepairs, ImagesElsewhereAreLookedForByNameAndNothingOutsideIsOpened)
{
    test::ScratchFolder folder;
    std::filesystem::create_directory(folder / "scene");
    std::ofstream(folder / "t.png") << "no image: opening it would be an error";
    const auto load = [&](const std::string& uri, bool strict) {
        std::ofstream(folder / "scene" / "a.gltf") << fmt::format(
            R"({{"asset":{{"version":"2.0"}},"images":[{{"uri":"{}"}}],"textures":[{{"source":0}}],)"
            R"("materials":[{{"emissiveTexture":{{"index":0}}}}],"meshes":[{{"primitives":[{{"attributes":)"
            R"({{"POSITION":0,"TEXCOORD_0":1}},"material":0}}]}}],"nodes":[{{"mesh":0}}],"accessors":[)"
            R"({{"type":"VEC3","componentType":5126,"count":3,"min":[0,0,0],"max":[0,0,0]}},)"
            R"({{"type":"VEC2","componentType":5126,"count":3}}]}})",
            uri);
        io::ReadOptions options;
        options.strict = strict;
        return io::load_gltf(folder / "scene" / "a.gltf", {}, options);
    };
    for (const char* const uri :
         {"../t.png", "/t.png", "C:/textures/t.png", "C:\\textures\\t.png", "file:///C:/t.png", "100%.png"}) {
        const scene::Scene s = load(uri, false);
        const auto missing = std::count_if(s.warnings.begin(), s.warnings.end(), [](const std::string& w) {
            return w.find("1 image file does not exist: replaced by a neutral texel") != std::string::npos;
        });
        EXPECT_EQ(missing, 1) << uri;
        // Two more are about accessors without data.
        EXPECT_EQ(s.warnings.size(), uri == std::string("100%.png") ? 4u : 3u) << uri;
    }
    for (const char* const uri : {"../t.png", "/t.png", "file:///C:/t.png", "100%.png"})
        EXPECT_THROW(load(uri, true), InputError) << uri;
}

TEST(GltfRepairs, TheSameProblemAtManyPlacesIsOneWarning)
{
    Document d;
    const int p = d.positions(k_triangle);
    std::string primitives;
    for (int i = 0; i < 40; ++i)
        primitives += fmt::format(R"({}{{"attributes":{{"POSITION":{}}},"mode":1}})", i ? "," : "", p);
    const scene::Scene s =
        d.load(fmt::format(R"("meshes":[{{"primitives":[{}]}}],"nodes":[{{"mesh":0}}])", primitives));
    const auto lines = std::count_if(s.warnings.begin(), s.warnings.end(), [](const std::string& w) {
        return w.find("points and lines are not drawn") != std::string::npos;
    });
    EXPECT_EQ(lines, 1);
    EXPECT_NE(s.warnings.at(0).find("and 39 more: points and lines are not drawn"), std::string::npos) << s.warnings[0];
}

TEST(GltfRepairs, FilesOfVersionOneSaySo)
{
    test::ScratchFolder folder;
    for (const char* const text : {R"({"asset":{"version":"1.0"},"nodes":{"a":{}}})", R"({"nodes":{"a":{}}})"}) {
        std::ofstream(folder / "a.gltf") << text;
        try {
            io::load_gltf(folder / "a.gltf");
            ADD_FAILURE();
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("glTF 1.0 is not supported; convert it"), std::string::npos)
                << error.what();
        }
    }
}

TEST(GltfRepairs, WhatCannotBeReadSafelyIsRefusedInBothModes)
{
    Document d;
    const int p = d.positions(k_triangle);
    const int beyond = d.accessor<std::uint8_t>({0, 1, 3}, "SCALAR", 5121, 1);
    const int j = d.accessor<std::uint8_t>(std::vector<std::uint8_t>(12, 7), "VEC4", 5121, 4);
    const int w = d.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", 4);
    for (const bool strict : {false, true})
        for (const std::string& rest :
             {one_mesh(fmt::format(R"({{"attributes":{{"POSITION":{}}},"indices":{}}})", p, beyond)), skinned(p, j, w),
              std::string(R"("nodes":[{"children":[1]},{"children":[0]}])"), std::string(R"("nodes":[{"mesh":3}])")})
            EXPECT_THROW(d.load(rest, "", {.strict = strict}), InputError) << rest;
}

TEST(MeshRepairs, WeightsThatOverflowAndThoseThatAreZero)
{
    std::vector<glm::vec4> sets[2] = {{{3e38f, 3e38f, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {.5f, 0, 0, 0}},
                                      {{3e38f, 3e38f, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}, {.5f, 0, 0, 0}}};
    EXPECT_EQ(scene::normalize_weights(sets, 1e-3f), 2u);
    EXPECT_EQ(sets[0][0], glm::vec4(.25f, .25f, 0, 0));
    EXPECT_EQ(sets[1][0], glm::vec4(.25f, .25f, 0, 0));
    EXPECT_EQ(sets[0][1], glm::vec4(1, 0, 0, 0));
    EXPECT_EQ(sets[0][2], glm::vec4(1, 0, 0, 0));
    EXPECT_EQ(sets[1][3], glm::vec4(.5f, 0, 0, 0));
}

TEST(MeshRepairs, LongVectorsKeepTheirDirection)
{
    EXPECT_EQ(scene::unit_or({0, 3e38f, 0}, {}), glm::vec3(0, 1, 0));
    EXPECT_EQ(scene::unit_or({0, 1e-5f, 0}, {1, 0, 0}), glm::vec3(1, 0, 0));
    EXPECT_NEAR(glm::dot(scene::perpendicular_to({.6f, .8f, 0}), glm::vec3(.6f, .8f, 0)), 0, 1e-6);
}

}   // namespace
}   // namespace gnomon
