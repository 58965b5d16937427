// SPDX-License-Identifier: Apache-2.0
// What SceneBuilder promises: ids that stay valid, slots that are used again, calls that fail without effect, and
// parts that come back as they were handed over.
#include "gnomon/scene_builder.h"

#include <gtest/gtest.h>

#include "api/scene_access.h"
#include "gnomon/renderer.h"
#include "host_scene.h"
#include "image_bytes.h"
#include "support.h"

namespace gnomon {
namespace {

using test::camera_along_z;
using test::plain;
using test::square;

// The lengths of a scene's lists, removed parts included.
struct Lengths {
    std::size_t nodes, meshes, materials, textures, skins, lights, cameras;
    friend bool operator==(const Lengths&, const Lengths&) = default;
};

Lengths lengths_of(const Scene& scene)
{
    const scene::Scene& s = *api::scene_of(scene);
    return {s.nodes.size(), s.meshes.size(), s.materials.size(), s.textures.size(),
            s.skins.size(), s.lights.size(), s.cameras.size()};
}

std::vector<std::uint8_t> grey_pixels(int count, std::uint8_t value = 128)
{
    return std::vector<std::uint8_t>(static_cast<std::size_t>(count), value);
}

TextureId add_texture(SceneBuilder& b, int channels = 3)
{
    const std::vector<std::uint8_t> pixels = grey_pixels(4 * channels);
    return b.texture({.width = 2, .height = 2, .channels = channels, .pixels = pixels});
}

// A square with all its vertices on the first joint.
MeshId add_skinned(SceneBuilder& b)
{
    const test::Shape shape = square(1);
    const std::vector<Joints> joints(4);
    const std::vector<Vec4> weights(4, Vec4{1, 0, 0, 0});
    Mesh mesh = shape.mesh();
    mesh.joints[0] = joints;
    mesh.weights[0] = weights;
    return b.mesh(mesh);
}

TEST(SceneBuilder, IdsStayValidFromSceneToScene)
{
    SceneBuilder b;
    const MaterialId red = b.material({.name = "red", .base_color = {1, 0, 0}});
    const MeshId mesh = b.mesh(square(1).mesh());
    const InstanceId first = b.instance(mesh, red, Transform::translation(1, 2, 3), {.name = "first"});
    const LightId light = b.light({.name = "bulb"});
    const CameraId camera = b.camera({.name = "eye"});
    const Scene before = b.finish();
    const InstanceId second = b.instance(mesh, {}, {}, {.parent = first, .name = "second"});
    const Scene after = b.finish();

    for (const Scene* scene : {&before, &after}) {
        EXPECT_EQ(scene->find_instance("first"), first);
        EXPECT_EQ(scene->find_node("first"), first);
        EXPECT_EQ(scene->find_light("bulb"), light);
        EXPECT_EQ(scene->find_camera("eye"), camera);
        EXPECT_EQ(scene->find_material("red"), red);
        EXPECT_EQ(scene->mesh(first), mesh);
        EXPECT_EQ(scene->transform(first), Transform::translation(1, 2, 3));
        EXPECT_EQ(scene->material(red).base_color, (Vec3{1, 0, 0}));
    }
    EXPECT_FALSE(before.find_instance("second"));
    EXPECT_THROW(before.name(second), UsageError);
    EXPECT_EQ(after.instances(), (std::vector<InstanceId>{first, second}));
    EXPECT_EQ(after.parent(second), first);
    EXPECT_EQ(after.name(second), "second");
    EXPECT_FALSE(after.parent(first));
}

TEST(SceneBuilder, ContinuedScenesKeepTheirIds)
{
    SceneBuilder b;
    const MeshId mesh = b.mesh(square(1).mesh());
    const InstanceId instance = b.instance(mesh);
    const Scene first = b.finish();
    SceneBuilder again(first);
    again.set_transform(instance, Transform::translation(0, 1, 0));
    const Scene second = again.finish();
    EXPECT_EQ(second.transform(instance), Transform::translation(0, 1, 0));
    EXPECT_EQ(first.transform(instance), Transform());
    EXPECT_EQ(second.mesh(instance), mesh);
    EXPECT_EQ(lengths_of(second), lengths_of(first));
    again.remove(instance);
    again.remove(mesh);
    EXPECT_TRUE(again.finish().instances().empty());
    EXPECT_EQ(second.instances().size(), 1u);
}

TEST(SceneBuilder, RemovedPartsAndOtherScenesAreRecognised)
{
    SceneBuilder b, other;
    const MeshId mesh = b.mesh(square(1).mesh()), foreign_mesh = other.mesh(square(1).mesh());
    const InstanceId kept = b.instance(mesh), removed = b.instance(mesh), foreign = other.instance(foreign_mesh);
    EXPECT_EQ(removed.index, kept.index + 1);
    b.remove(removed);
    const InstanceId in_its_place = b.instance(mesh);
    ASSERT_EQ(in_its_place.index, removed.index);
    EXPECT_NE(in_its_place, removed);
    for (const InstanceId& id : {removed, foreign, InstanceId()}) {
        EXPECT_THROW(b.set_transform(id, {}), UsageError);
        EXPECT_THROW(b.remove(id), UsageError);
        EXPECT_THROW(b.set_mobility(id, Mobility::may_move), UsageError);
        EXPECT_THROW(b.set_material(id, b.finish().materials().front()), UsageError);
        if (id) {
            EXPECT_THROW(b.node({}, {.parent = id}), UsageError);
        }
    }
    EXPECT_THROW(b.instance(foreign_mesh), UsageError);
    EXPECT_THROW(b.remove(foreign_mesh), UsageError);
    EXPECT_THROW(b.set_mesh(foreign_mesh, square(1).mesh()), UsageError);
}

TEST(SceneBuilder, MemoryIsFlatWhenPartsAreReplaced)
{
    SceneBuilder b;
    const MeshId fixed = b.mesh(square(1).mesh());
    b.instance(fixed);
    const std::vector<float> sky(3 * 8 * 4, 1.0f);
    std::optional<Lengths> expected;
    for (int round = 0; round < 1000; ++round) {
        const TextureId texture = add_texture(b);
        Material described;
        described.base_color_texture.texture = texture;
        const MaterialId material = b.material(described);
        const MeshId mesh = add_skinned(b);
        const NodeId group = b.node();
        const NodeId joint = b.node({}, {.parent = group});
        const SkinId skin = b.skin({{joint}, {Transform()}});
        b.instance(mesh, material, {}, {.parent = group, .skin = skin});
        b.instance(fixed, material, {}, {.parent = group});
        const LightId light = b.light({}, {}, {.parent = group});
        b.camera({}, {.parent = group});
        if (round % 100 == 0) b.environment({8, 4, sky}, 4);

        const Scene scene = b.finish();
        EXPECT_EQ(scene.instances().size(), 3u);
        if (!expected) expected = lengths_of(scene);
        ASSERT_EQ(lengths_of(scene), *expected) << "round " << round;

        EXPECT_THROW(b.remove(group), UsageError);   // the joint of a skin
        EXPECT_THROW(b.remove(skin), UsageError);    // an instance uses it
        EXPECT_THROW(b.remove(mesh), UsageError);
        EXPECT_THROW(b.remove(material), UsageError);
        EXPECT_THROW(b.remove(texture), UsageError);
        for (const InstanceId& instance : scene.instances())
            if (scene.parent(instance) == group) b.remove(instance);
        b.remove(skin);
        b.remove(group);
        EXPECT_THROW(b.remove(light), UsageError);   // went with its node
        b.remove(mesh);
        b.remove(material);
        b.remove(texture);
        EXPECT_THROW(b.remove(texture), UsageError);
        EXPECT_EQ(b.finish().instances().size(), 1u);
    }
}

TEST(SceneBuilder, MemoryIsFlatWhenASceneIsContinuedAgainAndAgain)
{
    SceneBuilder b;
    b.instance(b.mesh(square(1).mesh()));
    Scene scene = b.finish();
    std::optional<Lengths> expected;
    for (int round = 0; round < 100; ++round) {
        SceneBuilder next(scene);
        const MeshId mesh = next.mesh(square(2).mesh());
        const InstanceId instance = next.instance(mesh);
        scene = next.finish();
        if (!expected) expected = lengths_of(scene);
        ASSERT_EQ(lengths_of(scene), *expected) << "round " << round;
        SceneBuilder last(scene);
        last.remove(instance);
        last.remove(mesh);
        scene = last.finish();
    }
}

TEST(SceneBuilder, FailedCallsChangeNothing)
{
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    SceneBuilder b;
    const NodeId node = b.node();
    const LightId light = b.light({});
    const CameraId camera = b.camera({});
    const TextureId texture = add_texture(b);
    Material textured;
    textured.base_color_texture.texture = texture;
    const MaterialId material = b.material(textured);
    const Lengths lengths = lengths_of(b.finish());
    Transform skewed;
    skewed.m[3] = 1;
    const NodeId null;

    const test::Shape shape = square(1);
    Mesh wrong = shape.mesh();
    const std::vector<std::uint32_t> indices{0, 1, 4};
    wrong.indices = indices;
    const std::vector<float> sky(3 * 8 * 4 - 1, 1.0f);
    Material bad;
    bad.base_color = {nan, 0, 0};
    const std::function<void()> calls[] = {
        [&] { b.mesh(wrong); },
        [&] { b.material(bad); },
        [&] { b.texture({.width = 2, .height = 2, .channels = 5, .pixels = {}}); },
        [&] {
            b.skin({{node, null}, {Transform(), Transform()}});
        },
        [&] {
            b.skin({{node}, {}});
        },
        [&] { b.node(skewed); },
        [&] {
            b.node({}, {.parent = NodeId{7, 77}});
        },
        [&] { b.instance(MeshId{}); },
        [&] { b.light({}, skewed); },
        [&] {
            b.light({.color = {-1, 0, 0}});
        },
        [&] { b.camera({.transform = skewed}); },
        [&] { b.camera({.vertical_fov = 0}); },
        [&] {
            b.environment({8, 4, sky});
        },
        [&] {
            b.environment({8, 4, std::span(sky).first(3)}, 3);
        },
        [&] {
            b.background({-1, 0, 0});
        },
        [&] {
            b.ambient({nan, 0, 0});
        },
        [&] { b.clip(1, 0, 24); },
        [&] { b.set_material(material, bad); },
        [&] {
            b.set_light(light, {.color = {0, 0, nan}});
        },
        [&] { b.set_camera(camera, {.transform = skewed}); },
        [&] { b.set_transform(node, skewed); },
        [&] { b.remove(texture); },
    };
    int number = 0;
    for (const auto& call : calls) {
        EXPECT_THROW(call(), UsageError) << "call " << number;
        const Scene scene = b.finish();
        EXPECT_EQ(lengths_of(scene), lengths) << "call " << number;
        EXPECT_EQ(scene.transform(node), Transform());
        EXPECT_EQ(scene.light(light), Light());
        EXPECT_EQ(scene.camera(camera), Camera());
        EXPECT_EQ(scene.material(material), textured);
        EXPECT_EQ(scene.frame_count(), 1);
        ++number;
    }
}

TEST(SceneBuilder, MeshesWithoutMaterialsAreGrey)
{
    SceneBuilder b;
    const MeshId mesh = b.mesh(square(1).mesh());
    const InstanceId instance = b.instance(mesh, {}, Transform::translation(0, 0, -5));
    const Scene scene = b.finish();
    Renderer renderer(plain({9, 9}));
    renderer.render(scene, {.camera = camera_along_z()});
    const Pick pick = renderer.pick(4, 4);
    ASSERT_TRUE(pick.hit);
    EXPECT_EQ(pick.instance, instance);
    EXPECT_EQ(scene.material(pick.material), Material());

    // A grey that the host has changed is its own, and later meshes get another.
    b.set_material(pick.material, {.base_color = {1, 0, 0}});
    b.set_transform(instance, Transform::translation(0, 0, 5));
    b.instance(b.mesh(square(1).mesh()), {}, Transform::translation(0, 0, -5));
    const Scene second = b.finish();
    renderer.render(second, {.camera = camera_along_z()});
    EXPECT_EQ(second.material(renderer.pick(4, 4).material), Material());
}

TEST(SceneBuilder, InstancesOverrideMaterialsAndVariantsAreFreed)
{
    SceneBuilder b;
    const MaterialId red = b.material({.base_color = {1, 0, 0}}), blue = b.material({.base_color = {0, 0, 1}});
    const MeshId mesh = b.mesh(square(1).mesh());
    const InstanceId left = b.instance(mesh, red, Transform::translation(-2, 0, -5));
    const InstanceId right = b.instance(mesh, red, Transform::translation(2, 0, -5));
    const InstanceId grey = b.instance(mesh, {}, Transform::translation(0, 2.5, -5));
    Renderer renderer(plain({49, 49}));
    const auto material_at = [&](double x, double y) {
        const Pick pick = renderer.pick(static_cast<int>(24.5 + 24.5 * x / 5), static_cast<int>(24.5 - 24.5 * y / 5));
        EXPECT_TRUE(pick.hit);
        return pick.material;
    };
    const auto render = [&] {
        const Scene scene = b.finish();
        for (const InstanceId& id : {left, right, grey}) EXPECT_EQ(scene.mesh(id), mesh);
        renderer.render(scene, {.camera = camera_along_z()});
        return lengths_of(scene).meshes;
    };
    EXPECT_EQ(render(), 2u);   // the mesh and its red copy, which two instances share
    EXPECT_EQ(material_at(-2, 0), red);
    EXPECT_EQ(material_at(2, 0), red);
    EXPECT_EQ(b.finish().material(material_at(0, 2.5)), Material());
    EXPECT_EQ(b.finish().meshes(), std::vector<MeshId>{mesh});   // the copy has no id

    b.set_material(right, blue);
    EXPECT_EQ(render(), 3u);
    EXPECT_EQ(material_at(-2, 0), red);
    EXPECT_EQ(material_at(2, 0), blue);
    b.set_material(left, blue);
    b.remove(red);   // nobody uses it any more
    EXPECT_EQ(material_at(2, 0), blue);
    EXPECT_EQ(render(), 3u);
    // Another mesh takes the slot of the red copy.
    b.mesh(square(3).mesh());
    EXPECT_EQ(render(), 3u);

    // Another shape of the mesh is that of all instances, with their materials.
    const test::Shape larger = square(1.4f);
    b.set_mesh(mesh, larger.mesh());
    render();
    EXPECT_EQ(material_at(-3.2, 0), blue);
    EXPECT_EQ(material_at(3.2, 0), blue);
    EXPECT_THROW(b.remove(mesh), UsageError);
    for (const InstanceId& id : {left, right, grey}) b.remove(id);
    b.remove(mesh);
    b.remove(blue);
}

TEST(SceneBuilder, InstancesOfMeshesWithoutTrianglesKeepTheirMaterial)
{
    SceneBuilder b;
    const MaterialId red = b.material({.base_color = {1, 0, 0}});
    const MeshId mesh = b.mesh({});
    const InstanceId instance = b.instance(mesh, red, Transform::translation(0, 0, -5));
    EXPECT_TRUE(b.finish().instances().empty());
    EXPECT_THROW(b.remove(red), UsageError);
    b.set_mesh(mesh, square(1).mesh());
    const Scene scene = b.finish();
    EXPECT_EQ(scene.instances(), std::vector<InstanceId>{instance});
    Renderer renderer(plain({9, 9}));
    renderer.render(scene, {.camera = camera_along_z()});
    EXPECT_EQ(renderer.pick(4, 4).material, red);
}

TEST(SceneBuilder, PartsOfAMeshHaveMaterialsOfTheirOwn)
{
    SceneBuilder b;
    const MaterialId red = b.material({.base_color = {1, 0, 0}});
    Mesh mesh;
    const test::Shape shape = square(1);
    mesh = shape.mesh();
    const std::vector<MeshPart> parts{{{}, 0, 1}, {red, 1, 1}};
    mesh.parts = parts;
    b.instance(b.mesh(mesh), {}, Transform::translation(0, 0, -5));
    Renderer renderer(plain({49, 49}));
    const Scene scene = b.finish();
    renderer.render(scene, {.camera = camera_along_z()});
    EXPECT_EQ(renderer.pick(22, 22).material, red);   // the upper left triangle
    EXPECT_EQ(scene.material(renderer.pick(26, 26).material), Material());
}

TEST(SceneBuilder, LoadedFilesAreContinued)
{
    GNOMON_NEED_SCENE(file, "gltf/BoxAnimated.glb");
    const Scene loaded = load(file.string());
    const std::vector<InstanceId> instances = loaded.instances();
    ASSERT_GE(instances.size(), 2u);
    std::vector<NodeId> moving;
    for (const NodeId& node : loaded.nodes())
        if (loaded.mobility(node) != Mobility::fixed && loaded.moving_node(node) == node) moving.push_back(node);
    ASSERT_FALSE(moving.empty());
    const NodeId tracked = moving.front();

    SceneBuilder b(loaded);
    const Lengths lengths = lengths_of(loaded);
    EXPECT_EQ(lengths_of(b.finish()), lengths);
    EXPECT_EQ(b.finish().instances(), instances);
    EXPECT_EQ(b.finish().frame_count(), loaded.frame_count());

    // A transform replaces the track; nothing moves any more.
    for (const NodeId& node : moving) b.set_transform(node, Transform::translation(0, 3, 0));
    const Scene still = b.finish();
    EXPECT_EQ(still.transform(tracked), Transform::translation(0, 3, 0));
    Renderer renderer(plain({16, 16}));
    renderer.render(still, 1);
    renderer.render(still, still.frame_count());
    EXPECT_EQ(renderer.transform(tracked), Transform::translation(0, 3, 0));
    EXPECT_TRUE(renderer.report().instances.empty());
    renderer.render(loaded, 1);
    renderer.render(loaded, 20);
    EXPECT_NE(renderer.transform(tracked), Transform::translation(0, 3, 0));   // the file's scene is as it was
    EXPECT_FALSE(renderer.report().instances.empty());

    // A chair is added, and the animated part removed.
    const InstanceId added = b.instance(b.mesh(square(1).mesh()));
    b.remove(tracked);
    const Scene edited = b.finish();
    EXPECT_EQ(edited.name(added), "");
    EXPECT_THROW(edited.name(tracked), UsageError);
    EXPECT_NO_THROW(renderer.render(edited, 1));
}

}   // namespace
}   // namespace gnomon
