// SPDX-License-Identifier: Apache-2.0
// Repairs of surfaces whose files do not say how they look, and of cameras that show nothing.
#include <gtest/gtest.h>

#include <fstream>

#include "gltf_document.h"
#include "gnomon/gnomon.h"
#include "io/load.h"
#include "scene/defaults/default_view.h"
#include "scene/defaults/framing.h"
#include "scene/defaults/surroundings.h"
#include "scene/file_surfaces.h"
#include "scene/material_layers.h"

namespace gnomon::scene {
namespace {

// A ball around a place. Its normals point outwards; `turned` winds its triangles inwards.
Mesh ball(float radius = 1, const glm::vec3& place = {}, bool turned = false)
{
    constexpr int k_rings = 8, k_around = 16;
    Mesh mesh;
    for (int ring = 0; ring <= k_rings; ++ring)
        for (int step = 0; step <= k_around; ++step) {
            const double polar = k_pi * ring / k_rings, turn = 2 * k_pi * step / k_around;
            const glm::vec3 n(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn));
            mesh.normals.push_back(n);
            mesh.positions.push_back(place + radius * n);
        }
    for (std::uint32_t ring = 0; ring < k_rings; ++ring)
        for (std::uint32_t step = 0; step < k_around; ++step) {
            const std::uint32_t a = ring * (k_around + 1) + step, b = a + k_around + 1;
            // At the poles, one of two triangles has no area.
            if (ring > 0) mesh.triangles.emplace_back(a, a + 1, b);
            if (ring + 1 < k_rings) mesh.triangles.emplace_back(a + 1, b + 1, b);
        }
    if (turned)
        for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    mesh.parts = {{0, 0, static_cast<std::uint32_t>(mesh.triangles.size())}};
    return mesh;
}

// A scene of meshes, each with a material of its own.
Scene scene_of(std::vector<Mesh> meshes)
{
    Scene scene;
    for (Mesh& mesh : meshes) {
        mesh.parts[0].material = static_cast<MaterialId>(scene.materials.size());
        scene.materials.emplace_back();
        scene.nodes.emplace_back().mesh = static_cast<MeshId>(scene.meshes.size());
        scene.meshes.push_back(std::move(mesh));
    }
    return scene;
}

// How many triangles have normals on their fronts, and are wound outwards.
std::pair<std::size_t, std::size_t> right_ones(const Mesh& mesh)
{
    std::size_t normals = 0, wound = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::vec3 front =
            glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
        normals += glm::dot(front, mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]) > 0;
        wound += glm::dot(front, mesh.positions[t.x] + mesh.positions[t.y] + mesh.positions[t.z]) > 0;
    }
    return {normals, wound};
}

TEST(SurfaceRepairs, NormalsAndWindingAgreeAfterwards)
{
    // Wound inwards, with normals outwards; wound outwards, with normals inwards; a right one.
    Mesh inwards = ball(1, {}, true), normals = ball(), right = ball();
    for (glm::vec3& n : normals.normals) n = -n;
    normals.tangents.assign(normals.positions.size(), {1, 0, 0, 1});
    normals.morph_targets.emplace_back().normals.assign(normals.positions.size(), {0, 0, 0.5f});
    normals.morph_targets[0].positions.assign(normals.positions.size(), {});
    const std::size_t all = right.triangles.size();
    Scene scene = scene_of({inwards, normals, right});
    EXPECT_EQ(turn_surfaces(scene), 2u);
    for (const Mesh& mesh : scene.meshes) EXPECT_EQ(right_ones(mesh), std::pair(all, all));
    EXPECT_EQ(scene.meshes[1].tangents[3].w, -1);
    EXPECT_EQ(scene.meshes[1].morph_targets[0].normals[3].z, -0.5f);
    EXPECT_EQ(scene.meshes[2].triangles, right.triangles);
    EXPECT_EQ(turn_surfaces(scene), 0u) << "again";

    // Both sides of this one are seen, so its triangles say nothing: the normals are turned.
    Scene both = scene_of({inwards});
    both.materials[0].double_sided = true;
    EXPECT_EQ(turn_surfaces(both), 1u);
    EXPECT_EQ(right_ones(both.meshes[0]), std::pair(all, std::size_t{0}));
}

