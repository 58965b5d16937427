// SPDX-License-Identifier: Apache-2.0
// The BART scenes Kitchen and Robots, against values from the format's own sample evaluator, which reads its keys as
// 32-bit floats; hence the tolerances.
#include <map>
#include <set>

#include "gnomon/error.h"
#include "io/aff/aff.h"
#include "io/load.h"
#include "support.h"

namespace gnomon::io {
namespace {

struct Bart {
    scene::Scene scene;
    AffReport report;
};

// Load each scene once for all tests.
const Bart& loaded(const std::filesystem::path& file)
{
    static std::map<std::filesystem::path, Bart> scenes;
    if (!scenes.contains(file)) {
        Bart& bart = scenes[file];
        bart.scene = load_aff(file, {}, AffOptions{}, &bart.report);
    }
    return scenes[file];
}

#define NEED_KITCHEN GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff")
#define NEED_ROBOTS GNOMON_NEED_SCENE(file, "bart/robots/aff/Robot.aff")

// The world matrices of all nodes.
std::vector<glm::dmat4> world_at(const scene::Scene& scene, double time)
{
    std::vector<glm::dmat4> world;
    for (const scene::Node& node : scene.nodes) {
        const glm::dmat4 local = node.transform ? node.transform->evaluate(time) : node.local;
        world.push_back(node.parent == scene::none ? local : world[node.parent] * local);
    }
    return world;
}

struct Below {
    Box3 box;
    std::size_t triangles = 0;
};

// The bounds and triangle count below a node; if `top` is none, of the whole scene.
Below below(const scene::Scene& scene, const std::vector<glm::dmat4>& world, scene::NodeId top)
{
    Below result;
    std::vector<char> inside(scene.nodes.size());
    for (scene::NodeId n = 0; n < scene.nodes.size(); ++n) {
        const scene::Node& node = scene.nodes[n];
        inside[n] = top == scene::none || n == top || (node.parent != scene::none && inside[node.parent]);
        if (!inside[n] || node.mesh == scene::none) continue;
        const scene::Mesh& mesh = scene.meshes[node.mesh];
        result.triangles += mesh.triangles.size();
        for (const glm::uvec3& t : mesh.triangles)
            for (int i = 0; i < 3; ++i)
                result.box.add(glm::vec3(transform_point(world[n], glm::dvec3(mesh.positions[t[i]]))));
    }
    return result;
}

scene::NodeId node_named(const scene::Scene& scene, const std::string& name)
{
    for (scene::NodeId n = 0; n < scene.nodes.size(); ++n)
        if (scene.nodes[n].name == name) return n;
    return scene::none;
}

void expect_near(const glm::dvec3& value, const glm::dvec3& expected, double tolerance, const std::string& what)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], tolerance) << what << ", coordinate " << c;
}

struct CameraRow {
    int frame;
    double time;
    glm::dvec3 eye, direction, up;
};

void check_camera(const scene::Scene& scene, const std::vector<CameraRow>& rows, double position_tolerance)
{
    ASSERT_EQ(scene.cameras.size(), 1u);
    for (const CameraRow& row : rows) {
        const std::string what = "frame " + std::to_string(row.frame);
        EXPECT_NEAR(scene.timeline.time_of(row.frame), row.time, 1e-6);
        const glm::dmat4 m = scene.world_matrix(scene.cameras[0].node, scene.timeline.time_of(row.frame));
        expect_near(glm::dvec3(m[3]), row.eye, position_tolerance, what + " eye");
        expect_near(-glm::dvec3(m[2]), row.direction, 5e-4, what + " direction");
        expect_near(glm::dvec3(m[1]), row.up, 5e-4, what + " up");
    }
}

TEST(BartKitchen, CameraMatchesTheSampleEvaluator)
{
    NEED_KITCHEN;
    const scene::Scene& scene = loaded(file).scene;
    check_camera(
        scene,
        {{1, 0, {3.75, 2.3, 3.6}, {-0.31346, -0.41981, -0.85176}, {-0.12700, 0.90744, -0.40052}},
         {100, 2.478098, {3.6235, 1.2373, 1.7734}, {-0.94979, -0.20053, 0.24018}, {-0.23890, 0.96048, -0.14281}},
         {400, 9.987484, {3.1175, 0.4885, 1.05}, {-0.61423, -0.58052, -0.53453}, {-0.45044, 0.81410, -0.36654}},
         {800, 20, {3.2749, 0.3345, 2.9803}, {-0.71736, -0.46255, 0.52100}, {-0.35973, 0.88633, 0.29158}}},
        5e-4);
    EXPECT_NEAR(scene.cameras[0].vertical_fov, glm::radians(40.0), 1e-12);
    EXPECT_EQ(scene.cameras[0].near, 0.01);
    EXPECT_EQ(scene.cameras[0].resolution, (Size{800, 600}));
}

