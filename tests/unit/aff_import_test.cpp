// SPDX-License-Identifier: Apache-2.0
// Every statement of AFF, in small files.
#include "aff_files.h"
#include "scene/state.h"

namespace gnomon::io {
namespace {

using test::AffFolder;
using test::k_material;
using test::k_mesh;

Box3 box_of(const scene::Scene& scene)
{
    return scene.bounds(0);
}

void expect_near(const glm::dvec3& value, const glm::dvec3& expected, double tolerance = 1e-6)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], tolerance) << "coordinate " << c;
}

// The sum of the triangles' areas, and of their signed volumes about the origin (positive if wound outwards).
struct Measure {
    double area = 0, volume = 0;
};
Measure measure(const scene::Mesh& mesh)
{
    Measure result;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
        result.area += glm::length(glm::cross(b - a, c - a)) / 2;
        result.volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
    return result;
}

// The least cosine between vertex normals and triangle normals.
double worst_normal(const scene::Mesh& mesh)
{
    double worst = 1;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
        const glm::dvec3 flat = glm::normalize(glm::cross(b - a, c - a));
        for (int i = 0; i < 3; ++i) worst = std::min(worst, glm::dot(flat, glm::dvec3(mesh.normals[t[i]])));
    }
    return worst;
}

TEST(AffImport, IgnoresTheLayoutOfTheText)
{
    const AffFolder folder;
    const std::string plain = k_material + "x a { " + k_mesh + " }";
    for (const std::string& text :
         {plain,
          std::string(
              "fm .1 .1 .1\t.5 .5 .5\f.2 .2 .2 10 0 1 x a{m\rvertices 3 0 0 0 1 0 0 0 1 0\r\ntriangles 1\n0 1 2}"),
          std::string("# comment { \xe5\n%m\rfm +.1 1e-1 .1 .5 .5 .5 2e-1 .2 .2 10. 0 1#x\nx a%\n{") + k_mesh +
              "}% end"}) {
        const scene::Scene scene = folder.load(text);
        EXPECT_EQ(scene.statistics().triangles_dynamic, 1u) << text;
        EXPECT_EQ(scene.materials.at(0).shine, 10) << text;
    }
}

TEST(AffImport, ReadsTheCamera)
{
    const AffFolder folder;
    scene::Scene scene = folder.load("v from 1 2 3 at 1 2 -7 up 0.3 5 0 angle 60 hither 0.00001 resolution 320 200");
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_NEAR(scene.cameras[0].vertical_fov, k_pi / 3, 1e-12);
    EXPECT_EQ(scene.cameras[0].near, 1);
    EXPECT_EQ(scene.cameras[0].resolution, (Size{320, 200}));
    const glm::dmat4 m = scene.world_matrix(scene.cameras[0].node, 0);
    expect_near(glm::dvec3(m[3]), {1, 2, 3});
    expect_near(-glm::dvec3(m[2]), {0, 0, -1});
    expect_near(glm::dvec3(m[1]), glm::normalize(glm::dvec3(0.3, 5, 0)));
    EXPECT_NEAR(glm::determinant(glm::dmat3(m)), 1, 1e-12);

    // An up vector parallel to the view direction is replaced.
    scene = folder.load("v from 0 0 0 at 0 9 0 up 0 1 0 angle 60 hither 0.5 resolution 1 1");
    const glm::dmat4 upward = scene.world_matrix(scene.cameras[0].node, 0);
    expect_near(-glm::dvec3(upward[2]), {0, 1, 0});
    EXPECT_NEAR(glm::determinant(glm::dmat3(upward)), 1, 1e-12);
}

