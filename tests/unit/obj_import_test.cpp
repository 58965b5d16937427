// SPDX-License-Identifier: Apache-2.0
// Features of OBJ, each in the smallest file that uses it.
#include <fmt/format.h>

#include <fstream>

#include "gnomon/error.h"
#include "io/image/image_file.h"
#include "io/load.h"
#include "support.h"

namespace gnomon::io {
namespace {

class ObjImport : public ::testing::Test {
 protected:
    void put(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
    scene::Scene load(const std::string& text)
    {
        put("scene.obj", text);
        return load_obj(folder_ / "scene.obj");
    }
    std::string place_of_error(const std::string& text)
    {
        try {
            load(text);
        } catch (const InputError& error) {
            EXPECT_NE(error.file().find("scene.obj"), std::string::npos);
            return error.place();
        }
        return "no error";
    }
    static bool warned(const scene::Scene& scene, const std::string& word)
    {
        for (const std::string& warning : scene.warnings)
            if (warning.find(word) != std::string::npos) return true;
        return false;
    }
    test::ScratchFolder folder_;
};

const std::string k_square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST_F(ObjImport, ReadsEveryFormOfCorner)
{
    const scene::Scene scene = load(k_square +
                                    "vt 0 0\nvt 1 0.25\nvn 0 0 2\nf 1 2 3\nf 1/1 2/2 3/1\nf 1//1 2//1 3//1\n"
                                    "f 1/1/1 2/2/1 3/1/1\nf -4/-2/-1 -3/-1/-1 -2/-2/-1\nf 1/ 2/ 3/\nf 1// 2// 3//\n");
    ASSERT_EQ(scene.meshes.size(), 1u);
    const scene::Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(mesh.triangles.size(), 7u);
    // The last two triangles, with all three indices, use the same vertices.
    EXPECT_EQ(mesh.triangles[3], mesh.triangles[4]);
    const std::uint32_t corner = mesh.triangles[3].y;
    EXPECT_EQ(mesh.positions[corner], glm::vec3(1, 0, 0));
    EXPECT_EQ(mesh.normals[corner], glm::vec3(0, 0, 1));         // normalised
    EXPECT_EQ(mesh.texcoords[0][corner], glm::vec2(1, 0.75f));   // v is flipped
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
}

// Programs write these where faces have no area.
TEST_F(ObjImport, NumbersThatAreNotFiniteAreRepairedWhereThatIsSafe)
{
    const std::string normals = "vn nan nan nan\nvn -nan(ind) 0 1\nvn 0 1.#QNAN -1.#IND\nvn 0 0 1\n";
    const std::string file = k_square + normals + "vt nan 0.5\nvt 1 -INF 0\nvt 0.25 1\nf 1/1/1 2/2/2 3/3/3\n";
    const scene::Scene scene = load(file);
    EXPECT_TRUE(warned(scene, "3 normals are not finite: computed from faces"));
    EXPECT_TRUE(warned(scene, "2 texture coordinates are not finite: set to 0"));
    EXPECT_EQ(scene.warnings.size(), 2u);
    ASSERT_EQ(scene.meshes.size(), 1u);
    for (const glm::vec3& normal : scene.meshes[0].normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(scene.meshes[0].texcoords[0][2], glm::vec2(0.25f, 0));

    EXPECT_EQ(place_of_error("v 0 nan 0\n"), "1:5") << "positions are not";
    EXPECT_EQ(place_of_error(k_square + "vn 0 x 1\n"), "5:6");
    EXPECT_THROW(load_obj(folder_ / "scene.obj", {}, {.strict = true}), InputError);
    put("scene.obj", file);
    EXPECT_THROW(load_obj(folder_ / "scene.obj", {}, {.strict = true}), InputError);
}

// Some programs write numbers as people do in their country.
TEST_F(ObjImport, DecimalCommasAreReadAsPoints)
{
    put("m.mtl", "newmtl m\nKd 0,25 0,5 1\nPr 0,5\n");
    const std::string file = "mtllib m.mtl\nusemtl m\nv 0,5 0 0\nv 1,5e0 0 0\nv 1 1 -0,25\nf 1 2 3\n";
    const scene::Scene scene = load(file);
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].positions[0], glm::vec3(0.5f, 0, 0));
    EXPECT_EQ(scene.meshes[0].positions[2], glm::vec3(1, 1, -0.25f));
    EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(0.25f, 0.5f, 1));
    EXPECT_TRUE(warned(scene, "3 numbers have a decimal comma: read as a point"));
    EXPECT_EQ(scene.warnings.size(), 2u);
    EXPECT_THROW(load_obj(folder_ / "scene.obj", {}, {.strict = true}), InputError);
    EXPECT_EQ(place_of_error("v 1,000.5 0 0\n"), "1:3") << "which of the two is the point?";
    EXPECT_EQ(place_of_error("v 1,2,3 0 0\n"), "1:3");
}

TEST_F(ObjImport, LinesMayEndInCarriageReturns)
{
    std::string file = "# old\rmtllib m.mtl\rusemtl m\rv 0 0 0\rv 1 0 \\\r0\rv 1 1 0\rf 1 2 3\r";
    put("m.mtl", "newmtl m\rKd 1 0 0\r");
    const scene::Scene scene = load(file);
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
    EXPECT_EQ(scene.materials.at(0).base_color, glm::vec3(1, 0, 0));
    EXPECT_TRUE(scene.warnings.empty());
}

// Files that were moved from another computer name theirs as that one did.
TEST_F(ObjImport, FilesAreFoundUnderSimilarNames)
{
    std::filesystem::create_directory(folder_ / "Maps");
    write_png(folder_ / "Maps" / "Brick.png", Image8(2, 2, 3));
    write_png(folder_ / "wood.png", Image8(2, 2, 3));
    for (const auto& [written, found] : {std::pair("C:\\Users\\me\\wood.png", "wood.png"),
                                         {"/elsewhere/wood.png", "wood.png"},
                                         {"WOOD.PNG", "wood.png"},
                                         {"\"wood.png\"", "wood.png"},
                                         {"textures/wood.png", "wood.png"},
                                         {"../wood.png", "wood.png"},
                                         {"maps\\brick.png", "Maps/Brick.png"}}) {
        put("Scene.mtl", fmt::format("newmtl m\nmap_Kd {}\n", written));
        const scene::Scene scene = load("mtllib scene.mtl\nusemtl m\n" + k_square + "vt 0 0\nf 1/1 2/1 3/1\n");
        EXPECT_EQ(scene.textures.size(), 1u) << written;
        EXPECT_TRUE(warned(scene, fmt::format("'{}' is read instead", found))) << written;
        EXPECT_TRUE(warned(scene, "'Scene.mtl' is read instead"));
    }
    // A file outside the folder is none, whatever its name; one that has no similar name is left out.
    std::filesystem::create_symlink("/etc/passwd", folder_ / "passwd");
    for (const char* const name : {"PASSWD", "/etc/passwd", "../../etc/passwd", "Maps", "stone.png", "..", "/"}) {
        put("Scene.mtl", fmt::format("newmtl m\nmap_Kd {}\n", name));
        const scene::Scene scene = load("mtllib Scene.mtl\nusemtl m\n" + k_square + "vt 0 0\nf 1/1 2/1 3/1\n");
        EXPECT_TRUE(scene.textures.empty()) << name;
        EXPECT_TRUE(warned(scene, "is left out")) << name;
    }
}

TEST_F(ObjImport, ErrorsNameLineAndColumn)
{
    EXPECT_EQ(place_of_error(k_square + "f 1 2 5\n"), "5:7");
    EXPECT_EQ(place_of_error(k_square + "f 1 2 0\n"), "5:7");
    EXPECT_EQ(place_of_error(k_square + "f 1 -5 3\n"), "5:5");
    EXPECT_EQ(place_of_error(k_square + "f 1 2 99999999999999999999\n"), "5:7");
    EXPECT_EQ(place_of_error(k_square + "f 1 2 -9223372036854775808\n"), "5:7");
    EXPECT_EQ(place_of_error(k_square + "f 1/1 2 3\n"), "5:3");
    EXPECT_EQ(place_of_error("vn 0 0 1\n" + k_square + "f 1//2 2 3\n"), "6:3");
    EXPECT_EQ(place_of_error(k_square + "f 1 2 3x\n"), "5:7");
    EXPECT_EQ(place_of_error(k_square + "f 1 2 3/1/1/1\n"), "5:7");
    EXPECT_EQ(place_of_error(k_square + "f a b c\n"), "5:3");
    EXPECT_EQ(place_of_error("v 0 nan 0\n"), "1:5");
    EXPECT_EQ(place_of_error("v 0 0\n"), "1:6");
    EXPECT_EQ(place_of_error("v 0 0 1e30\n"), "1:7");
    EXPECT_EQ(place_of_error("vn 0 0 infx 1\n"), "1:8");
    EXPECT_EQ(place_of_error("vt x\n"), "1:4");
    EXPECT_EQ(place_of_error("s -1\n"), "1:3");
    EXPECT_EQ(place_of_error("nothing\nof it\n"), "");
    EXPECT_EQ(place_of_error(""), "");
}

TEST_F(ObjImport, AcceptsForwardIndices)
{
    EXPECT_EQ(load("f 1 2 3\n" + k_square).meshes[0].triangles.size(), 1u);
}

TEST_F(ObjImport, ComputesMissingNormals)
{
    const scene::Scene scene = load(k_square + "f 1//1 2//2 3//3 4//4\n");
    EXPECT_TRUE(warned(scene, "computed"));
    ASSERT_EQ(scene.meshes[0].normals.size(), 4u);
    EXPECT_EQ(scene.meshes[0].normals[0], glm::vec3(0, 0, 1));
}

TEST_F(ObjImport, ReadsColoursOfVertices)
{
    // As sRGB from 0 to 1 or to 255, with or without a weight before them; white where there is none.
    for (const char* text : {"v 0 0 0\nv 1 0 0 1 0 0.5019608\nv 1 1 0 1 0 1 0\nf 1 2 3\n",
                             "v 0 0 0\nv 1 0 0 255 0 128\nv 1 1 0 1 0 255 0\nf 1 2 3\n"}) {
        const scene::Scene scene = load(text);
        ASSERT_EQ(scene.meshes[0].colors.size(), 3u);
        EXPECT_EQ(scene.meshes[0].colors[0], glm::vec4(1));
        EXPECT_NEAR(scene.meshes[0].colors[1].x, 1, 1e-5f);
        EXPECT_EQ(scene.meshes[0].colors[1].y, 0);
        EXPECT_NEAR(scene.meshes[0].colors[1].z, 0.21586f, 1e-4f);
        EXPECT_NEAR(scene.meshes[0].colors[2].y, 1, 1e-5f);
        EXPECT_EQ(scene.meshes[0].colors[2].w, 1);
        // The grey of faces without a material would darken them.
        EXPECT_EQ(scene.materials[0].base_color, glm::vec3(1));
        EXPECT_TRUE(scene.warnings.empty());
    }
    EXPECT_TRUE(load(k_square + "f 1 2 3\n").meshes[0].colors.empty());
    // A weight alone is no colour.
    EXPECT_TRUE(load("v 0 0 0 1\nv 1 0 0 1\nv 1 1 0 1\nf 1 2 3\n").meshes[0].colors.empty());
    EXPECT_EQ(place_of_error("v 0 0 0 1 x 0\n"), "1:11");
}

TEST_F(ObjImport, WarnsOncePerIgnoredStatement)
{
    const scene::Scene scene =
        load("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2\nf 1\nf 1 2 3\nl 1 2\nl 2 3\np 1\nvp 1\nvp 2\ncurv 1\n");
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
    EXPECT_TRUE(scene.meshes[0].colors.empty());
    EXPECT_EQ(scene.warnings.size(), 4u);
    EXPECT_TRUE(warned(scene, "fewer than three"));
    EXPECT_TRUE(warned(scene, "lines"));
    EXPECT_TRUE(warned(scene, "'vp'"));
    EXPECT_TRUE(warned(scene, "'curv'"));
}

TEST_F(ObjImport, ObjectsAndGroupsBecomeNodes)
{
    const scene::Scene scene = load(k_square +
                                    "o house\nf 1 2 3\ng roof top\nf 2 3 4\no house\nf 1 3 4\no empty\n"
                                    "o tree\nusemtl a\nf 1 2 3\nusemtl b\nf 2 3 4\nusemtl a\nf 1 2 4\n");
    ASSERT_EQ(scene.nodes.size(), 3u);
    EXPECT_EQ(scene.nodes[0].name, "house");
    EXPECT_EQ(scene.nodes[1].name, "house/roof top");
    EXPECT_EQ(scene.nodes[2].name, "tree");
    EXPECT_EQ(scene.meshes[0].triangles.size(), 2u);
    EXPECT_EQ(scene.meshes[2].parts.size(), 1u);   // both names are undefined: one grey material
    EXPECT_EQ(scene.statistics().triangles, 6u);
}

TEST_F(ObjImport, MeshMayHaveSeveralMaterials)
{
    put("a b.mtl", "newmtl red one\nKd 1 0 0\r\nnewmtl blue\nKd 0 0 1\n");
    const scene::Scene scene = load("mtllib a b.mtl\n" + k_square +
                                    "usemtl red one \r\nf 1 2 3\nusemtl blue\nf 2 3 4\nusemtl red one\nf 1 2 4\n");
    ASSERT_EQ(scene.meshes.size(), 1u);
    ASSERT_EQ(scene.meshes[0].parts.size(), 2u);
    EXPECT_EQ(scene.meshes[0].parts[0].triangle_count, 2u);
    EXPECT_EQ(scene.materials[scene.meshes[0].parts[0].material].base_color, glm::vec3(1, 0, 0));
    EXPECT_EQ(scene.materials[scene.meshes[0].parts[1].material].base_color, glm::vec3(0, 0, 1));
    EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(ObjImport, ReadsSeveralLibrariesAndWarnsOfMissingOnes)
{
    put("one.mtl", "newmtl x\nKd 1 0 0\n");
    put("two.mtl", "newmtl x\nKd 0 1 0\nnewmtl y\nKd 0 0 1\n");
    const scene::Scene scene = load("mtllib none.mtl one.mtl\nmtllib two.mtl\n" + k_square +
                                    "usemtl x\nf 1 2 3\nusemtl y\nf 1 2 4\nusemtl z\n"
                                    "f 2 3 4\n");
    ASSERT_EQ(scene.materials.size(), 3u);
    EXPECT_EQ(scene.materials[0].base_color, glm::vec3(1, 0, 0));   // the first of two
    EXPECT_EQ(scene.materials[1].base_color, glm::vec3(0, 0, 1));
    EXPECT_TRUE(warned(scene, "'none.mtl'"));
    EXPECT_TRUE(warned(scene, "'z'"));
}

TEST_F(ObjImport, UsesCreaseAngleWithoutSmoothingGroups)
{
    // Two squares that meet at 45 degrees, and two at 90.
    const std::string gentle = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\nf 1 2 3 4\nf 2 5 6 3\n";
    const std::string sharp = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 1\nv 1 1 1\nf 1 2 3 4\nf 2 5 6 3\n";
    EXPECT_EQ(load(gentle).meshes[0].positions.size(), 6u);
    EXPECT_EQ(load(sharp).meshes[0].positions.size(), 8u);
    // A group smooths over any angle; `off` over none.
    EXPECT_EQ(load("s 1\n" + sharp).meshes[0].positions.size(), 6u);
    const scene::Scene flat = load("s off\n" + gentle);
    EXPECT_TRUE(flat.meshes[0].normals.empty());
    const scene::Scene smooth = load(gentle);
    const glm::vec3 expected = glm::normalize(glm::vec3(-std::sqrt(0.5f), 0, 1 + std::sqrt(0.5f)));
    for (std::size_t i = 0; i < 6; ++i) {
        if (smooth.meshes[0].positions[i].x != 1.0f) continue;
        EXPECT_LT(glm::length(smooth.meshes[0].normals[i] - expected), 1e-6f);
    }
}

// The corner of a cube, one side of which is cut into two triangles: all three sides count the same.
TEST_F(ObjImport, SmoothsByTheAnglesOfCorners)
{
    const scene::Scene scene = load(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 0\nv 1 0 1\nv 0 1 1\ns 1\n"
        "f 1 3 5\nf 1 5 2\nf 1 2 6 4\nf 1 4 7 3\n");
    const scene::Mesh& mesh = scene.meshes[0];
    int found = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        if (mesh.positions[i] != glm::vec3(0)) continue;
        EXPECT_LT(glm::length(mesh.normals[i] - glm::normalize(glm::vec3(-1, -1, -1))), 1e-6f);
        ++found;
    }
    EXPECT_GT(found, 0);
}

TEST_F(ObjImport, HandlesManyFacesAtOneVertex)
{
    std::string fan = "v 0 0 1\n";
    const int n = 60000;
    for (int i = 0; i < n; ++i)
        fan += "v " + std::to_string(std::cos(i * 1e-4)) + " " + std::to_string(std::sin(i * 1e-4)) + " 0\n";
    for (int i = 2; i <= n; ++i) fan += "f 1 " + std::to_string(i) + " " + std::to_string(i + 1) + "\n";
    EXPECT_EQ(load(fan).meshes[0].triangles.size(), n - 1u);
}

TEST_F(ObjImport, MasksBecomeAlpha)
{
    Image8 color(2, 2, 3), mask(4, 4, 1);
    for (auto& c : color.data) c = 200;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) *mask.pixel(x, y) = x < 2 ? 255 : 0;
    write_png(folder_ / "color.png", color);
    write_png(folder_ / "the mask.png", mask);
    put("m.mtl", "newmtl leaf\nmap_Kd -s 2 2 color.png\nmap_d the mask.png\nmap_Bump -bm 0.5 absent.png\n");
    const scene::Scene scene = load("mtllib m.mtl\n" + k_square + "vt 0 0\nusemtl leaf\nf 1/1 2/1 3/1\n");
    ASSERT_EQ(scene.textures.size(), 1u);
    const scene::Material& leaf = scene.materials[0];
    EXPECT_EQ(leaf.alpha_mode, scene::AlphaMode::mask);
    EXPECT_EQ(leaf.base_color_texture.scale, glm::vec2(2));
    EXPECT_FALSE(leaf.normal_texture.used());
    EXPECT_EQ(scene.textures[0].width(), 4);
    EXPECT_NEAR(scene.textures[0].alpha({0.25f, 0.5f}), 1, 0.01);
    EXPECT_NEAR(scene.textures[0].alpha({0.75f, 0.5f}), 0, 0.01);
    EXPECT_TRUE(warned(scene, "absent.png"));
}