TEST(BartRobots, CameraMatchesTheSampleEvaluator)
{
    NEED_ROBOTS;
    check_camera(
        loaded(file).scene,
        {{1, 0, {-3.5, 2, -203}, {0.05881, 0.09871, -0.99338}, {-0.00584, 0.99512, 0.09853}},
         {200, 12.453066, {1.0011, 12.9357, -165.8768}, {-0.98852, -0.15055, -0.01269}, {-0.14820, 0.98257, -0.11222}},
         {457, 28.535670, {-0.6703, 5.2984, 55.8538}, {0.30790, 0.00088, 0.95142}, {0.02259, 0.99971, -0.00824}},
         {800, 50, {0, 80, 0}, {-0.14145, -0.98505, 0.09829}, {-0.93672, 0.16530, 0.30859}}},
        2e-3);
}

struct NodeRow {
    std::string name;
    std::size_t triangles;
    int frame;
    glm::dvec3 origin, low, high;
};

void check_nodes(const scene::Scene& scene, const std::vector<NodeRow>& rows, double tolerance)
{
    for (const NodeRow& row : rows) {
        const std::string what = row.name + " frame " + std::to_string(row.frame);
        const scene::NodeId node = node_named(scene, row.name);
        ASSERT_NE(node, scene::none) << row.name;
        EXPECT_TRUE(scene.nodes[node].animated);
        const std::vector<glm::dmat4> world = world_at(scene, scene.timeline.time_of(row.frame));
        const Below all = below(scene, world, node);
        EXPECT_EQ(all.triangles, row.triangles) << row.name;
        expect_near(glm::dvec3(world[node][3]), row.origin, tolerance, what + " origin");
        expect_near(all.box.low, row.low, tolerance, what + " low");
        expect_near(all.box.high, row.high, tolerance, what + " high");
    }
}

TEST(BartKitchen, MovingNodesMatchTheSampleEvaluator)
{
    NEED_KITCHEN;
    std::vector<NodeRow> rows{
        {"toycar", 7218, 1, {4.45, 0, 2.75}, {4.3121, 0, 2.6709}, {4.5761, 0.1378, 2.8293}},
        {"toycar", 7218, 400, {2.6799, 0, 0.5998}, {2.5775, 0, 0.4608}, {2.7792, 0.1378, 0.7502}},
        {"toycar", 7218, 800, {2.75, 0, 3.4}, {2.6709, 0, 3.3369}, {2.8293, 0.1378, 3.4689}},
        {"front_wheel_left", 890, 1, {4.3657, 0.028, 2.8086}, {4.3374, 0, 2.7970}, {4.3940, 0.056, 2.8195}},
        {"front_wheel_left", 890, 400, {2.7130, 0.028, 0.6970}, {2.7001, 0, 0.6683}, {2.7250, 0.056, 0.7257}},
        {"front_wheel_left", 890, 800, {2.8086, 0.028, 3.4421}, {2.7929, 0, 3.4274}, {2.8236, 0.056, 3.4568}}};
    // Nothing moves before frame 121.
    for (const std::size_t still : {0u, 3u}) {
        rows.push_back(rows[still]);
        rows.back().frame = 100;
    }
    check_nodes(loaded(file).scene, rows, 5e-4);
}