TEST(AffImport, CameraTrackOverridesPartByPart)
{
    const AffFolder folder;
    const std::string view = "v from 1 2 3 at 1 2 2 up 0 1 0 angle 60 hither 1 resolution 8 6\n";
    const std::string shift = "transl 4  0 5 5 5 0 0 0  1 5 5 5 0 0 0  2 6 5 5 0 0 0  3 6 5 5 0 0 0";
    const std::string turn = "rot 4  0 0 1 0 90 0 0 0  1 0 1 0 90 0 0 0  2 0 1 0 90 0 0 0  3 0 1 0 90 0 0 0";
    const auto matrix = [&](const std::string& keys) {
        const scene::Scene scene = folder.load(view + "k camera {" + keys + "}");
        EXPECT_NE(scene.nodes[scene.cameras[0].node].transform, nullptr);
        return scene.world_matrix(scene.cameras[0].node, 0);
    };
    expect_near(glm::dvec3(matrix(shift)[3]), {5, 5, 5});
    expect_near(-glm::dvec3(matrix(shift)[2]), {0, 0, -1});
    expect_near(glm::dvec3(matrix(turn)[3]), {1, 2, 3});
    expect_near(-glm::dvec3(matrix(turn)[2]), {-1, 0, 0});
    expect_near(glm::dvec3(matrix(shift + " " + turn)[3]), {5, 5, 5});
}

TEST(AffImport, ReadsLightsAndTheirTracks)
{
    const AffFolder folder;
    const scene::Scene scene = folder.load(
        "l 1 2 3\nl 4 5 6 .1 .2 .3\nla lite 1 0 0 1 1 0\nla still 7 8 9\n"
        "k lite { transl 4  0 0 2 0 0 0 0  1 0 2 0 0 0 0  2 0 4 0 0 0 0  3 0 4 0 0 0 0"
        "         rot 4  0 0 0 1 90 0 0 0  1 0 0 1 90 0 0 0  2 0 0 1 90 0 0 0  3 0 0 1 90 0 0 0 }");
    ASSERT_EQ(scene.lights.size(), 4u);
    EXPECT_EQ(scene.lights[0].color, glm::vec3(1));
    EXPECT_EQ(scene.lights[1].color, glm::vec3(.1f, .2f, .3f));
    for (const scene::Light& light : scene.lights) {
        EXPECT_EQ(light.type, scene::LightType::point);
        EXPECT_EQ(light.falloff, scene::Falloff::constant);
    }
    const auto at = [&](int light, double time) {
        return glm::dvec3(scene.world_matrix(scene.lights[light].node, time)[3]);
    };
    expect_near(at(0, 0), {1, 2, 3});
    expect_near(at(1, 0), {4, 5, 6});
    // The track's translation is added; its rotation has no effect.
    expect_near(at(2, 0), {1, 2, 0});
    expect_near(at(2, 9), {1, 4, 0});
    expect_near(at(3, 9), {7, 8, 9});
}

TEST(AffImport, ReadsBackgroundAndTimeline)
{
    const AffFolder folder;
    scene::Scene scene = folder.load("b .1 .2 .3 am 2 3 4 a 1 3 5");
    EXPECT_EQ(scene.background.color, glm::vec3(.1f, .2f, .3f));
    EXPECT_EQ(scene.ambient, glm::vec3(2, 3, 4));
    EXPECT_EQ(scene.timeline.frames, 5);
    EXPECT_EQ(scene.timeline.fps, 2);
    EXPECT_EQ(scene.timeline.time_of(1), 1);
    EXPECT_EQ(scene.timeline.time_of(2), 1.5);
    EXPECT_EQ(scene.timeline.time_of(5), 3);

    scene = folder.load("");
    EXPECT_EQ(scene.background.color, glm::vec3(0));
    EXPECT_EQ(scene.ambient, glm::vec3(1));
    EXPECT_EQ(scene.timeline.frames, 1);
    EXPECT_TRUE(scene.cameras.empty());

    scene = folder.load("a 2 2 1");
    EXPECT_EQ(scene.timeline.time_of(1), 2);
}

