// SPDX-License-Identifier: Apache-2.0
// What a host hands over with a frame: values stay in force, equal ones cost nothing, and what depends on them (ids,
// picks, reports, motion) follows.
#include "gnomon/frame_input.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "same_frames.h"

namespace gnomon {
namespace {

using test::camera_along_z;

// An odd number of rows, so that one goes through the image's centre; the focal length is 24.5 pixels.
constexpr Size k_size{65, 49};
constexpr double k_focal = 24.5;
constexpr double k_depth = 5;

// A square that may move, 5 m ahead, before a wall that may not, 10 m ahead; a light that throws a shadow.
struct Stage {
    SceneBuilder builder;
    MeshId mesh;
    MaterialId material;
    InstanceId square, wall;
    LightId light;
    Scene scene;

    explicit Stage(Mobility mobility = Mobility::may_move)
        : mesh(builder.mesh(test::square(1).mesh())),
          material(builder.material({.base_color = {1, 0.5f, 0.25f}})),
          square(builder.instance(mesh, material, Transform::translation(0, 0, -k_depth), {.mobility = mobility})),
          wall(builder.instance(builder.mesh(test::square(30).mesh()), {}, Transform::translation(0, 0, -10))),
          light(builder.light({.color = {90, 90, 90}}, Transform::translation(2, 1, 0))),
          scene(builder.finish())
    {
    }
};

FrameInput seen()
{
    FrameInput input;
    input.time = 0;
    input.camera = camera_along_z();
    return input;
}

Transform at(double x, double y, double z = -k_depth)
{
    return Transform::translation(x, y, z);
}

RenderOptions with_motion()
{
    RenderOptions options = test::plain(k_size);
    options.motion = true;
    return options;
}

bool same_image(const Frame& a, const Frame& b)
{
    const auto of_a = a.layers.front().values(), of_b = b.layers.front().values();
    return std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end());
}

// The image that a new renderer makes.
Frame anew(const Scene& scene, const FrameInput& input)
{
    return Renderer(test::plain(k_size)).render(scene, input);
}

TEST(FrameInput, ValuesStayInForceUntilTheyAreReleased)
{
    Stage stage;
    Renderer renderer(test::plain(k_size));
    const Frame plain = renderer.render(stage.scene, seen());

    FrameInput moved = seen();
    moved.transforms = {{stage.square, at(1, 0)}};
    moved.lights = {{stage.light, {.color = {10, 20, 30}}}};
    moved.materials = {{stage.material, {.base_color = {0, 1, 0}}}};
    const Frame first = renderer.render(stage.scene, moved);
    EXPECT_FALSE(same_image(first, plain));
    EXPECT_TRUE(same_image(first, anew(stage.scene, moved)));
    EXPECT_EQ(renderer.transform(stage.square), at(1, 0));

    const Frame kept = renderer.render(stage.scene, seen());
    EXPECT_TRUE(same_image(kept, first));
    EXPECT_EQ(kept.counters.update.nodes, 0u);
    EXPECT_FALSE(kept.counters.update.began_anew);

    FrameInput hidden = seen();
    hidden.visibility = {{stage.square, false}};
    EXPECT_FALSE(same_image(renderer.render(stage.scene, hidden), first));
    EXPECT_FALSE(renderer.visible(stage.square));

    FrameInput released = seen();
    released.released_nodes = {stage.square};
    released.released_lights = {stage.light};
    released.released_materials = {stage.material};
    const Frame back = renderer.render(stage.scene, released);
    EXPECT_TRUE(same_image(back, plain));
    EXPECT_FALSE(back.counters.update.began_anew);
    EXPECT_EQ(renderer.transform(stage.square), at(0, 0));
    EXPECT_TRUE(renderer.visible(stage.square));
}

TEST(FrameInput, EqualValuesCostNothing)
{
    Stage stage(Mobility::may_deform);
    Renderer renderer(test::plain(k_size));
    const test::Shape shape = test::square(1.5f);
    FrameInput input = seen();
    input.transforms = {{stage.square, at(1, 0)}};
    input.visibility = {{stage.square, true}};
    input.lights = {{stage.light, {.color = {10, 20, 30}}}};
    input.materials = {{stage.material, {.base_color = {0, 1, 0}}}};
    input.vertices = {{stage.square, shape.positions}};
    const Frame first = renderer.render(stage.scene, input);
    for (int i = 0; i < 3; ++i) {
        const Frame again = renderer.render(stage.scene, input);
        EXPECT_EQ(again.counters.update.nodes, 0u);
        EXPECT_EQ(again.counters.update.instances, 0u);
        EXPECT_FALSE(again.counters.update.began_anew);
        EXPECT_TRUE(same_image(again, first));
        const FrameReport report = renderer.report();
        EXPECT_FALSE(report.everything);
        EXPECT_TRUE(report.instances.empty() && report.lights.empty() && report.materials.empty());
    }
}

TEST(FrameInput, TheLastOfTwoValuesCounts)
{
    Stage stage;
    Renderer renderer(test::plain(k_size));
    FrameInput input = seen();
    input.transforms = {{stage.square, at(1, 0)}, {stage.square, at(-1, 0)}};
    input.released_nodes = {stage.square};   // comes first
    renderer.render(stage.scene, input);
    EXPECT_EQ(renderer.transform(stage.square), at(-1, 0));
}

TEST(FrameInput, FixedObjectsArePromotedOnce)
{
    Stage stage(Mobility::fixed);
    Renderer renderer(test::plain(k_size));
    EXPECT_TRUE(renderer.render(stage.scene, seen()).counters.update.began_anew);

    // The value that it has anyway promotes nothing.
    FrameInput input = seen();
    input.transforms = {{stage.square, at(0, 0)}};
    EXPECT_FALSE(renderer.render(stage.scene, input).counters.update.began_anew);

    Stage declared(Mobility::may_move);
    Renderer of_declared(test::plain(k_size));
    for (int i = 1; i <= 4; ++i) {
        input.transforms = {{stage.square, at(0.25 * i, 0)}};
        const Frame frame = renderer.render(stage.scene, input);
        EXPECT_EQ(frame.counters.update.began_anew, i == 1) << i;
        FrameInput same = seen();
        same.transforms = {{declared.square, at(0.25 * i, 0)}};
        EXPECT_TRUE(same_image(frame, of_declared.render(declared.scene, same))) << i;
    }
    FrameInput released = seen();
    released.released_nodes = {stage.square};
    EXPECT_FALSE(renderer.render(stage.scene, released).counters.update.began_anew);

    // Deforming is another promotion, but of an object that may move: another one takes its place.
    const test::Shape shape = test::square(1.5f);
    FrameInput deformed = seen();
    deformed.vertices = {{stage.square, shape.positions}};
    EXPECT_FALSE(renderer.render(stage.scene, deformed).counters.update.began_anew);
    const test::Shape other = test::square(0.5f);
    deformed.vertices = {{stage.square, other.positions}};
    EXPECT_FALSE(renderer.render(stage.scene, deformed).counters.update.began_anew);
}

TEST(FrameInput, ValuesSurviveAnEditOfTheScene)
{
    Stage stage;
    Renderer renderer(test::plain(k_size));
    FrameInput input = seen();
    input.transforms = {{stage.square, at(1, 0)}};
    input.lights = {{stage.light, {.color = {10, 20, 30}}}};
    renderer.render(stage.scene, input);

    const InstanceId added = stage.builder.instance(stage.mesh, {}, at(-2, 1));
    const Scene edited = stage.builder.finish();
    const Frame frame = renderer.render(edited, seen());
    EXPECT_TRUE(same_image(frame, anew(edited, input)));
    EXPECT_EQ(renderer.transform(stage.square), at(1, 0));
    EXPECT_EQ(renderer.transform(added), at(-2, 1));

    // Values of parts that were removed are forgotten.
    stage.builder.remove(stage.square);
    const InstanceId in_its_place = stage.builder.instance(stage.mesh, stage.material, at(0, 0));
    ASSERT_EQ(in_its_place.index, stage.square.index);
    const Scene without = stage.builder.finish();
    renderer.render(without, seen());
    EXPECT_EQ(renderer.transform(in_its_place), at(0, 0));
    EXPECT_THROW(renderer.transform(stage.square), UsageError);
    EXPECT_THROW(renderer.render(without, input), UsageError);

    // A mesh with another number of vertices does not take the vertices of before.
    Stage deforming(Mobility::may_deform);
    const test::Shape shape = test::square(1.5f);
    FrameInput deformed = seen();
    deformed.vertices = {{deforming.square, shape.positions}};
    renderer.render(deforming.scene, deformed);
    deforming.builder.set_mesh(deforming.mesh, test::cube(1).mesh());
    EXPECT_TRUE(
        same_image(renderer.render(deforming.builder.finish(), seen()), anew(deforming.builder.finish(), seen())));
}

// A part that comes or goes leaves the motion of the others as it is, and all layers as they are in the other scene.
TEST(FrameInput, PartsThatComeAndGoLeaveTheMotionOfTheOthers)
{
    Stage stage(Mobility::may_move);
    SceneBuilder builder(stage.scene);
    const test::Shape cube = test::cube(0.3f);
    builder.instance(builder.mesh(cube.mesh()), {}, at(-0.5, 0.5), {.mobility = Mobility::may_move});
    const Scene with = builder.finish();
    FrameInput start = seen(), end = seen();
    start.time = 0.0, end.time = 0.0;
    start.transforms = {{stage.square, at(0.1, 0)}};
    end.transforms = {{stage.square, at(0.3, 0.1)}};
    const auto renders = [&](const Scene& first, const Scene& second) {
        Renderer renderer(with_motion());
        renderer.render(first, start);
        return renderer.render(second, end);
    };
    const Frame came = renders(stage.scene, with);
    EXPECT_FALSE(came.counters.update.began_anew);
    test::expect_same(came, renders(with, with));
    const Frame went = renders(with, stage.scene);
    EXPECT_FALSE(went.counters.update.began_anew);
    test::expect_same(went, renders(stage.scene, stage.scene));
    ASSERT_NE(came.layer("motion"), nullptr);
    bool moved = false;
    for (const float value : came.layer("motion")->values()) moved = moved || value != 0;
    EXPECT_TRUE(moved);
}

TEST(FrameInput, OtherOptionsKeepWhatIsRemembered)
{
    const Scene scene = load("builtin:cornell");
    RenderOptions options = test::plain({48, 48});
    options.shadow_culling = ShadowCulling::certified;
    options.keep_image = false;
    Renderer renderer(options);
    FrameInput input;
    input.time = 0;
    renderer.render(scene, input);
    renderer.render(scene, input);
    const auto before = renderer.render(scene, input).counters;
    ASSERT_GT(before.shadow.rays_skipped, before.shadow.rays / 2);

    options.exposure = 1, options.tonemap = ToneMap::agx, options.ids = false, options.motion = true;
    options.threads = 2, options.report_changes = true, options.layers = false;
    renderer.set_options(options);
    const auto after = renderer.render(scene, input).counters;
    EXPECT_FALSE(after.update.began_anew);
    EXPECT_EQ(after.update.nodes, 0u);
    EXPECT_EQ(after.shadow.rays, before.shadow.rays);
    EXPECT_EQ(after.shadow.rays_skipped, before.shadow.rays_skipped);

    // Another size has other points, but the same memory of them.
    options.size = {40, 40}, options.samples = 2;
    renderer.set_options(options);
    const Frame resized = renderer.render(scene, input);
    EXPECT_FALSE(resized.counters.update.began_anew);
    EXPECT_GT(resized.counters.shadow.rays_skipped, resized.counters.shadow.rays / 2);
    EXPECT_TRUE(same_image(resized, Renderer(options).render(scene, input)));

    options.interactive = true;
    EXPECT_THROW(renderer.set_options(options), UsageError);
    EXPECT_FALSE(renderer.options().interactive);
}

TEST(FrameInput, PicksAndReportsNameWhatTheHostHandedOver)
{
    Stage stage;
    Renderer renderer(test::plain(k_size));
    const Frame frame = renderer.render(stage.scene, seen());
    EXPECT_TRUE(renderer.report().everything);
    const Pick middle = renderer.pick(32, 24), corner = renderer.pick(0, 0);
    ASSERT_TRUE(middle.hit && corner.hit);
    EXPECT_EQ(middle.instance, stage.square);
    EXPECT_EQ(middle.material, stage.material);
    EXPECT_EQ(corner.instance, stage.wall);
    EXPECT_NEAR(middle.depth, 5, 1e-5);
    EXPECT_NEAR(corner.depth, 10, 1e-5);
    EXPECT_NEAR(middle.normal.z, 1, 1e-6);
    const Layer& ids = *frame.layer("id");
    EXPECT_EQ(stage.scene.instance_of(ids.id(32, 24, 0)), stage.square);
    EXPECT_EQ(stage.scene.material_of(ids.id(32, 24, 1)), stage.material);
    EXPECT_EQ(stage.scene.instance_of(ids.id(0, 0, 0)), stage.wall);
    EXPECT_FALSE(stage.scene.instance_of(0));
    EXPECT_FALSE(stage.scene.instance_of(0xffffffff));
    EXPECT_FALSE(stage.scene.material_of(0xffffffff));

    FrameInput input = seen();
    input.transforms = {{stage.square, at(1, 0)}};
    input.lights = {{stage.light, {.color = {1, 2, 3}}}};
    input.materials = {{stage.material, {.base_color = {0, 1, 0}}}};
    renderer.render(stage.scene, input);
    const FrameReport report = renderer.report();
    EXPECT_FALSE(report.everything);
    EXPECT_EQ(report.instances, std::vector<InstanceId>{stage.square});
    EXPECT_EQ(report.lights, std::vector<LightId>{stage.light});
    EXPECT_EQ(report.materials, std::vector<MaterialId>{stage.material});

    renderer.forget();
    EXPECT_THROW(renderer.report(), UsageError);
    EXPECT_THROW(renderer.pick(0, 0), UsageError);
    EXPECT_THROW(renderer.camera(), UsageError);
    EXPECT_THROW(renderer.transform(stage.square), UsageError);
}

// Checks the motion of all pixels that show an instance.
void expect_motion(const Scene& scene, const Frame& frame, const InstanceId& instance, double right, double down)
{
    const Layer &motion = *frame.layer("motion"), &ids = *frame.layer("id");
    int count = 0;
    for (int y = 0; y < k_size.height; ++y)
        for (int x = 0; x < k_size.width; ++x) {
            if (scene.instance_of(ids.id(x, y)) != instance) continue;
            ASSERT_NEAR(motion.value(x, y, 0), right, 2e-4) << x << " " << y;
            ASSERT_NEAR(motion.value(x, y, 1), down, 2e-4) << x << " " << y;
            ++count;
        }
    EXPECT_GT(count, 50);
}

TEST(HostMotion, FollowsWhatTheHostMoved)
{
    Stage stage;
    Renderer renderer(with_motion());
    FrameInput input = seen();
    // Nothing moved before the first frame, wherever the object is.
    input.transforms = {{stage.square, at(1, 0)}};
    expect_motion(stage.scene, renderer.render(stage.scene, input), stage.square, 0, 0);
    const double scale = k_focal / k_depth;
    input.transforms = {{stage.square, at(1.5, 0.25)}};
    Frame frame = renderer.render(stage.scene, input);
    expect_motion(stage.scene, frame, stage.square, 0.5 * scale, -0.25 * scale);
    expect_motion(stage.scene, frame, stage.wall, 0, 0);
    // It stands still.
    expect_motion(stage.scene, renderer.render(stage.scene, seen()), stage.square, 0, 0);
    input.transforms = {{stage.square, at(-1, 0.25)}};
    expect_motion(stage.scene, renderer.render(stage.scene, input), stage.square, -2.5 * scale, 0);
    FrameInput released = seen();
    released.released_nodes = {stage.square};
    expect_motion(stage.scene, renderer.render(stage.scene, released), stage.square, 1 * scale, 0.25 * scale);
}

TEST(HostMotion, CountsFromTheLastFrameWithoutTheLayer)
{
    Stage stage;
    RenderOptions options = with_motion();
    Renderer renderer(options);
    FrameInput input = seen();
    renderer.render(stage.scene, input);
    options.motion = false;
    renderer.set_options(options);
    for (const double x : {0.5, 1.0, 0.75}) {
        input.transforms = {{stage.square, at(x, 0)}};
        renderer.render(stage.scene, input);
    }
    options.motion = true;
    renderer.set_options(options);
    input.transforms = {{stage.square, at(1, 0)}};
    expect_motion(stage.scene, renderer.render(stage.scene, input), stage.square, 0.25 * k_focal / k_depth, 0);
}

TEST(HostMotion, FollowsVertices)
{
    Stage stage(Mobility::may_deform);
    Renderer renderer(with_motion());
    test::Shape shape = test::square(1);
    FrameInput input = seen();
    input.vertices = {{stage.square, shape.positions}};
    renderer.render(stage.scene, input);
    for (Vec3& p : shape.positions) p.x += 0.5f;
    input.vertices = {{stage.square, shape.positions}};
    const Frame frame = renderer.render(stage.scene, input);
    expect_motion(stage.scene, frame, stage.square, 0.5 * k_focal / k_depth, 0);
    expect_motion(stage.scene, renderer.render(stage.scene, input), stage.square, 0, 0);
}

TEST(HostMotion, IsRightInTheFrameOfAPromotion)
{
    Stage stage(Mobility::fixed);
    Renderer renderer(with_motion());
    FrameInput input = seen();
    renderer.render(stage.scene, input);
    const double scale = k_focal / k_depth;
    input.transforms = {{stage.square, at(0.5, 0)}};
    Frame frame = renderer.render(stage.scene, input);
    EXPECT_TRUE(frame.counters.update.began_anew);
    expect_motion(stage.scene, frame, stage.square, 0.5 * scale, 0);
    expect_motion(stage.scene, frame, stage.wall, 0, 0);
    input.transforms = {{stage.square, at(0.5, 0.5)}};
    expect_motion(stage.scene, renderer.render(stage.scene, input), stage.square, 0, -0.5 * scale);

    // While another is promoted, what moves already goes on moving.
    input.transforms = {{stage.square, at(1, 0.5)}, {stage.wall, at(0.5, 0, -10)}};
    frame = renderer.render(stage.scene, input);
    EXPECT_TRUE(frame.counters.update.began_anew);
    expect_motion(stage.scene, frame, stage.square, 0.5 * scale, 0);
    expect_motion(stage.scene, frame, stage.wall, 0.5 * k_focal / 10, 0);

    // A promotion to deform: the vertices move from the mesh's own.
    test::Shape shape = test::square(1);
    for (Vec3& p : shape.positions) p.x += 0.25f;
    FrameInput deformed = seen();
    deformed.vertices = {{stage.square, shape.positions}};
    frame = renderer.render(stage.scene, deformed);
    EXPECT_FALSE(frame.counters.update.began_anew);
    expect_motion(stage.scene, frame, stage.square, 0.25 * scale, 0);
}

TEST(HostMotion, FollowsThroughAnEditOfTheScene)
{
    Stage stage;
    Renderer renderer(with_motion());
    FrameInput input = seen();
    input.transforms = {{stage.square, at(0.5, 0)}};
    renderer.render(stage.scene, input);
    const InstanceId added = stage.builder.instance(stage.mesh, {}, at(-2, 1));
    const Scene edited = stage.builder.finish();
    input.transforms = {{stage.square, at(1, 0)}};
    const Frame frame = renderer.render(edited, input);
    expect_motion(edited, frame, stage.square, 0.5 * k_focal / k_depth, 0);
    expect_motion(edited, frame, added, 0, 0);
}

TEST(HostMotion, FollowsTheHostsCamera)
{
    Stage stage;
    Renderer renderer(with_motion());
    FrameInput input = seen();
    renderer.render(stage.scene, input);
    input.camera->transform = Transform::translation(0.5, 0.25, 0);
    Frame frame = renderer.render(stage.scene, input);
    expect_motion(stage.scene, frame, stage.square, -0.5 * k_focal / k_depth, 0.25 * k_focal / k_depth);
    expect_motion(stage.scene, frame, stage.wall, -0.5 * k_focal / 10, 0.25 * k_focal / 10);
    frame = renderer.render(stage.scene, input);
    expect_motion(stage.scene, frame, stage.square, 0, 0);
    // A shift of the lens moves all by as many pixels.
    input.camera->shift_x = 0.125;
    frame = renderer.render(stage.scene, input);
    expect_motion(stage.scene, frame, stage.square, -0.125 * k_size.height, 0);
    expect_motion(stage.scene, frame, stage.wall, -0.125 * k_size.height, 0);
}

TEST(HostMotion, FollowsFromTheScenesCameraToTheHosts)
{
    Stage stage;
    Camera camera = camera_along_z();
    const CameraId id = stage.builder.camera(camera, {.mobility = Mobility::may_move});
    const Scene scene = stage.builder.finish();
    Renderer renderer(with_motion());
    FrameInput of_scene;
    of_scene.time = 0;
    renderer.render(scene, of_scene);
    FrameInput of_host = seen();
    of_host.camera->transform = Transform::translation(0.5, 0, 0);
    expect_motion(scene, renderer.render(scene, of_host), stage.wall, -0.5 * k_focal / 10, 0);
    expect_motion(scene, renderer.render(scene, of_scene), stage.wall, 0.5 * k_focal / 10, 0);
    // The scene's camera is moved by its node.
    of_scene.transforms = {{scene.node(id), Transform::translation(0, 1, 0)}};
    expect_motion(scene, renderer.render(scene, of_scene), stage.wall, 0, 1 * k_focal / 10);
    expect_motion(scene, renderer.render(scene, of_scene), stage.wall, 0, 0);
}

}   // namespace
}   // namespace gnomon