TEST(BartRobots, MovingNodesMatchTheSampleEvaluator)
{
    NEED_ROBOTS;
    check_nodes(
        loaded(file).scene,
        {{"robot_transl1", 6249, 1, {-5, 0, -236}, {-12.3010, -0.0420, -239.8072}, {-0.9974, 9.2121, -229.0876}},
         {"robot_transl1",
          6249,
          200,
          {-7.6488, 0, -173.7874},
          {-15.0627, -0.1510, -177.5907},
          {-3.7360, 9.0818, -167.8560}},
         {"robot_transl1",
          6249,
          457,
          {-7.2274, 0, -93.4048},
          {-14.2397, -0.0866, -97.1978},
          {-2.8470, 9.4748, -86.4893}},
         {"robot_transl1", 6249, 800, {-5, 0, -6}, {-12.2088, -0.0420, -9.7926}, {-0.8843, 11.1585, -0.7127}},
         // Eight tracks deep.
         {"l_toes_rot1",
          48,
          1,
          {-3.4679, 0.4320, -234.8546},
          {-3.5490, -0.0004, -235.1378},
          {-1.7434, 1.0285, -233.5477}},
         {"l_toes_rot1",
          48,
          200,
          {-6.1491, 0.4112, -175.4884},
          {-6.2218, -0.0408, -175.7706},
          {-4.4236, 0.9959, -174.1998}},
         {"l_toes_rot1",
          48,
          457,
          {-5.4140, 1.6541, -91.2541},
          {-5.4257, 1.4510, -91.5529},
          {-3.6271, 2.6684, -90.0928}},
         {"l_toes_rot1", 48, 800, {-3.4059, 0.4320, -4.9425}, {-3.4171, -0.0004, -5.2623}, {-1.6185, 1.0285, -3.6973}},
         // Axes not of length 1.
         {"head_rot1",
          724,
          1,
          {-5.0908, 6.4120, -233.5137},
          {-6.7624, 5.1024, -234.1335},
          {-3.1125, 9.2121, -229.0876}},
         {"head_rot1",
          724,
          200,
          {-7.8389, 5.6501, -171.5336},
          {-10.7822, 2.7578, -172.3970},
          {-6.7021, 7.7031, -167.8560}},
         {"head_rot1", 724, 457, {-6.9811, 6.6820, -90.9162}, {-8.4935, 5.3620, -91.5146}, {-4.8942, 9.4748, -86.4893}},
         {"head_rot1", 724, 800, {-4.9634, 7.5192, -4.1219}, {-6.5127, 6.7992, -5.8798}, {-2.9033, 11.1585, -1.0987}},
         {"grip_rot2", 414, 457, {2.2679, 7.0137, -88.5489}, {-1.3506, 5.8882, -89.2552}, {2.0058, 9.0161, -86.0936}}},
        2e-3);
}

struct Counts {
    std::uint64_t triangles, moving, meshes, meshes_moving, untextured;
    std::size_t rotations, translations, scales, names, uses;
    std::uint64_t flat;
    std::size_t nesting, files, textures, lights;
};

void check_counts(const Bart& bart, const Counts& expected)
{
    const scene::Scene& scene = bart.scene;
    const scene::Statistics statistics = scene.statistics();
    EXPECT_EQ(statistics.triangles, expected.triangles);
    EXPECT_EQ(statistics.triangles_dynamic, expected.moving);
    EXPECT_EQ(statistics.objects, expected.meshes);
    EXPECT_EQ(statistics.objects_dynamic, expected.meshes_moving);
    std::uint64_t untextured = 0, flat = 0;
    for (const scene::Object& object : scene.objects) {
        const scene::Mesh& mesh = scene.meshes[object.mesh];
        untextured += mesh.texcoords[0].empty();
        for (const glm::uvec3& t : mesh.triangles) {
            const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
            flat += glm::cross(b - a, c - a) == glm::dvec3(0);
        }
    }
    EXPECT_EQ(untextured, expected.untextured);
    EXPECT_EQ(flat, expected.flat) << "triangles without area";

    std::size_t rotations = 0, translations = 0, scales = 0;
    for (const auto& [name, tracks] : bart.report.tracks) {
        if (!tracks.transform) continue;
        rotations += tracks.transform->rotation.has_value();
        translations += tracks.transform->translation.has_value();
        scales += tracks.transform->scale.has_value();
    }
    EXPECT_EQ(rotations, expected.rotations);
    EXPECT_EQ(translations, expected.translations);
    EXPECT_EQ(scales, expected.scales);
    EXPECT_EQ(bart.report.tracks.size(), expected.names);
    std::size_t uses = 0;
    for (const scene::Node& node : scene.nodes) uses += node.animated && node.name != "camera";
    EXPECT_EQ(uses, expected.uses);

    EXPECT_EQ(bart.report.deepest_nesting, expected.nesting);
    EXPECT_EQ(bart.report.files, expected.files);
    EXPECT_EQ(scene.textures.size(), expected.textures);
    EXPECT_EQ(scene.lights.size(), expected.lights);
}

TEST(BartKitchen, CountsMatchTheFiles)
{
    NEED_KITCHEN;
    check_counts(loaded(file), {.triangles = 110561,
                                .moving = 7218,
                                .meshes = 393,
                                .meshes_moving = 86,
                                .untextured = 277,
                                .rotations = 6,
                                .translations = 2,
                                .scales = 1,
                                .names = 6,
                                .uses = 7,
                                .flat = 41,
                                .nesting = 6,
                                .files = 52,
                                .textures = 8,
                                .lights = 6});
}

TEST(BartRobots, CountsMatchTheFiles)
{
    NEED_ROBOTS;
    check_counts(loaded(file), {.triangles = 71708,
                                .moving = 62490,
                                .meshes = 1849,
                                .meshes_moving = 1410,
                                .untextured = 189,
                                .rotations = 167,
                                .translations = 22,
                                .scales = 0,
                                .names = 187,
                                .uses = 190,
                                .flat = 128,
                                .nesting = 15,
                                .files = 51,
                                .textures = 44,
                                .lights = 1});
}