TEST(AffImport, ReadsMaterials)
{
    const AffFolder folder;
    scene::Scene scene = folder.load("fm .1 .2 .3  .4 .5 .6  .7 .8 .9  12 .25 1.5\n" + k_mesh);
    ASSERT_EQ(scene.materials.size(), 1u);
    const scene::Material& m = scene.materials[0];
    EXPECT_EQ(m.model, scene::ShadingModel::whitted);
    EXPECT_EQ(m.ambient, glm::vec3(.1f, .2f, .3f));
    EXPECT_EQ(m.base_color, glm::vec3(.4f, .5f, .6f));
    EXPECT_EQ(m.specular, glm::vec3(.7f, .8f, .9f));
    EXPECT_EQ(m.shine, 12);
    EXPECT_EQ(m.transmittance, .25f);
    EXPECT_EQ(m.ior, 1.5f);
    EXPECT_FALSE(m.one_sided());

    // Index of refraction 0 is read as 1; opaque materials are one-sided; f scales the colour.
    scene = folder.load("f 1 .5 0 .5 .25 3 0 0 " + k_mesh);
    EXPECT_EQ(scene.materials[0].base_color, glm::vec3(.5f, .25f, 0));
    EXPECT_EQ(scene.materials[0].specular, glm::vec3(.25f));
    EXPECT_EQ(scene.materials[0].ior, 1);
    EXPECT_TRUE(scene.materials[0].one_sided());

    // Equal materials are merged, and the current one stays in effect across braces and includes.
    folder.include("red.aff", "fm 1 0 0 1 0 0 0 0 0 0 0 0");
    scene = folder.load("xs 1 1 1 0 0 0 0 0 0 0 { i 0 red.aff } " + k_mesh + k_material + k_mesh + k_material + k_mesh);
    ASSERT_EQ(scene.materials.size(), 2u);
    EXPECT_EQ(scene.materials[scene.meshes[0].parts[0].material].base_color, glm::vec3(1, 0, 0));
    EXPECT_EQ(scene.objects.size(), 3u);

    // Before any material: grey, with a warning.
    scene = folder.load(k_mesh);
    EXPECT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.materials[0].base_color, glm::vec3(.5f));
}

TEST(AffImport, TessellatesSpheres)
{
    const AffFolder folder;
    const scene::Scene scene = folder.load(k_material + "s 1 2 3 2\ns 0 0 0 -1\ns 5 5 5 1");
    ASSERT_EQ(scene.objects.size(), 3u);
    const Box3 box = box_of(scene);
    expect_near(box.low, {-1, -1, -1}, 1e-2);
    expect_near(box.high, {6, 6, 6}, 1e-2);
    const auto whole = [&](int object) {
        const scene::Mesh& mesh = scene.meshes[scene.objects[object].mesh];
        EXPECT_GT(worst_normal(mesh), 0.98);
        const double scale = glm::determinant(glm::dmat3(scene.world_matrix(scene.objects[object].node, 0)));
        return measure(mesh).volume * scale;
    };
    // A negative radius turns the front inwards. The volume is slightly too small, because the shape is a polyhedron.
    EXPECT_NEAR(whole(1), -4 * k_pi / 3, 0.05);
    EXPECT_NEAR(whole(2), 4 * k_pi / 3, 0.05);
}

TEST(AffImport, LeavesOutSpheresThatManyOthersHide)
{
    const AffFolder folder;
    std::string text = k_material + "s 0 0 0 2\n";
    for (int i = 0; i < 100; ++i) text += "s 1 2 3 2\n";
    const scene::Scene scene = folder.load(text);
    EXPECT_EQ(scene.objects.size(), 65u);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0], "36 spheres where 64 equal ones are already: left out");
}

