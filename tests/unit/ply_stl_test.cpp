// SPDX-License-Identifier: Apache-2.0
// PLY and STL: the same mesh from text and from binary files of either byte order, and what is refused.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>

#include "base/random.h"
#include "gnomon/error.h"
#include "io/load.h"
#include "support.h"

namespace gnomon {
namespace {

class PlyStl : public testing::Test {
 protected:
    scene::Scene load(const std::string& name, const std::string& bytes, bool strict = false)
    {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
        return io::load_scene(folder_ / name, {}, {.strict = strict});
    }
    // The message of the refusal, without the file's name.
    std::string refusal(const std::string& name, const std::string& bytes, bool strict = false)
    {
        try {
            load(name, bytes, strict);
        } catch (const InputError& error) {
            return error.place() + ": " + error.problem();
        }
        return "accepted";
    }
    test::ScratchFolder folder_;
};

// A number of a binary file.
template <class T>
std::string raw(T value, bool big)
{
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (big) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

const char* const k_ply_properties =
    "element vertex 5\nproperty float x\nproperty double y\nproperty float32 z\nproperty uchar red\n"
    "property uint8 green\nproperty uchar blue\nproperty short quality\nelement face 3\n"
    "property list uchar int vertex_indices\nproperty uchar flags\nelement edge 1\nproperty int a\n"
    "property list ushort float b\nend_header\n";

std::string binary_ply(bool big)
{
    std::string s = fmt::format("ply\nformat binary_{}_endian 1.0\ncomment made here\n{}", big ? "big" : "little",
                                k_ply_properties);
    const float x[] = {0, 1, 1, 0, .5f};
    const double y[] = {0, 0, 1, 1, .5};
    const float z[] = {0, 0, 0, 0, 2};
    for (int i = 0; i < 5; ++i) {
        s += raw(x[i], big) + raw(y[i], big) + raw(z[i], big);
        s += std::string("\xff\x80\0", 3) + raw(std::int16_t{-7}, big);
    }
    const auto face = [&](std::initializer_list<std::int32_t> list) {
        s += static_cast<char>(list.size());
        for (const std::int32_t i : list) s += raw(i, big);
        s += '\1';
    };
    face({0, 1, 2, 3}), face({0, 1, 4}), face({1, 2, 4});
    return s + raw(std::int32_t{3}, big) + raw(std::uint16_t{2}, big) + raw(1.5f, big) + raw(2.5f, big);
}

std::string text_ply()
{
    return std::string("ply\r\nformat ascii 1.0\r\n") + k_ply_properties +
           "0 0 0 255 128 0 -7\n1 0 0 255 128 0 -7\n1 1 0 255 128 0 -7\n+0 1e0 0 255 128 0 -7\n.5 .5 2 255 128 0 -7\n"
           "4 0 1 2 3 1\n3 0 1 4 1\n3 1 2 4 1\n3 2 1.5 2.5";
}

TEST_F(PlyStl, AllFormatsOfPlyGiveTheSameMesh)
{
    for (const std::string& bytes : {text_ply(), binary_ply(false), binary_ply(true)}) {
        const scene::Scene s = load("a.ply", bytes);
        EXPECT_TRUE(s.warnings.empty());
        ASSERT_EQ(s.meshes.size(), 1u);
        const scene::Mesh& m = s.meshes[0];
        EXPECT_EQ(m.triangles.size(), 4u);
        EXPECT_EQ(s.bounds(0).low, glm::vec3(0));
        EXPECT_EQ(s.bounds(0).high, glm::vec3(1, 1, 2));
        ASSERT_EQ(m.colors.size(), m.positions.size());
        EXPECT_EQ(m.colors[0].x, 1);
        EXPECT_NEAR(m.colors[0].y, .2158f, 1e-3f);   // 128 in sRGB
        EXPECT_EQ(m.colors[0].w, 1);
        EXPECT_EQ(s.materials.at(0).base_color, glm::vec3(1));
    }
}

TEST_F(PlyStl, PlyWithNormalsTextureCoordinatesAndStrips)
{
    const scene::Scene s =
        load("a.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty "
             "float nx\n"
             "property float ny\nproperty float nz\nproperty float s\nproperty float t\nelement tristrips 1\n"
             "property list int int vertex_indices\nend_header\n0 0 0 0 0 5 0 0\n1 0 0 0 0 5 1 0\n0 1 0 0 0 5 0 1\n"
             "1 1 0 0 0 5 1 1\n9 0 1 2 3 -1 0 1 2 -1\n");
    const scene::Mesh& m = s.meshes.at(0);
    ASSERT_EQ(m.triangles.size(), 3u);
    for (const glm::uvec3& t : m.triangles)
        EXPECT_GT(glm::cross(m.positions[t.y] - m.positions[t.x], m.positions[t.z] - m.positions[t.x]).z, 0);
    for (const glm::vec3& n : m.normals) EXPECT_EQ(n, glm::vec3(0, 0, 1));
    for (std::size_t i = 0; i < m.positions.size(); ++i)
        EXPECT_EQ(m.texcoords[0][i], glm::vec2(m.positions[i].x, 1 - m.positions[i].y));
}

TEST_F(PlyStl, FacesHaveTheirOwnColours)
{
    const scene::Scene s =
        load("a.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
             "element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\n"
             "property uchar blue\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n");
    const scene::Mesh& m = s.meshes.at(0);
    ASSERT_EQ(m.triangles.size(), 2u);
    ASSERT_EQ(m.colors.size(), m.positions.size());
    EXPECT_EQ(m.positions.size(), 6u) << "the corners that both faces have differ in colour";
    for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(m.colors[m.triangles[0][c]], glm::vec4(1, 0, 0, 1));
        EXPECT_EQ(m.colors[m.triangles[1][c]], glm::vec4(0, 0, 1, 1));
        EXPECT_NEAR(m.normals[m.triangles[0][c]].z, 1, 1e-5f);
    }
    EXPECT_EQ(s.materials.at(0).base_color, glm::vec3(1));
}

TEST_F(PlyStl, APointCloudIsRefusedInOneLine)
{
    const std::string message =
        refusal("a.ply",
                "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
                "z\nend_header\n0 0 0\n1 1 1\n");
    EXPECT_NE(message.find("point cloud: 2 points"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST_F(PlyStl, BrokenPlyIsRefusedWithAPlace)
{
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
        "z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n";
    const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";
    EXPECT_EQ(load("a.ply", head + corners + "3 0 1 2").meshes.size(), 1u);
    EXPECT_EQ(refusal("a.ply", head + corners + "3 0 1 3"), "face 0: refers to vertex 3, but there are 3");
    EXPECT_EQ(refusal("a.ply", head + corners + "3 0 1 -1"), "line 13: -1 is not the number of a vertex");
    EXPECT_EQ(refusal("a.ply", head + corners + "3 0 1 0.5"), "line 13: 0.5 is not the number of a vertex");
    EXPECT_EQ(refusal("a.ply", head + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2"), "line 11: nan is not a finite number");
    EXPECT_EQ(refusal("a.ply", head + "0 0 0\n1 x 0\n0 1 0\n3 0 1 2"), "line 11: expected a number, found 'x'");
    EXPECT_EQ(refusal("a.ply", head + corners + "3 0 1").rfind("line 13: ", 0), 0u);
    EXPECT_EQ(refusal("a.ply", head + corners + "3000000000 0 1 2").rfind("line 13: a list of 3", 0), 0u);
    EXPECT_EQ(refusal("a.ply", "plyx\n"), "line 1: not a PLY file: it does not begin with 'ply'");
    EXPECT_EQ(refusal("a.ply", "ply\nformat ascii 1.0\n"), "line 3: the header does not end");
    EXPECT_EQ(refusal("a.ply", "ply\nformat utf 1.0\n"), "line 2: unknown format 'utf'");
    // A file that claims more than it holds is refused before memory is taken.
    for (const char* format : {"ascii", "binary_little_endian"})
        EXPECT_NE(
            refusal("a.ply", fmt::format("ply\nformat {} 1.0\nelement vertex 4000000000\nproperty float x\nproperty "
                                         "float y\nproperty float z\nend_header\n",
                                         format))
                .find("do not fit"),
            std::string::npos);
    for (const char* name : {"x", "y"})
        EXPECT_NE(refusal("a.ply", std::string("ply\nformat ascii 1.0\nelement vertex 1\nproperty float ") + name +
                                       "\nend_header\n0\n")
                      .find("without x, y and z"),
                  std::string::npos);
}

std::string binary_stl(const std::string& name = "made here")
{
    std::string s = name;
    s.resize(80, ' ');
    s += raw(std::uint32_t{2}, false);
    const float corners[2][9] = {{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, -0.0f, 1, 0}};
    for (const auto& facet : corners) {
        for (int i = 0; i < 3; ++i) s += raw(0.0f, false);
        for (const float x : facet) s += raw(x, false);
        s += std::string(2, '\0');
    }
    return s;
}

const char* const k_text_stl =
    "solid one two\n facet normal nan 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0\n  endloop\n"
    " endfacet\n FACET NORMAL 0 0 1\n  OUTER LOOP\n   VERTEX 0 0 0\n   VERTEX 1 1 0\n   VERTEX 0 1 0\n  ENDLOOP\n"
    " ENDFACET\nendsolid one two\nsolid empty\nendsolid empty\n";

TEST_F(PlyStl, TextAndBinaryStlGiveTheSameMeshWithSharedCorners)
{
    for (const std::string& bytes : {std::string(k_text_stl), binary_stl(), binary_stl("solid by name alone")}) {
        const scene::Scene s = load("a.stl", bytes);
        EXPECT_TRUE(s.warnings.empty());
        ASSERT_EQ(s.meshes.size(), 1u);
        EXPECT_EQ(s.meshes[0].triangles.size(), 2u);
        EXPECT_EQ(s.meshes[0].positions.size(), 4u);   // of six corners
        for (const glm::vec3& n : s.meshes[0].normals) EXPECT_EQ(n, glm::vec3(0, 0, 1));
    }
    EXPECT_EQ(load("a.stl", k_text_stl).meshes[0].name, "one two");
    EXPECT_EQ(load("a.stl", binary_stl() + "more").warnings.size(), 1u);
    EXPECT_EQ(load("a.stl", std::string("\xef\xbb\xbf") + k_text_stl).meshes[0].triangles.size(), 2u);
}

// Programs that write facets as they find them leave 0 or the largest number in the header.
TEST_F(PlyStl, StlWithoutANumberOfFacetsIsReadByItsLength)
{
    for (const std::uint32_t unknown : {0u, 0xffffffffu}) {
        std::string bytes = binary_stl();
        bytes.replace(80, 4, raw(unknown, false));
        const scene::Scene s = load("a.stl", bytes);
        EXPECT_EQ(s.meshes.at(0).triangles.size(), 2u);
        ASSERT_EQ(s.warnings.size(), 1u);
        EXPECT_NE(s.warnings[0].find("2 are read"), std::string::npos) << s.warnings[0];
    }
    std::string none = binary_stl().substr(0, 84);
    none.replace(80, 4, raw(0u, false));
    EXPECT_TRUE(load("a.stl", none).meshes.empty());
}

TEST_F(PlyStl, BrokenStlIsRefusedWithAPlace)
{
    EXPECT_EQ(refusal("a.stl", binary_stl().substr(0, 150)).rfind("byte 80: declares 2 facets", 0), 0u);
    EXPECT_EQ(refusal("a.stl", "short"), "byte 0: is neither text that begins with 'solid' nor a binary STL");
    std::string wild = binary_stl();
    wild.replace(84 + 12, 4, raw(std::numeric_limits<float>::infinity(), false));
    EXPECT_EQ(refusal("a.stl", wild, true), "byte 96: inf is not a coordinate");
    std::string many = binary_stl();
    many.replace(80, 4, raw(0xfffffffeu, false));
    EXPECT_EQ(refusal("a.stl", many).rfind("byte 80: ", 0), 0u);
    EXPECT_NE(refusal("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n")
                  .find("expected 'vertex', found 'endloop'"),
              std::string::npos);
    EXPECT_NE(refusal("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n").find("a coordinate"),
              std::string::npos);
}

// Programs write normals that are no numbers where faces have no area.
TEST_F(PlyStl, ValuesOfPlyThatAreNotFiniteAreRepairedWhereThatIsSafe)
{
    const std::string bytes =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n"
        "property float red\nproperty float green\nproperty float blue\nelement face 1\n"
        "property list uchar int vertex_index\nend_header\n"
        "0 0 0 nan nan nan 0 0 1 1 1\n1 0 0 0 inf 0 1 nan 1 1 1\n0 1 0 0 0 1 1 1 1 -nan 1\n3 0 1 2\n";
    const scene::Scene s = load("a.ply", bytes);
    ASSERT_EQ(s.warnings.size(), 2u);
    EXPECT_EQ(s.warnings[0], "2 normals are not finite: computed from faces");
    EXPECT_EQ(s.warnings[1], "2 values of texture coordinates and colours are not finite: set to 0");
    for (const glm::vec3& n : s.meshes.at(0).normals) EXPECT_EQ(n, glm::vec3(0, 0, 1));
    EXPECT_EQ(refusal("a.ply", bytes, true), "line 18: the normal is not finite");
}

TEST_F(PlyStl, LinesMayEndInCarriageReturns)
{
    const auto returns = [](std::string text) {
        std::erase(text, '\r');
        std::replace(text.begin(), text.end(), '\n', '\r');
        return text;
    };
    EXPECT_EQ(load("a.ply", returns(text_ply())).meshes.at(0).triangles.size(), 4u);
    EXPECT_EQ(load("a.stl", returns(k_text_stl)).meshes.at(0).triangles.size(), 2u);
    // The first byte of a binary body may be that of a line feed.
    std::string binary = binary_ply(false);
    const std::size_t body = binary.find("end_header\n") + 11;
    binary = returns(binary.substr(0, body)) + '\n' + binary.substr(body + 1);
    EXPECT_EQ(load("a.ply", binary).meshes.at(0).triangles.size(), 4u);
}

TEST_F(PlyStl, FacetsWithoutNumbersAndCommentsOfStlAreLeftOut)
{
    std::string text = k_text_stl;
    text.replace(text.find("vertex 1 1 0"), 12, "vertex nan 1 0");
    text.replace(text.find(" FACET NORMAL"), 0, "; by a program\n// of another kind\n");
    const scene::Scene s = load("a.stl", text);
    EXPECT_EQ(s.meshes.at(0).triangles.size(), 1u);
    ASSERT_EQ(s.warnings.size(), 2u);
    EXPECT_EQ(s.warnings[0], "1 facet has corners that are not finite: left out");
    EXPECT_EQ(s.warnings[1], "line 9: 2 lines are neither a facet nor the end of a solid: ignored");
    EXPECT_NE(refusal("a.stl", text, true), "accepted");
    std::string binary = binary_stl();
    binary.replace(84 + 12, 4, raw(std::numeric_limits<float>::quiet_NaN(), false));
    EXPECT_EQ(load("a.stl", binary).meshes.at(0).triangles.size(), 1u);
    // Text that is no STL is refused, however it begins.
    std::string prose = "solid ground\n";
    for (int i = 0; i < 2000; ++i) prose += "is what it stands on\n";
    EXPECT_EQ(refusal("a.stl", prose), "1002:1: expected a facet, found 'is'");
}

// Files with changed or missing bytes are read or refused, and nothing else.
TEST_F(PlyStl, ChangedBytesAreReadOrRefused)
{
    Random random(3);
    int refused = 0;
    for (const auto& [name, seed] :
         {std::pair("a.ply", text_ply()), std::pair("a.ply", binary_ply(false)), std::pair("a.ply", binary_ply(true)),
          std::pair("a.stl", binary_stl()), std::pair("a.stl", std::string(k_text_stl))})
        for (int round = 0; round < 300; ++round) {
            std::string bytes = seed;
            for (std::uint32_t i = 0; i <= random.below(3); ++i)
                bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] = static_cast<char>(random.below(256));
            if (round % 5 == 0) bytes.resize(random.below(static_cast<std::uint32_t>(bytes.size())));
            refused += refusal(name, bytes) != "accepted";
        }
    EXPECT_GT(refused, 300);
}

}   // namespace
}   // namespace gnomon