TEST(SurfaceRepairs, ScenesThatAreEntirelyTransparentAreShown)
{
    Scene scene = scene_of({ball(), ball(1, {3, 0, 0})});
    scene.materials[0].alpha_mode = AlphaMode::blend, scene.materials[0].alpha = 0;
    EXPECT_FALSE(show_invisible(scene)) << "the other is visible";
    scene.materials[1].alpha_mode = AlphaMode::mask, scene.materials[1].alpha = 0.25f;
    EXPECT_TRUE(show_invisible(scene));
    for (const Material& m : scene.materials) EXPECT_TRUE(m.alpha == 1 && m.alpha_mode == AlphaMode::opaque);
    EXPECT_FALSE(show_invisible(scene));
}

TEST(SurfaceRepairs, DomesOfSkiesCastNoShadowAndAreNotFramed)
{
    Scene scene = scene_of({ball(), ball(50, {}, true), ball(2, {1, 0, 0})});
    scene.materials[1].model = scene.materials[2].model = ShadingModel::unlit;
    EXPECT_EQ(find_sky_domes(scene), 1u) << "an unlit thing among others is none";
    EXPECT_TRUE(scene.materials[scene.meshes[1].parts[0].material].outline);
    scene.finish();
    const SceneState state(std::make_shared<Scene>(scene), 0);
    const std::vector<char> left_out = surrounding_objects(state);
    ASSERT_EQ(left_out.size(), 3u);
    EXPECT_TRUE(!left_out[0] && left_out[1] && !left_out[2]);
    EXPECT_LT(glm::length(choose_view(state).eye), 30) << "inside";
}

TEST(SurfaceRepairs, ARoundDomeWithAFloorIsASky)
{
    Mesh floor;
    floor.positions = {{-50, 0, -50}, {-50, 0, 50}, {50, 0, 50}, {50, 0, -50}};
    floor.normals.assign(4, {0, 1, 0});
    floor.triangles = {{0, 1, 2}, {0, 2, 3}};
    floor.parts = {{0, 0, 2}};
    Scene scene = scene_of({ball(1, {0, 1, 0}), ball(50), floor});
    scene.materials[1].double_sided = true;
    EXPECT_EQ(find_sky_domes(scene), 1u);
    EXPECT_TRUE(scene.materials[scene.meshes[1].parts[0].material].outline);
    scene.finish();
    const SceneState state(std::make_shared<Scene>(scene), 0);
    EXPECT_EQ(surrounding_objects(state), (std::vector<char>{0, 1, 1}));
    EXPECT_LT(glm::length(choose_view(state).eye), 30) << "inside";

    // Without a floor, a ball hides what is in it.
    Scene hidden = scene_of({ball(1, {0, 1, 0}), ball(50)});
    hidden.materials[1].double_sided = true;
    EXPECT_EQ(find_sky_domes(hidden), 0u);
}

TEST(SurfaceRepairs, OfSpecksTheLargestGroupIsShown)
{
    Scene scene = scene_of({ball(), ball(0.5f, {3000, 0, 0}), ball(0.5f, {2.5f, 0, 0})});
    scene.finish();
    const SceneState state(std::make_shared<Scene>(scene), 0);
    EXPECT_EQ(all_but_largest_group(state), (std::vector<char>{0, 1, 0}));
    const DefaultView view = choose_view(state);
    EXPECT_LT(glm::length(view.eye), 20);
}

Camera camera_at(Scene& scene, const glm::dvec3& eye, bool turned)
{
    Camera camera;
    camera.name = turned ? "away" : "towards";
    camera.far = 0;
    glm::dmat4 placed(1);
    if (turned) placed[0].x = placed[2].z = -1;
    placed[3] = glm::dvec4(eye, 1);
    camera.node = scene.add_node(camera.name, none, placed);
    return camera;
}