TEST(AffImport, TessellatesCones)
{
    const AffFolder folder;
    const double slant = std::sqrt(10.0);
    struct Row {
        std::string text;
        double area;
    };
    for (const auto& [text, area] :
         {Row{"c 0 0 0 1  0 0 3 0", k_pi * slant}, Row{"c 0 0 0 0  0 0 3 1", k_pi * slant},
          Row{"c 0 0 0 1  0 3 0 1", 2 * k_pi * 3}, Row{"c 0 0 0 -1  3 0 0 -1", 2 * k_pi * 3}}) {
        const scene::Scene scene = folder.load(k_material + text);
        ASSERT_EQ(scene.objects.size(), 1u);
        const scene::Mesh& mesh = scene.meshes[0];
        EXPECT_NEAR(measure(mesh).area, area, 0.01 * area) << text;
        // The side's normals are those of the smooth cone, so their cosine with the flat triangles is slightly below 1.
        EXPECT_GT(worst_normal(mesh), 0.97) << text;
        const bool inside = text.find('-') != std::string::npos;
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const glm::dvec3 centre(text.find("3 0 0 -1") != std::string::npos ? glm::dvec3(mesh.positions[v].x, 0, 0)
                                    : text.find("0 3 0") != std::string::npos  ? glm::dvec3(0, mesh.positions[v].y, 0)
                                                                               : glm::dvec3(0, 0, mesh.positions[v].z));
            const glm::dvec3 out = glm::dvec3(mesh.positions[v]) - centre;
            if (glm::length(out) < 1e-6) continue;
            EXPECT_EQ(glm::dot(out, glm::dvec3(mesh.normals[v])) < 0, inside) << text;
        }
    }
}

TEST(AffImport, ReadsPolygons)
{
    const AffFolder folder;
    // A square and a triangle with the same material form one object; normals, braces and materials start another.
    scene::Scene scene = folder.load(k_material + "p 4 0 0 0 1 0 0 1 1 0 0 1 0\np 3 0 0 1 1 0 1 0 1 1\n");
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 3u);
    EXPECT_NEAR(measure(scene.meshes[0]).area, 1.5, 1e-6);
    EXPECT_TRUE(scene.meshes[0].normals.empty());

    scene = folder.load(k_material + "pp 3 0 0 0 0 0 5  1 0 0 0 0 0  0 1 0 0 3 4");
    ASSERT_EQ(scene.meshes[0].normals.size(), 3u);
    expect_near(scene.meshes[0].normals[0], {0, 0, 1});
    expect_near(scene.meshes[0].normals[1], {0, 0, 1});   // it had no length: the triangle's normal
    expect_near(scene.meshes[0].normals[2], {0, .6, .8});

    scene = folder.load(k_material + "p 3 0 0 0 1 0 0 0 1 0 x a { p 3 0 0 0 1 0 0 0 1 0 } p 3 0 0 0 1 0 0 0 1 0");
    EXPECT_EQ(scene.objects.size(), 3u);
    EXPECT_EQ(scene.statistics().triangles_dynamic, 1u);
}

TEST(AffImport, ReadsTexturedTriangles)
{
    const AffFolder folder;
    folder.texture("two.ppm");
    const scene::Scene scene = folder.load(k_material + "tt two.ppm 0 0 0 0 0  1 0 0 1 0  0 1 0 -3.5 1\n" +
                                           "ttp two.ppm 0 0 0 0 0 1 0 0  1 0 0 0 0 1 1 0  0 1 0 0 0 1 0 1\n" + k_mesh);
    ASSERT_EQ(scene.objects.size(), 3u);
    ASSERT_EQ(scene.textures.size(), 1u);
    EXPECT_EQ(scene.materials.size(), 2u);   // with and without the texture
    EXPECT_EQ(scene.meshes[0].texcoords[0][2], glm::vec2(-3.5f, 1));
    EXPECT_TRUE(scene.meshes[0].normals.empty());
    EXPECT_EQ(scene.meshes[1].normals.size(), 3u);
    EXPECT_TRUE(scene.textures[0].srgb());
    EXPECT_EQ(scene.textures[0].sampler().wrap_u, scene::Wrap::repeat);
    EXPECT_EQ(scene.materials[scene.meshes[0].parts[0].material].base_color_texture.texture, 0u);
    // u = 0 is the left column.
    EXPECT_GT(scene.textures[0].sample({0.25f, 0.5f}, 0).x, 0.99f);
    EXPECT_GT(scene.textures[0].sample({0.75f, 0.5f}, 0).z, 0.99f);
}

