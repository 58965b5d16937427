// SPDX-License-Identifier: Apache-2.0
// Benchmarks are measured on the built-in scenes, so their content is fixed, and hashed here.

#include <gtest/gtest.h>

#include <span>

#include "base/hash.h"
#include "gnomon/error.h"
#include "scene/builtin/builtin.h"
#include "scene/state.h"

namespace gnomon::scene {
namespace {

// Everything that can affect a pixel: geometry, materials, textures, lights, and all transforms at every tenth frame.
std::uint64_t content_hash(const Scene& scene)
{
    std::uint64_t h = 1;
    const auto add = [&h](const auto& values) { h = hash_bytes(values.data(), values.size() * sizeof(values[0]), h); };
    const auto add_value = [&h](const auto& value) { h = hash_bytes(&value, sizeof value, h); };
    for (const Mesh& mesh : scene.meshes) {
        add(mesh.positions), add(mesh.normals), add(mesh.texcoords[0]), add(mesh.texcoords[1]), add(mesh.colors);
        add(mesh.triangles), add(mesh.parts);
    }
    for (const Material& m : scene.materials) {
        add_value(m.base_color), add_value(m.roughness), add_value(m.metallic), add_value(m.transmission);
        add_value(m.emissive), add_value(m.base_color_texture.texture);
    }
    for (const Texture& texture : scene.textures) add(texture.levels().front().data);
    for (const Light& light : scene.lights) add_value(light.color), add_value(light.outer_angle);
    for (const Camera& camera : scene.cameras) add_value(camera.vertical_fov);
    for (const Node& node : scene.nodes) add_value(node.mesh), add_value(node.parent);
    for (int frame = 1; frame <= scene.timeline.frames; frame += 10)
        for (NodeId n = 0; n < scene.nodes.size(); ++n) add_value(scene.world_matrix(n, scene.timeline.time_of(frame)));
    return h;
}

bool all_finite(const glm::dmat4& m)
{
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r)
            if (!std::isfinite(m[c][r])) return false;
    return true;
}

void expect_sound(const Scene& scene)
{
    for (const Mesh& mesh : scene.meshes) {
        EXPECT_NO_THROW(check_mesh(mesh)) << mesh.name;
        EXPECT_FALSE(mesh.triangles.empty()) << mesh.name;
        for (const glm::vec3& p : mesh.positions) ASSERT_TRUE(is_finite(p)) << mesh.name;
        // Check that normals have unit length and lie on the front of every triangle.
        for (const glm::vec3& n : mesh.normals) ASSERT_NEAR(glm::length(n), 1, 1e-3) << mesh.name;
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::vec3 face =
                glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
            ASSERT_GT(glm::dot(face, mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]), 0) << mesh.name;
        }
    }
    for (int frame = 1; frame <= scene.timeline.frames; ++frame)
        for (NodeId n = 0; n < scene.nodes.size(); ++n)
            ASSERT_TRUE(all_finite(scene.world_matrix(n, scene.timeline.time_of(frame)))) << scene.nodes[n].name;
}

// Six times the enclosed volume, positive when faces point outwards.
double signed_volume(const Mesh& mesh)
{
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles)
        sum += glm::dot(glm::dvec3(mesh.positions[t.x]),
                        glm::cross(glm::dvec3(mesh.positions[t.y]), glm::dvec3(mesh.positions[t.z])));
    return sum / 6;
}

const Mesh& mesh_named(const Scene& scene, const std::string& name)
{
    for (const Mesh& mesh : scene.meshes)
        if (mesh.name == name) return mesh;
    throw std::runtime_error("no mesh " + name);
}