TEST(SurfaceRepairs, ACameraThatShowsSomethingComesFirst)
{
    Scene scene = scene_of({ball()});
    scene.cameras = {camera_at(scene, {0, 0, 5}, true), camera_at(scene, {0, 0, 5}, false)};
    scene.finish();
    judge_cameras(scene);
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_EQ(scene.cameras[0].name, "towards");
    EXPECT_EQ(scene.warnings.size(), 1u);
    judge_cameras(scene);
    EXPECT_EQ(scene.warnings.size(), 1u);

    // Before its near plane, beyond its far plane, too small: none of them shows a surface.
    for (int fault = 0; fault < 3; ++fault) {
        Scene blank = scene_of({ball()});
        Camera camera = camera_at(blank, {0, 0, fault == 2 ? 5000 : 5}, false);
        if (fault == 0) camera.near = 20;
        if (fault == 1) camera.far = 2;
        blank.cameras = {camera};
        blank.finish();
        judge_cameras(blank);
        ASSERT_EQ(blank.cameras.size(), 2u) << fault;
        EXPECT_EQ(blank.cameras[0].name, "default camera");
        EXPECT_EQ(blank.cameras[1].name, "towards");
        EXPECT_EQ(blank.warnings.size(), 1u);
    }
}

TEST(SurfaceRepairs, ClosedShellsThatAreSeenThroughLetLightIn)
{
    Mesh shell = ball(1, {}, true);
    for (glm::vec3& n : shell.normals) n = -n;
    Scene scene = scene_of({shell});
    scene.finish();
    EXPECT_EQ(turn_surfaces(scene), 0u);
    EXPECT_TRUE(has_shells(scene));
    add_default_camera(scene);
    add_surroundings(scene);
    EXPECT_TRUE(scene.materials[scene.meshes[0].parts[0].material].outline);
    EXPECT_FALSE(has_shells(scene));
    // From outside it is an ordinary object.
    Scene outside = scene_of({ball()});
    outside.finish();
    EXPECT_FALSE(has_shells(outside));
    EXPECT_EQ(open_shells(outside), 0u);
}

TEST(SurfaceRepairs, NoGroundHidesWhatIsSeenFromBelow)
{
    Mesh ceiling;
    ceiling.positions = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
    ceiling.triangles = {{0, 1, 2}, {0, 2, 3}};   // faces down
    ceiling.parts = {{0, 0, 2}};
    Scene scene = scene_of({ceiling});
    scene.finish();
    add_default_camera(scene);
    add_surroundings(scene);
    for (const Node& node : scene.nodes) EXPECT_NE(node.name, k_default_ground);
}

