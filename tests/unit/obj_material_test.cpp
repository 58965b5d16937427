// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "gnomon/error.h"
#include "io/obj/mtl.h"

namespace gnomon::io {
namespace {

std::vector<MtlMaterial> parse(const std::string& text, std::vector<std::string>* warnings = nullptr,
                               bool strict = false)
{
    std::vector<std::string> ignored;
    ObjText reader("m.mtl", text, !strict);
    return parse_mtl(reader, strict, warnings ? *warnings : ignored);
}

scene::Material material(const std::string& statements)
{
    std::vector<std::string> warnings;
    return material_from_mtl(parse("newmtl m\n" + statements).at(0), warnings);
}

TEST(ObjMaterial, ReadsMapsWithOptions)
{
    const MtlMaterial m = parse(
        "newmtl m\nmap_Kd -s 2 3 1 -o .5 -clamp on -mm 0.1 0.9 dir\\a b.png \r\n"
        "norm -bm 3 n.jpg\nmap_d -imfchan r -blendu off d.png\nmap_Ke -s 2 12.png\n")[0];
    EXPECT_EQ(m.diffuse_map.file, "dir\\a b.png");
    EXPECT_EQ(m.diffuse_map.scale, glm::vec2(2, 3));
    EXPECT_EQ(m.diffuse_map.offset, glm::vec2(0.5f, 0));
    EXPECT_EQ(m.diffuse_map.range, glm::vec2(0.1f, 0.9f));
    EXPECT_TRUE(m.diffuse_map.clamp);
    EXPECT_EQ(m.normal_map.file, "n.jpg");
    EXPECT_EQ(m.normal_map.bump, 3);
    EXPECT_EQ(m.dissolve_map.channel, 'r');
    EXPECT_EQ(m.dissolve_map.file, "d.png");
    EXPECT_EQ(m.emissive_map.file, "12.png");
}

TEST(ObjMaterial, ReportsErrorsAndWarnings)
{
    std::vector<std::string> warnings;
    EXPECT_EQ(parse("Kd 1 1 1\nnewmtl a\nKd spectral x.rfl\nfoo 1\nfoo 2\n", &warnings).size(), 1u);
    EXPECT_EQ(warnings.size(), 3u);
    // A value that cannot be read leaves the material as if it were not there.
    for (const char* bad : {"Kd a b c", "Kd 1 2", "Kd nan 0 0", "Ns x", "d", "Ns", "Kd", "map_Kd -s x a.png"}) {
        warnings.clear();
        const MtlMaterial m = parse(std::string("newmtl a\n") + bad + "\nKs 1 1 1\n", &warnings).at(0);
        EXPECT_FALSE(m.diffuse || m.exponent || m.dissolve) << bad;
        EXPECT_EQ(m.specular, glm::vec3(1)) << bad;
        EXPECT_EQ(warnings, std::vector<std::string>{"m.mtl, line 2: 1 value is not a number: ignored"}) << bad;
        EXPECT_THROW(parse(std::string("newmtl a\n") + bad, nullptr, true), InputError) << bad;
    }
    // One warning for all keywords.
    warnings.clear();
    parse("newmtl a\nA 1\nB 1\nC 1\nA 2\nnewmtl b\nD\nE\nF\nG\n", &warnings);
    EXPECT_EQ(warnings, std::vector<std::string>{
                            "m.mtl: 'A', 'B', 'C', 'D', 'E' and further keywords are not supported and ignored"});
    EXPECT_EQ(parse("newmtl a\nKd 0.25\n")[0].diffuse, glm::vec3(0.25f));
}

TEST(ObjMaterial, PhongBecomesRoughness)
{
    // alpha = sqrt(2 / (n + 2)): exponent 30 gives alpha 1/4, roughness 1/2.
    EXPECT_NEAR(material("Ks 1 1 1\nNs 30\n").roughness, 0.5f, 1e-6f);
    // Ks 1: 8 % at normal incidence. Ks 0: no reflection at all.
    const float r = material("Ks 1 1 1\nNs 30\n").ior;
    EXPECT_NEAR(((r - 1) / (r + 1)) * ((r - 1) / (r + 1)), 0.08f, 1e-5f);
    EXPECT_EQ(material("Ks 0 0 0\nNs 30\nNi 1.5\n").ior, 1);
    EXPECT_EQ(material("Ks 0 0 0\nNs 30\n").roughness, 1);
}

TEST(ObjMaterial, ReadsTransparency)
{
    using scene::SurfaceClass;
    EXPECT_EQ(material("d 1\nTr 0\nillum 4\n").surface_class(), SurfaceClass::opaque);
    EXPECT_EQ(material("Tf 1 1 1\nd 1\nillum 2\n").surface_class(), SurfaceClass::opaque);
    const scene::Material blended = material("d 0.25\nTr 0.5\n");
    EXPECT_EQ(blended.alpha_mode, scene::AlphaMode::blend);
    EXPECT_EQ(blended.alpha, 0.25f);   // d takes precedence over Tr
    EXPECT_EQ(material("Tr 0.25\n").alpha, 0.75f);
    EXPECT_EQ(material("d -halo 0.5\n").alpha, 0.5f);
    const scene::Material glass = material("Kd 0 0 0\nillum 7\nNi 1.33\nTf 1 0.5 0.5\nd 0.1\n");
    EXPECT_NEAR(glass.transmission, 0.9f, 1e-6f);
    EXPECT_EQ(glass.ior, 1.33f);
    EXPECT_GT(glass.base_color.x, 0.85f);
    EXPECT_EQ(glass.surface_class(), SurfaceClass::transparent);
    EXPECT_EQ(material("map_d x.png\nd 0.5\n").alpha_mode, scene::AlphaMode::mask);
}

TEST(ObjMaterial, ReadsEmissionMirrorsAndMetal)
{
    EXPECT_EQ(material("Ke 1 2 3\n").emissive, glm::vec3(1, 2, 3));
    EXPECT_EQ(material("Ka 20 20 20\nKd 1 1 1\n").emissive, glm::vec3(20));
    EXPECT_EQ(material("Ka 1 1 1\n").emissive, glm::vec3(0));
    EXPECT_EQ(material("Kd 0 0 0\nKs 0.9 0.9 0.9\nNs 1000\nillum 3\n").metallic, 1);
    EXPECT_EQ(material("Kd 0.5 0.5 0.5\nKs 0.9 0.9 0.9\nillum 2\n").metallic, 0);
    const scene::Material pbr = material("Kd 0.2 0.4 0.6\nPr 0.3\nPm 1\nKs 0 0 0\n");
    EXPECT_EQ(pbr.roughness, 0.3f);
    EXPECT_EQ(pbr.metallic, 1);
    EXPECT_EQ(pbr.base_color, glm::vec3(0.2f, 0.4f, 0.6f));
    // A map multiplied by black would be invisible.
    EXPECT_EQ(material("Kd 0 0 0\nmap_Kd x.png\n").base_color, glm::vec3(1));
    EXPECT_EQ(material("Kd 0.5 0.5 0.5\nmap_Kd x.png\n").base_color, glm::vec3(0.5f));
}

}   // namespace
}   // namespace gnomon::io