TEST(Builtin, CornellHasTheSpecifiedContent)
{
    const Scene scene = make_builtin("cornell");
    EXPECT_EQ(scene.timeline.frames, 40);
    EXPECT_EQ(scene.timeline.fps, 24);
    EXPECT_EQ(scene.timeline.at_rate(24).frames, 40);
    expect_sound(scene);

    const auto expect_box = [&](const char* name, glm::vec3 low, glm::vec3 high) {
        const Box3 box = mesh_named(scene, name).bounds();
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_FLOAT_EQ(box.low[axis], low[axis]) << name;
            EXPECT_FLOAT_EQ(box.high[axis], high[axis]) << name;
        }
        EXPECT_NEAR(signed_volume(mesh_named(scene, name)),
                    static_cast<double>((high.x - low.x) * (high.y - low.y) * (high.z - low.z)), 1e-5)
            << name;
    };
    expect_box("floor", {-1.1f, -1.1f, -1.1f}, {1.1f, -1, 1});
    expect_box("ceiling", {-1.1f, 1, -1.1f}, {1.1f, 1.1f, 1});
    expect_box("back", {-1, -1, -1.1f}, {1, 1, -1});
    expect_box("left", {-1.1f, -1, -1.1f}, {-1, 1, 1});
    expect_box("right", {1, -1, -1.1f}, {1.1f, 1, 1});
    expect_box("tall block", {-0.275f, -0.6f, -0.275f}, {0.275f, 0.6f, 0.275f});
    expect_box("short block", {-0.275f, -0.275f, -0.275f}, {0.275f, 0.275f, 0.275f});
    EXPECT_NEAR(signed_volume(mesh_named(scene, "ball")), 4.0 / 3 * k_pi * std::pow(0.12, 3), 1e-4);

    // Only the ball moves, exactly as the formula says.
    ASSERT_EQ(scene.statistics().objects_dynamic, 1u);
    for (const Object& object : scene.objects) {
        if (!object.dynamic) continue;
        for (int i = 1; i <= 40; ++i) {
            const glm::dvec3 p(scene.world_matrix(object.node, scene.timeline.time_of(i))[3]);
            EXPECT_DOUBLE_EQ(p.x, -0.35 + i * 0.02);
            EXPECT_DOUBLE_EQ(p.y, 0.1 - i * 0.01);
            EXPECT_DOUBLE_EQ(p.z, 0.35);
        }
    }

    ASSERT_EQ(scene.lights.size(), 1u);
    const Light& spot = scene.lights[0];
    EXPECT_EQ(spot.type, LightType::spot);
    EXPECT_EQ(spot.profile, SpotProfile::cosine);
    EXPECT_EQ(spot.color, glm::vec3(8));
    EXPECT_FLOAT_EQ(spot.outer_angle, 0.7f);
    const glm::dmat4 spot_matrix = scene.world_matrix(spot.node, 0);
    const glm::dvec3 towards = glm::normalize(glm::dvec3(-1.1, -1, -1.1));
    EXPECT_NEAR(glm::length(glm::dvec3(spot_matrix[3]) - glm::dvec3(0.6, 0.8, 0.9)), 0, 1e-12);
    EXPECT_NEAR(glm::dot(-glm::dvec3(spot_matrix[2]), towards), 1, 1e-12);
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_DOUBLE_EQ(scene.cameras[0].vertical_fov, 0.62);

    // The blocks are rotated about +Y: check the tall block's first corner.
    for (const Node& node : scene.nodes) {
        if (node.name != "tall block") continue;
        const glm::dvec3 x(node.local[0]);
        EXPECT_NEAR(x.x, std::cos(0.35), 1e-12);
        EXPECT_NEAR(x.z, -std::sin(0.35), 1e-12);
    }
}

TEST(Builtin, SpheresHaveTheRequestedCounts)
{
    const Scene scene = make_builtin("spheres?objects=300&dynamic=10");
    EXPECT_EQ(scene.timeline.frames, 240);
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].positions.size(), 2037u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 2 * 55 + 36 * 55 * 2u);
    EXPECT_EQ(scene.statistics().objects, 300u);
    EXPECT_EQ(scene.statistics().objects_dynamic, 30u);
    expect_sound(scene);
    EXPECT_NEAR(signed_volume(scene.meshes[0]), 4.0 / 3 * k_pi * std::pow(0.47, 3), 0.01);

    EXPECT_EQ(make_builtin("spheres?objects=50&movers=7").statistics().objects_dynamic, 7u);
    EXPECT_EQ(make_builtin("spheres?objects=50&movers=0&dynamic=50").statistics().objects_dynamic, 0u);
    EXPECT_EQ(make_builtin("spheres?objects=8&dynamic=100").statistics().objects_dynamic, 8u);
    for (const int vertices : {5, 50, 500, 1009, 2037, 20000}) {
        const Scene some = make_builtin("spheres?objects=1&vertices=" + std::to_string(vertices));
        const auto got = static_cast<int>(some.meshes[0].positions.size());
        EXPECT_LE(std::abs(got - vertices), 1 + vertices / 100) << vertices;
    }
}