TEST_F(ObjImport, TextureRowsAreUpright)
{
    // White above, black below: v = 1 is the top in OBJ.
    Image8 color(1, 2, 3);
    for (int c = 0; c < 3; ++c) color.pixel(0, 0)[c] = 255, color.pixel(0, 1)[c] = 0;
    write_png(folder_ / "c.png", color);
    put("m.mtl", "newmtl a\nmap_Kd -clamp on c.png\n");
    const scene::Scene scene = load("mtllib m.mtl\n" + k_square + "vt 0.5 1\nvt 0.5 0\nusemtl a\nf 1/1 2/2 3/1\n");
    const scene::Mesh& mesh = scene.meshes[0];
    const scene::TextureUse& use = scene.materials[0].base_color_texture;
    const auto at = [&](std::uint32_t vertex) {
        return scene.textures[0].sample(use.apply(mesh.texcoords[0][vertex]), 0).x;
    };
    EXPECT_GT(at(mesh.triangles[0].x), 0.9f);
    EXPECT_LT(at(mesh.triangles[0].y), 0.1f);
    EXPECT_EQ(scene.textures[0].sampler().wrap_u, scene::Wrap::clamp);
}

TEST_F(ObjImport, HeightMapsBecomeNormalMaps)
{
    // A slope that rises to the right: the normal leans left.
    Image8 heights(8, 8, 1);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) *heights.pixel(x, y) = static_cast<std::uint8_t>(x * 30);
    write_png(folder_ / "h.png", heights);
    put("m.mtl", "newmtl a\nbump -bm 1 h.png\n");
    const scene::Scene scene = load("mtllib m.mtl\n" + k_square + "vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n");
    ASSERT_TRUE(scene.materials[0].normal_texture.used());
    const glm::vec4 n = scene.textures[scene.materials[0].normal_texture.texture].sample({0.5f, 0.5f}, 0);
    EXPECT_LT(n.x, 0.45f);
    EXPECT_NEAR(n.y, 0.5f, 0.01f);
    EXPECT_GT(n.z, 0.9f);
}

}   // namespace
}   // namespace gnomon::io