TEST(SurfaceRepairs, SmoothMeshesHaveSmoothTangents)
{
    Mesh mesh = ball();
    for (const glm::vec3& n : mesh.normals) mesh.texcoords[0].push_back({std::atan2(n.z, n.x), -n.y});
    // At the seam, vertices of the last step have the angle of a whole turn.
    for (std::size_t v = 16; v < mesh.positions.size(); v += 17) mesh.texcoords[0][v].x = static_cast<float>(2 * k_pi);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        if (v % 17 != 16 && mesh.texcoords[0][v].x < -1e-5f) mesh.texcoords[0][v].x += static_cast<float>(2 * k_pi);
    Scene scene = scene_of({mesh, mesh});
    MaterialLayers brushed;
    brushed.anisotropy = 1;
    scene.materials[0].layers = std::make_shared<const MaterialLayers>(brushed);
    EXPECT_EQ(add_tangents(scene), 1u) << "the other mesh needs none";
    const Mesh& smooth = scene.meshes[0];
    ASSERT_EQ(smooth.tangents.size(), smooth.positions.size());
    for (std::size_t v = 17; v + 17 < smooth.positions.size(); ++v) {
        const glm::vec3& n = smooth.normals[v];
        const glm::vec3 along = glm::normalize(glm::vec3(-n.z, 0, n.x));        // of growing angles
        EXPECT_GT(glm::dot(glm::vec3(smooth.tangents[v]), along), .98f) << v;   // one-sided means at the seam
        // The second tangent points up, against v.
        EXPECT_GT((glm::cross(n, along) * smooth.tangents[v].w).y, 0) << v;
    }
    EXPECT_EQ(add_tangents(scene), 0u) << "a file's own tangents stay";

    // Halves with mirrored coordinates that share vertices, and turned textures, keep the tangents of their triangles.
    Scene mirrored = scene_of({mesh});
    for (glm::vec2& uv : mirrored.meshes.edit(0).texcoords[0]) uv.x = std::abs(uv.x - 3.0f);
    mirrored.materials[0].layers = std::make_shared<const MaterialLayers>(brushed);
    EXPECT_EQ(add_tangents(mirrored), 0u);
    brushed.anisotropy_texture.rotation = 1;
    scene.materials[1].layers = std::make_shared<const MaterialLayers>(brushed);
    EXPECT_EQ(add_tangents(scene), 0u);
}

// Beyond 64 of equal corners and winding, triangles are left out; the parts of the mesh stay whole.
TEST(SurfaceRepairs, OfManyTrianglesInOnePlaceSomeAreKept)
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    for (int i = 0; i < 100; ++i) mesh.triangles.push_back(i % 2 == 0 ? glm::uvec3(0, 1, 2) : glm::uvec3(2, 0, 4));
    for (int i = 0; i < 64; ++i) mesh.triangles.emplace_back(0, 2, 1);    // seen from behind
    for (int i = 0; i < 100; ++i) mesh.triangles.emplace_back(1, 4, 2);   // without area
    for (int i = 0; i < 70; ++i) mesh.triangles.emplace_back(0, 3, 2);
    mesh.parts = {{0, 0, 90}, {0, 90, 184}, {0, 274, 60}};
    Scene scene = scene_of({mesh});
    EXPECT_EQ(leave_out_repeats(scene), 36u + 6u);
    const Mesh& left = scene.meshes[0];
    ASSERT_EQ(left.triangles.size(), mesh.triangles.size() - 42);
    ASSERT_EQ(left.parts.size(), 3u);
    EXPECT_EQ(left.parts[0].triangle_count, 64u);
    EXPECT_EQ(left.parts[1].first_triangle, 64u);
    EXPECT_EQ(left.parts[1].triangle_count, 174u);
    EXPECT_EQ(left.parts[2].triangle_count, 54u);
    EXPECT_EQ(left.triangles[64], glm::uvec3(0, 2, 1));
    EXPECT_NO_THROW(check_mesh(left));
    EXPECT_EQ(leave_out_repeats(scene), 0u);

    mesh.morph_targets.emplace_back().positions.assign(mesh.positions.size(), {});
    Scene moving = scene_of({mesh});
    EXPECT_EQ(leave_out_repeats(moving), 0u);
}

// The whole way of a file: an image that shows something, with a warning, and as it is written if reading is strict.
TEST(SurfaceRepairs, FilesAreShownWithAWarningAndAsTheyAreIfStrict)
{
    test::ScratchFolder folder;
    std::ofstream(folder / "a.mtl") << "newmtl m\nKd 1 0 0\nd 0\n";
    std::ofstream(folder / "a.obj") << "mtllib a.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (const bool strict : {false, true}) {
        LoadOptions options;
        options.strict = strict;
        const gnomon::Scene scene = load((folder / "a.obj").string(), options);
        const auto warnings = scene.info().warnings;
        EXPECT_EQ(std::any_of(warnings.begin(), warnings.end(),
                              [](const std::string& w) { return w.find("entirely transparent") != std::string::npos; }),
                  !strict);
    }
}

}   // namespace
}   // namespace gnomon::scene