TEST(AffImport, ReadsTrianglesWithVertexKeys)
{
    const AffFolder folder;
    const std::string first =
        "tpa 2  1  0 0 0 0 0 1  1 0 0 0 0 1  0 1 0 0 0 1   3  0 0 4 0 0 1  1 0 4 0 0 1  0 1 4 0 0 1\n";
    const std::string second =
        "tpa 2  1  5 0 0 0 0 1  6 0 0 0 0 1  5 1 0 0 0 1   3  5 0 0 0 0 1  6 0 0 0 0 1  5 1 0 0 0 1\n";
    const scene::Scene loaded = folder.load(k_material + first + second);
    ASSERT_EQ(loaded.objects.size(), 1u);   // same key times: one mesh
    EXPECT_EQ(loaded.statistics().triangles_dynamic, 2u);
    EXPECT_TRUE(loaded.objects[0].deforming);

    const auto shared = std::make_shared<const scene::Scene>(loaded);
    scene::SceneState state(shared, 0);
    EXPECT_EQ(state.deformed(0).positions[0].z, 0);
    state.advance(1.5);
    EXPECT_EQ(state.deformed(0).positions[0].z, 1);
    EXPECT_EQ(state.deformed(0).positions[3].z, 0);
    state.advance(99);
    EXPECT_EQ(state.deformed(0).positions[0].z, 4);
}

TEST(AffImport, ReadsMeshesWithSeparateIndices)
{
    const AffFolder folder;
    folder.texture("two.ppm");
    const scene::Scene scene = folder.load(k_material +
                                           "m vertices 4 0 0 0 1 0 0 0 1 0 9 9 9\n"
                                           "normals 2 0 0 2 0 0 0\n"
                                           "texturecoords 3 two.ppm 0 0 1 0 0 -7\n"
                                           "triangles 2  0 1 2  0 0 1  0 1 2   0 1 2  0 0 0  0 1 2");
    ASSERT_EQ(scene.objects.size(), 1u);
    const scene::Mesh& mesh = scene.meshes[0];
    // Position 2 occurs with two normals, position 3 not at all.
    EXPECT_EQ(mesh.positions.size(), 4u);
    for (std::size_t t = 0; t < 2; ++t) {
        const glm::uvec3 triangle = mesh.triangles[t];
        EXPECT_EQ(mesh.positions[triangle.x], glm::vec3(0, 0, 0));
        EXPECT_EQ(mesh.positions[triangle.y], glm::vec3(1, 0, 0));
        EXPECT_EQ(mesh.positions[triangle.z], glm::vec3(0, 1, 0));
        EXPECT_EQ(mesh.texcoords[0][triangle.z], glm::vec2(0, -7));
        for (int i = 0; i < 3; ++i) expect_near(mesh.normals[triangle[i]], {0, 0, 1});
    }
}

TEST(AffImport, RepeatedIncludesShareTheirMeshes)
{
    const AffFolder folder;
    folder.include("part.aff", k_mesh + k_mesh);
    const std::string other = "fm 1 1 1 1 1 1 1 1 1 1 0 1\n";
    const scene::Scene scene =
        folder.load(k_material + "i 0 part.aff xs 2 2 2 0 0 0 0 5 0 0 { i 0 part.aff } " + other + "i 0 part.aff");
    EXPECT_EQ(scene.objects.size(), 6u);
    EXPECT_EQ(scene.meshes.size(), 4u);   // two parts with different materials
    expect_near(box_of(scene).high, {7, 2, 0});
}

TEST(AffImport, SelectsDetailLevels)
{
    const AffFolder folder;
    folder.include("mesh.aff", k_mesh);
    const std::string text =
        k_material + "i 0 mesh.aff i 2 mesh.aff i 3 missing.aff d 2 i 2 mesh.aff i 1 mesh.aff i 3 missing.aff";
    EXPECT_EQ(folder.load(text).objects.size(), 3u);
    // A level that is set in an include stays in effect after it.
    folder.include("level.aff", "d 1");
    EXPECT_EQ(folder.load(k_material + "i 0 level.aff i 1 mesh.aff").objects.size(), 1u);
}