TEST(BartKitchen, BoundsLightsAndTimelineMatchTheFiles)
{
    NEED_KITCHEN;
    const scene::Scene& scene = loaded(file).scene;
    const Box3 box = scene.bounds(0);
    expect_near(box.low, {-2, -1.1, -3.75}, 5e-3, "low");
    expect_near(box.high, {6, 2.9, 4.33}, 5e-3, "high");
    EXPECT_EQ(scene.ambient, glm::vec3(2.5f));
    EXPECT_EQ(scene.background.color, glm::vec3(0.5f, 0.5f, 1.0f));
    EXPECT_EQ(scene.lights[0].color, glm::vec3(0.3f));
    EXPECT_EQ(scene.lights[0].falloff, scene::Falloff::constant);
    expect_near(glm::dvec3(scene.world_matrix(scene.lights[5].node, 0)[3]), {0.25, 1.4, 1}, 1e-6, "last light");
    EXPECT_EQ(scene.timeline.frames, 800);
    EXPECT_NEAR(scene.timeline.fps, 799.0 / 20, 1e-12);
    EXPECT_TRUE(scene.timeline.own_frames);
}

TEST(BartRobots, BoundsLightsAndTimelineMatchTheFiles)
{
    NEED_ROBOTS;
    const scene::Scene& scene = loaded(file).scene;
    const Box3 box = scene.bounds(0);
    expect_near(box.low, {-164.148, -0.6198, -435.355}, 2e-3, "low");
    expect_near(box.high, {164.148, 535.355, 250.097}, 2e-3, "high");
    expect_near(glm::dvec3(scene.world_matrix(scene.lights[0].node, 0)[3]), {1, 500, 1}, 0, "light");
    EXPECT_EQ(scene.ambient, glm::vec3(1));
    // Five nodes have no keys; they are dynamic nevertheless, and a warning names them.
    ASSERT_EQ(scene.warnings.size(), 1u);
    for (const std::string name : {"grip_rot1", "grip_lift1", "gun_rot2", "gun_lift2", "head_rot2"}) {
        EXPECT_NE(scene.warnings[0].find(name), std::string::npos) << name;
        const scene::NodeId node = node_named(scene, name);
        ASSERT_NE(node, scene::none);
        EXPECT_TRUE(scene.nodes[node].animated);
        EXPECT_EQ(scene.nodes[node].transform, nullptr);
    }
}

// Every track is a finite rotation or translation in every frame, and constant outside its changing intervals.
void check_all_frames(const scene::Scene& scene)
{
    std::set<const scene::TransformTrack*> tracks;
    for (const scene::Node& node : scene.nodes)
        if (node.transform) tracks.insert(node.transform.get());
    for (const scene::TransformTrack* track : tracks) {
        const std::vector<scene::Interval> changing = track->changing();
        glm::dmat4 before(0);
        for (int frame = 1; frame <= scene.timeline.frames; ++frame) {
            const double time = scene.timeline.time_of(frame);
            const glm::dmat4 m = track->evaluate(time);
            for (int c = 0; c < 4; ++c)
                for (int r = 0; r < 4; ++r) ASSERT_TRUE(std::isfinite(m[c][r])) << "frame " << frame;
            if (frame > 1) {
                const double last_time = scene.timeline.time_of(frame - 1);
                bool may_change = false;
                for (const scene::Interval& i : changing) may_change |= i.first <= time && i.last > last_time;
                ASSERT_TRUE(may_change || m == before) << "changes outside its changing intervals in frame " << frame;
            }
            before = m;
        }
    }
}

TEST(BartKitchen, EveryFrameIsFinite)
{
    NEED_KITCHEN;
    check_all_frames(loaded(file).scene);
}

TEST(BartRobots, EveryFrameIsFinite)
{
    NEED_ROBOTS;
    check_all_frames(loaded(file).scene);
}

TEST(BartKitchen, LoadSceneReportsProgressAndCanBeInterrupted)
{
    NEED_KITCHEN;
    int calls = 0;
    double last = 0;
    const scene::Scene scene = load_scene(file, [&](const ProgressStep& step) {
        EXPECT_LE(last, step.done);
        last = step.done;
        return ++calls > 0;
    });
    EXPECT_EQ(scene.statistics().triangles, 110561u);
    EXPECT_GT(calls, 10);
    EXPECT_EQ(last, 1.0);
    EXPECT_THROW(load_scene(file, [](const ProgressStep&) { return false; }), InterruptedError);
}

}   // namespace
}   // namespace gnomon::io