TEST(Builtin, SpheresStayInTheirCubeAndTheirPathsClose)
{
    const Scene scene = make_builtin("spheres?objects=60&dynamic=50&seed=3");
    const double radius = static_cast<double>(scene.meshes[0].bounds().high.y);
    for (const Object& object : scene.objects) {
        const auto& track = scene.nodes[object.node].transform;
        for (int frame = 1; frame <= 240; frame += 3) {
            const glm::dvec3 p(scene.world_matrix(object.node, scene.timeline.time_of(frame))[3]);
            for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(p[axis]) + radius, 5.0001);
        }
        if (!track) continue;
        EXPECT_EQ(track->evaluate(0), track->evaluate(10.0));   // 240 frames at 24 a second
        for (int frame = 1; frame < 240; ++frame)
            EXPECT_NE(track->evaluate(scene.timeline.time_of(frame)),
                      track->evaluate(scene.timeline.time_of(frame + 1)));
    }
}

TEST(Builtin, CrowdAroundDynamicObjectsDoesNotDependOnSceneSize)
{
    const Scene few = make_builtin("spheres?objects=110&movers=10&crowd=1"),
                many = make_builtin("spheres?objects=3000&movers=10&crowd=1");
    for (const Scene* scene : {&few, &many}) {
        EXPECT_EQ(scene->statistics().objects_dynamic, 10u);
        ASSERT_EQ(scene->meshes.size(), 2u);
        EXPECT_LT(scene->meshes[1].positions.size(), 50u);
    }
    // In light space: position across the light's axis at unit distance.
    const glm::dmat4 to_light = glm::inverse(few.world_matrix(few.lights[0].node, 0));
    const auto across = [&](const Scene& scene, const Object& object, double time) {
        const glm::dvec3 p = transform_point(to_light, glm::dvec3(scene.world_matrix(object.node, time)[3]));
        return std::max(std::abs(p.x), std::abs(p.y)) / -p.z;
    };
    double dynamic_reach = 0;
    const double radius = static_cast<double>(few.meshes[0].bounds().high.y) / 55;   // not closer to the light
    for (std::size_t i = 0; i < 10; ++i)
        for (int frame = 1; frame <= 240; frame += 5)
            dynamic_reach =
                std::max(dynamic_reach, across(few, few.objects[i], few.timeline.time_of(frame)) + 1.1 * radius);
    for (std::size_t i = 0; i < many.objects.size(); ++i) {
        if (i < 100) {
            EXPECT_EQ(few.world_matrix(few.objects[i].node, 0), many.world_matrix(many.objects[i].node, 0));
        } else {
            EXPECT_GT(across(many, many.objects[i], 0) - 0.1 / 55, dynamic_reach) << i;
        }
    }
}

TEST(Builtin, SpheresCoverAThirdOfTheLightView)
{
    const Scene scene = make_builtin("spheres");
    const glm::dmat4 to_light = glm::inverse(scene.world_matrix(scene.lights[0].node, 0));
    const double tangent = std::tan(static_cast<double>(scene.lights[0].outer_angle));
    const double radius = static_cast<double>(scene.meshes[0].bounds().high.y);
    std::vector<glm::dvec3> centres;
    for (const Object& object : scene.objects) {
        const glm::dvec3 p = transform_point(to_light, glm::dvec3(scene.world_matrix(object.node, 0)[3]));
        // Inside the cone completely.
        EXPECT_LT(std::atan(std::hypot(p.x, p.y) / -p.z), static_cast<double>(scene.lights[0].outer_angle));
        centres.push_back(p);
    }
    constexpr int size = 256;
    int covered = 0;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const glm::dvec3 ray = glm::normalize(
                glm::dvec3(((x + 0.5) / size * 2 - 1) * tangent, (1 - (y + 0.5) / size * 2) * tangent, -1));
            for (const glm::dvec3& c : centres) {
                const double along = glm::dot(ray, c);
                if (glm::dot(c, c) - along * along > radius * radius) continue;
                ++covered;
                break;
            }
        }
    EXPECT_NEAR(static_cast<double>(covered) / (size * size), 1.0 / 3, 0.02);
}