TEST(AffImport, StaticTransformsScaleRotateAndTranslate)
{
    const AffFolder folder;
    const scene::Scene scene = folder.load(k_material +
                                           "xs 1 1 1 0 0 0 0 100 0 0 { xs 2 3 4  0 0 7 90  10 20 30 { m vertices 3 1 0 "
                                           "0 0 1 0 0 0 1 triangles 1 0 1 2 } }");
    ASSERT_EQ(scene.objects.size(), 1u);
    const glm::dmat4 m = scene.world_matrix(scene.objects[0].node, 0);
    // Scale first, then rotate about z, then translate, then apply the outer transform.
    expect_near(transform_point(m, glm::dvec3(1, 0, 0)), {110, 22, 30});
    expect_near(transform_point(m, glm::dvec3(0, 1, 0)), {107, 20, 30});
    expect_near(transform_point(m, glm::dvec3(0, 0, 1)), {110, 20, 34});
    EXPECT_FALSE(scene.objects[0].dynamic);
}

TEST(AffImport, ReadsAnimatedTransformsAndSharedNames)
{
    const AffFolder folder;
    const std::string keys = "k wheel { transl 4  0 0 0 0 0 0 0  1 0 0 0 0 0 0  2 1 0 0 0 0 0  3 1 0 0 0 0 0 }\n";
    folder.include("wheel.aff", "x wheel { " + k_mesh + "}\n" + keys);
    const scene::Scene scene = folder.load(k_material + "x none {" + k_mesh + k_mesh +
                                           "} xs 1 1 1 0 0 0 0 0 5 0 { i 0 wheel.aff } i 0 wheel.aff " +
                                           "k unused { visibility 1 0 1 } x empty { }");
    // Without keys: the identity, and dynamic nevertheless.
    EXPECT_EQ(scene.statistics().objects, 4u);
    EXPECT_EQ(scene.statistics().objects_dynamic, 4u);
    std::vector<const scene::TransformTrack*> tracks;
    for (const scene::Node& node : scene.nodes)
        if (node.name == "wheel") tracks.push_back(node.transform.get());
    ASSERT_EQ(tracks.size(), 2u);
    EXPECT_NE(tracks[0], nullptr);
    EXPECT_EQ(tracks[0], tracks[1]);
    expect_near(scene.bounds(5).high, {2, 6, 0});

    // A second k replaces the first, wherever it stands.
    const scene::Scene again =
        folder.load(k_material + keys + "x wheel {" + k_mesh +
                    "} k wheel { transl 4  0 0 0 0 0 0 0  1 0 0 0 0 0 0  2 8 0 0 0 0 0  3 8 0 0 0 0 0 }");
    expect_near(again.bounds(5).high, {9, 1, 0});
}

TEST(AffImport, ConvertsNamesToUtf8)
{
    const AffFolder folder;
    const scene::Scene scene = folder.load(k_material + "x \xe5rm { " + k_mesh + "}");
    EXPECT_EQ(scene.nodes[0].name, "\xc3\xa5rm");
}

TEST(AffImport, RecognisesTheFileExtension)
{
    const AffFolder folder;
    folder.load("");
    EXPECT_NO_THROW(load_scene(folder.main()));
    std::filesystem::rename(folder.main(), folder.aff() / "main.AFF");
    EXPECT_NO_THROW(load_scene(folder.aff() / "main.AFF"));
    try {
        load_scene(folder.aff() / "main.xyz");
        FAIL() << "accepted";
    } catch (const UsageError& error) {
        EXPECT_NE(std::string(error.what()).find(".aff"), std::string::npos);
    }
}

}   // namespace
}   // namespace gnomon::io