TEST(Builtin, KineticIsLargeAndMostlyStatic)
{
    const Scene scene = make_builtin("kinetic");
    expect_sound(scene);
    const Statistics statistics = scene.statistics();
    EXPECT_GE(statistics.triangles, 100'000u);
    EXPECT_LE(statistics.triangles, 500'000u);
    EXPECT_LE(statistics.triangles_dynamic * 10, statistics.triangles);
    EXPECT_EQ(statistics.objects_dynamic, 6u);
    EXPECT_EQ(scene.groups.size(), 6u);
    EXPECT_EQ(scene.timeline.frames, 120);
    EXPECT_EQ(scene.timeline.at_rate(24).frames, 120);
    EXPECT_GE(scene.lights.size(), 4u);
    EXPECT_EQ(scene.background.kind, Background::Kind::sky);
    // The sun in the sky lies in the direction of the light.
    const glm::dmat4 sun = scene.world_matrix(scene.lights[0].node, 0);
    EXPECT_NEAR(glm::dot(glm::dvec3(sun[2]), glm::dvec3(scene.background.sun_direction)), 1, 1e-6);
    // Glass objects are closed, so that rays that enter them also leave.
    for (const char* name : {"vase", "blue ball", "amber ball"})
        EXPECT_GT(signed_volume(mesh_named(scene, name)), 0) << name;
}

TEST(Builtin, KineticMovesWithoutJumps)
{
    const Scene scene = make_builtin("kinetic");
    const NodeId camera = scene.cameras[0].node;
    for (int frame = 1; frame < scene.timeline.frames; ++frame) {
        const double now = scene.timeline.time_of(frame), next = scene.timeline.time_of(frame + 1);
        const glm::dmat4 a = scene.world_matrix(camera, now), b = scene.world_matrix(camera, next);
        EXPECT_LT(glm::length(glm::dvec3(b[3]) - glm::dvec3(a[3])), 0.2);   // 4.8 m/s: a brisk walk at most
        EXPECT_GT(glm::dot(glm::dvec3(a[2]), glm::dvec3(b[2])), std::cos(0.03));
        EXPECT_GT(a[3].y, 1.2);
        for (const RigidGroup& group : scene.groups) {
            const glm::dmat4 p = scene.world_matrix(group.anchor, now), q = scene.world_matrix(group.anchor, next);
            EXPECT_NE(p, q);
            EXPECT_LT(glm::length(glm::dvec3(q[3]) - glm::dvec3(p[3])), 0.1);
        }
    }
}

// They are those of our own elementary functions (base/elementary), so they are the same on every processor.
TEST(Builtin, ContentHashesAreFixed)
{
    EXPECT_EQ(content_hash(make_builtin("cornell")), 0x481332a563e47826ull);
    EXPECT_EQ(content_hash(make_builtin("spheres?objects=40&dynamic=25")), 0xb51b2bef9ece18ccull);
    EXPECT_EQ(content_hash(make_builtin("kinetic")), 0x63a6973324d03a81ull);
}

TEST(Builtin, BuildsAMillionSpheres)
{
    const Scene scene = make_builtin("spheres?objects=1000000&movers=10&vertices=5");
    EXPECT_EQ(scene.statistics().objects, 1'000'000u);
    EXPECT_EQ(scene.track_nodes.size(), 10u);
}

TEST(Builtin, RefusesUnknownNamesAndParameters)
{
    for (const char* name : {"",
                             "teapot",
                             "cornell?x=1",
                             "kinetic?objects=3",
                             "spheres?",
                             "spheres?objects",
                             "spheres?objects=",
                             "spheres?objects=0",
                             "spheres?objects=1000001",
                             "spheres?objects=-1",
                             "spheres?objects=3x",
                             "spheres?objects=99999999999999",
                             "spheres?dynamic=-1",
                             "spheres?dynamic=101",
                             "spheres?dynamic=nan",
                             "spheres?dynamic=inf",
                             "spheres?vertices=4",
                             "spheres?seed=-1",
                             "spheres?colour=red",
                             "spheres?crowd=2",
                             "spheres?objects=3&&",
                             "spheres?objects=5&movers=6",
                             "spheres?objects=5&",
                             "Cornell"}) {
        if (std::string(name) == "spheres?" || std::string(name) == "spheres?objects=5&") {
            EXPECT_NO_THROW(make_builtin(name)) << name;   // nothing after the question mark: the defaults
            continue;
        }
        try {
            make_builtin(name);
            ADD_FAILURE() << name << " was accepted";
        } catch (const UsageError& error) {
            const std::string what = error.what();
            EXPECT_NE(what.find("builtin:kinetic"), std::string::npos) << what;   // lists the available scenes
            EXPECT_EQ(what.find('\n'), std::string::npos) << what;
        }
    }
}

}   // namespace
}   // namespace gnomon::scene
