// SPDX-License-Identifier: Apache-2.0
// What advance() lists, what is dynamic, and that a step costs what changed.
#include "scene/state.h"

#include <gtest/gtest.h>

#include <ctime>
#include <glm/gtc/matrix_transform.hpp>

#include "sanitized.h"
#include "scene/mobility.h"

namespace gnomon::scene {
namespace {

// Slides along +X between two times, at one unit a second.
class Slide : public TransformTrack {
 public:
    Slide(double first, double last, glm::dvec3 from = {}) : first_(first), last_(last), from_(from) {}
    glm::dmat4 evaluate(double time) const override
    {
        return glm::translate(glm::dmat4(1), from_ + glm::dvec3(std::clamp(time, first_, last_) - first_, 0, 0));
    }
    std::vector<Interval> changing() const override { return {{first_, last_}}; }

 private:
    double first_, last_;
    glm::dvec3 from_;
};

Mesh one_triangle()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    return mesh;
}

Scene scene_with_triangle_mesh()
{
    Scene scene;
    scene.materials.emplace_back();
    scene.meshes.push_back(one_triangle());
    return scene;
}

NodeId add_object(Scene& scene, NodeId parent = none)
{
    const NodeId node = scene.add_node("", parent);
    scene.nodes[node].mesh = 0;
    return node;
}

std::vector<ObjectId> ids(std::initializer_list<ObjectId> list)
{
    return list;
}

TEST(SceneState, ListsWhatStartsMovesAndStops)
{
    Scene scene = scene_with_triangle_mesh();
    add_object(scene);   // object 0, still
    const NodeId dynamic_object = add_object(scene);
    scene.nodes[dynamic_object].transform = std::make_shared<Slide>(1, 2);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);

    EXPECT_FALSE(state.advance(0.5).anything());
    const FrameChanges& first = state.advance(1.5);
    EXPECT_EQ(first.moved, ids({1}));
    EXPECT_EQ(first.started, ids({1}));
    EXPECT_EQ(first.groups_moved, std::vector<GroupId>{0});
    EXPECT_FLOAT_EQ(state.object_matrix(1)[3].x, 0.5f);
    const FrameChanges& second = state.advance(1.75);
    EXPECT_EQ(second.moved, ids({1}));
    EXPECT_TRUE(second.started.empty());
    state.advance(3);
    const FrameChanges& rest = state.advance(4);
    EXPECT_TRUE(rest.moved.empty());
    EXPECT_EQ(rest.stopped, ids({1}));
    EXPECT_EQ(rest.touched_nodes, 0u);
    EXPECT_TRUE(state.advance(5).stopped.empty());
    // Backwards works alike.
    EXPECT_EQ(state.advance(0).moved, ids({1}));
    EXPECT_FLOAT_EQ(state.object_matrix(1)[3].x, 0.0f);
}

TEST(SceneState, AppearsAndVanishesByTheFlagFromItsTimeOn)
{
    Scene scene = scene_with_triangle_mesh();
    const NodeId parent = scene.add_node("", none);
    auto track = std::make_shared<VisibilityTrack>();
    track->times = {1, 2};
    track->visible = {false, true};
    scene.nodes[parent].visibility = track;
    add_object(scene, parent);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    EXPECT_TRUE(state.object_visible(0));
    EXPECT_FALSE(state.advance(0.999).anything());
    EXPECT_EQ(state.advance(1).vanished, ids({0}));
    EXPECT_FALSE(state.object_visible(0));
    EXPECT_EQ(state.advance(2).appeared, ids({0}));
    EXPECT_EQ(state.changes().groups_moved, std::vector<GroupId>{0});
    EXPECT_EQ(state.advance(1.5).vanished, ids({0}));
    EXPECT_EQ(state.advance(0.5).appeared, ids({0}));
}

TEST(SceneState, CarriesMovementDownAndToLights)
{
    Scene scene = scene_with_triangle_mesh();
    const NodeId root = scene.add_node("", none);
    scene.nodes[root].transform = std::make_shared<Slide>(0, 10);
    const NodeId arm = scene.add_node("", root, glm::translate(glm::dmat4(1), glm::dvec3(0, 1, 0)));
    const NodeId leaf = add_object(scene, arm);
    scene.nodes[leaf].transform = std::make_shared<Slide>(0, 10);
    Light light;
    light.node = arm;
    scene.lights.push_back(light);
    scene.finish();
    EXPECT_EQ(scene.objects[0].group, 0u);
    EXPECT_EQ(scene.groups[0].anchor, leaf);

    SceneState state(std::make_shared<Scene>(scene), 0);
    const FrameChanges& changes = state.advance(2);
    EXPECT_EQ(changes.moved, ids({0}));
    EXPECT_EQ(changes.lights_moved, std::vector<LightId>{0});
    EXPECT_EQ(state.light(0).position, glm::vec3(2, 1, 0));
    EXPECT_EQ(state.world(leaf)[3], glm::dvec4(4, 1, 0, 1));
    EXPECT_TRUE(state.advance(20).lights_moved.size() == 1 && state.advance(21).lights_stopped.size() == 1);
}

TEST(SceneState, AgreesWithAFreshStateAtAnyTime)
{
    Scene scene = scene_with_triangle_mesh();
    NodeId parent = none;
    for (int i = 0; i < 20; ++i) {
        const NodeId node = add_object(scene, i % 3 ? parent : none);
        if (i % 2) scene.nodes[node].transform = std::make_shared<Slide>(0.3 * i, 0.3 * i + 2);
        parent = node;
    }
    scene.finish();
    const auto shared = std::make_shared<Scene>(scene);
    SceneState walked(shared, 0);
    for (const double time : {0.1, 3.0, 2.9, 2.9, 8.0, 0.0, 5.5}) {
        walked.advance(time);
        const SceneState fresh(shared, time);
        for (NodeId n = 0; n < scene.nodes.size(); ++n)
            EXPECT_EQ(walked.world(n), fresh.world(n)) << n << " at " << time;
    }
}

glm::dmat4 at_height(double y)
{
    return glm::translate(glm::dmat4(1), glm::dvec3(0, y, 0));
}

TEST(SceneState, FollowsAUserOverrideAndItsRemoval)
{
    Scene scene = scene_with_triangle_mesh();
    const NodeId node = add_object(scene);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    const glm::dmat4 there = at_height(5);
    state.override_transform(node, &there);
    EXPECT_EQ(state.advance(0).moved, ids({0}));
    EXPECT_EQ(state.object_matrix(0)[3].y, 5.0f);
    state.override_transform(node, nullptr);
    EXPECT_EQ(state.advance(0).moved, ids({0}));
    EXPECT_EQ(state.object_matrix(0)[3].y, 0.0f);
}

TEST(SceneState, AStaticObjectIsPromotedOnceAndStaysDynamic)
{
    Scene scene = scene_with_triangle_mesh();
    scene.nodes[add_object(scene)].transform = std::make_shared<Slide>(5, 6);
    for (int i = 0; i < 3; ++i) add_object(scene);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    EXPECT_EQ(state.dynamic_objects(), ids({0}));
    const glm::dmat4 there = at_height(5), higher = at_height(6);

    state.override_transform(scene.objects[3].node, &there);
    EXPECT_FALSE(state.is_dynamic(3)) << "before the next step";
    EXPECT_EQ(state.advance(0).promoted, ids({3}));
    EXPECT_TRUE(state.is_dynamic(3));
    state.override_transform(scene.objects[3].node, &higher);
    EXPECT_TRUE(state.advance(0).promoted.empty()) << "it was promoted before";
    EXPECT_EQ(state.changes().changed, ids({3}));
    state.override_transform(scene.objects[3].node, nullptr);
    EXPECT_TRUE(state.advance(0).promoted.empty());
    EXPECT_TRUE(state.is_dynamic(3)) << "after the override was removed";
    state.advance(1);
    EXPECT_TRUE(state.is_dynamic(3));

    // Later ones follow in dynamic_objects().
    state.override_transform(scene.objects[1].node, &there);
    EXPECT_EQ(state.advance(1).promoted, ids({1}));
    EXPECT_EQ(state.dynamic_objects(), ids({0, 3, 1}));
    EXPECT_EQ(state.dynamic_index(3), 1u);
    EXPECT_EQ(state.dynamic_index(1), 2u);
    EXPECT_EQ(state.dynamic_index(2), none);
    EXPECT_FALSE(state.is_dynamic(2));
}

TEST(SceneState, AnOverrideOfADynamicObjectIsNoPromotion)
{
    Scene scene = scene_with_triangle_mesh();
    const NodeId anchor = scene.add_node("anchor", none);
    scene.nodes[anchor].transform = std::make_shared<Slide>(5, 6);
    add_object(scene, anchor);
    add_object(scene, anchor);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    const glm::dmat4 there = at_height(5);
    // The whole group.
    state.override_transform(anchor, &there);
    EXPECT_EQ(state.advance(0).changed, ids({0, 1}));
    EXPECT_TRUE(state.changes().promoted.empty());
    EXPECT_TRUE(state.changes().separated.empty());
    // One member against it: for good.
    state.override_transform(scene.objects[1].node, &there);
    EXPECT_EQ(state.advance(0).separated, ids({1}));
    EXPECT_TRUE(state.changes().promoted.empty());
    EXPECT_EQ(state.group_of(0), 0u);
    EXPECT_EQ(state.group_of(1), none);
    state.override_transform(scene.objects[1].node, nullptr);
    EXPECT_TRUE(state.advance(0).separated.empty());
    EXPECT_EQ(state.group_of(1), none);
    EXPECT_EQ(state.dynamic_objects(), ids({0, 1}));
}

TEST(SceneState, AnOverrideOfAParentPromotesAllObjectsBelow)
{
    Scene scene = scene_with_triangle_mesh();
    const NodeId shelf = scene.add_node("shelf", none);
    add_object(scene, shelf);
    add_object(scene);
    add_object(scene, shelf);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    const glm::dmat4 there = at_height(5);
    state.override_transform(shelf, &there);
    EXPECT_EQ(state.advance(0).promoted, ids({0, 2}));
    EXPECT_EQ(state.dynamic_objects(), ids({0, 2}));
}

TEST(SceneState, AnOverrideWithThePresentMatrixChangesNothing)
{
    Scene scene = scene_with_triangle_mesh();
    const NodeId shelf = scene.add_node("shelf", none);
    const NodeId node = add_object(scene, shelf);
    for (int i = 0; i < 100; ++i) add_object(scene, shelf);
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    for (const NodeId n : {node, shelf}) {
        const glm::dmat4 same(1);
        state.override_transform(n, &same);
        EXPECT_FALSE(state.advance(0).anything());
        EXPECT_EQ(state.changes().touched_nodes, 1u) << "the node itself, and none below";
        EXPECT_TRUE(state.changes().promoted.empty());
    }
    EXPECT_TRUE(state.dynamic_objects().empty());
}

TEST(SceneState, ChangedHoldsEachObjectOnceInOrder)
{
    Scene scene = scene_with_triangle_mesh();
    scene.meshes.push_back(one_triangle());
    VertexKeys keys;
    keys.times = {0, 9};
    keys.positions.assign(2, scene.meshes[1].positions);
    keys.positions[1][0].z = 1;
    scene.meshes.edit(1).vertex_keys = keys;
    const auto blinks = [](bool first) {
        auto track = std::make_shared<VisibilityTrack>();
        track->times = {0, 1};
        track->visible = {first, !first};
        return track;
    };
    scene.nodes[add_object(scene)].visibility = blinks(true);   // 0 vanishes
    const NodeId both = add_object(scene);                      // 1 moves and deforms
    scene.nodes[both].mesh = 1;
    scene.nodes[both].transform = std::make_shared<Slide>(0, 9);
    add_object(scene);                          // 2 rests
    const NodeId appears = add_object(scene);   // 3 appears and moves
    scene.nodes[appears].visibility = blinks(false);
    scene.nodes[appears].transform = std::make_shared<Slide>(0, 9);
    const NodeId taken = add_object(scene);   // 4 is taken by the user
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0.5);
    const glm::dmat4 there = at_height(5);
    state.override_transform(taken, &there);
    const FrameChanges& changes = state.advance(1.5);
    EXPECT_EQ(changes.moved, ids({1, 3, 4}));
    EXPECT_EQ(changes.deformed, ids({1}));
    EXPECT_EQ(changes.appeared, ids({3}));
    EXPECT_EQ(changes.vanished, ids({0}));
    EXPECT_EQ(changes.changed, ids({0, 1, 3, 4}));
    EXPECT_EQ(changes.promoted, ids({4}));
    EXPECT_FALSE(state.advance(1.5).anything());
    EXPECT_TRUE(state.changes().promoted.empty()) << "lists are of one step";
}

// Whether an object is there follows the transform that places it: of a promoted or separated object, its own.
TEST(SceneState, ASingularTransformTakesAwayWhatIsDynamic)
{
    Scene scene = scene_with_triangle_mesh();
    const glm::dmat4 flat = glm::scale(glm::dmat4(1), glm::dvec3(1, 0, 1));
    const NodeId node = add_object(scene);
    scene.nodes[node].local = flat;
    const NodeId anchor = scene.add_node("anchor", none);
    scene.nodes[anchor].transform = std::make_shared<Slide>(5, 6);
    const NodeId member = add_object(scene, anchor), flat_member = add_object(scene, anchor);
    scene.nodes[flat_member].local = flat;
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    const auto there = [&] {
        return std::vector<bool>{state.object_there(0), state.object_there(1), state.object_there(2)};
    };
    EXPECT_EQ(there(), (std::vector<bool>{true, true, true})) << "static ones, and members of a regular group";

    const glm::dmat4 higher = at_height(1) * flat;
    state.override_transform(node, &higher);
    state.override_transform(member, &higher);
    state.advance(0);
    EXPECT_EQ(there(), (std::vector<bool>{false, false, true})) << "promoted; separated";
    const glm::dmat4 regular = at_height(2);
    state.override_transform(node, &regular);
    state.override_transform(member, nullptr);
    EXPECT_EQ(state.advance(0).changed, ids({0, 1}));
    EXPECT_EQ(there(), (std::vector<bool>{true, true, true}));

    // The flat member keeps its matrix when its group's becomes singular, and is listed all the same.
    state.override_transform(anchor, &flat);
    const glm::mat4 before = state.object_matrix(2);
    EXPECT_EQ(state.advance(0).changed, ids({1, 2}));
    EXPECT_EQ(state.object_matrix(2), before);
    EXPECT_EQ(there(), (std::vector<bool>{true, false, false}));
    state.override_transform(anchor, nullptr);
    EXPECT_EQ(state.advance(0).changed, ids({1, 2}));
    EXPECT_EQ(there(), (std::vector<bool>{true, true, true}));
}

// 10 dynamic objects among `count` objects: what one step touches.
std::uint64_t touched_with(int count)
{
    Scene scene = scene_with_triangle_mesh();
    for (int i = 0; i < count; ++i) {
        const NodeId node = add_object(scene);
        if (i < 10) scene.nodes[node].transform = std::make_shared<Slide>(0, 100);
        // Those that can move, but rest now, must not cost either.
        else if (i % 2)
            scene.nodes[node].transform = std::make_shared<Slide>(50, 100);
    }
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    Mobility mobility(scene.objects.size());
    mobility.update(state.advance(1));
    mobility.update(state.advance(2));
    EXPECT_EQ(state.changes().moved.size(), 10u);
    EXPECT_EQ(mobility.dynamic_objects().size(), 10u);
    return state.changes().touched_nodes + mobility.touched();
}

TEST(SceneState, CostsWhatMovesNotWhatIsThere)
{
    const std::uint64_t few = touched_with(100);
    EXPECT_EQ(few, touched_with(100'000));
    EXPECT_LE(few, 40u);
}

TEST(SceneState, DeformsVertexKeysAndMorphsOnlyWhenTheyChange)
{
    Scene scene = scene_with_triangle_mesh();
    Mesh& mesh = scene.meshes.edit(0);
    mesh.vertex_keys.emplace();
    mesh.vertex_keys->times = {0, 2};
    mesh.vertex_keys->positions = {mesh.positions, {{0, 0, 4}, {1, 0, 4}, {0, 1, 4}}};
    add_object(scene);
    scene.finish();
    EXPECT_TRUE(scene.objects[0].dynamic);
    EXPECT_TRUE(scene.objects[0].deforming);
    SceneState state(std::make_shared<Scene>(scene), 0);
    EXPECT_EQ(state.advance(1).deformed, ids({0}));
    EXPECT_EQ(state.deformed(0).positions[0], glm::vec3(0, 0, 2));
    state.advance(3);
    EXPECT_EQ(state.deformed(0).positions[0], glm::vec3(0, 0, 4));
    EXPECT_TRUE(state.advance(4).deformed.empty());
    EXPECT_EQ(state.changes().stopped, ids({0}));
}

TEST(SceneState, SkinsBlendJoints)
{
    Scene scene = scene_with_triangle_mesh();
    Mesh& mesh = scene.meshes.edit(0);
    mesh.skin.emplace();
    mesh.skin->joints[0] = {{0, 1, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}};
    mesh.skin->weights[0] = {{1, 0, 0, 0}, {0.5f, 0.5f, 0, 0}, {0, 1, 0, 0}};
    const NodeId still = scene.add_node("", none), moving = scene.add_node("", none);
    scene.nodes[moving].transform = std::make_shared<Slide>(0, 10);
    scene.skins.push_back({"", {still, moving}, {glm::dmat4(1), glm::dmat4(1)}});
    scene.nodes[add_object(scene)].skin = 0;
    scene.finish();
    SceneState state(std::make_shared<Scene>(scene), 0);
    EXPECT_EQ(state.advance(4).deformed, ids({0}));
    EXPECT_EQ(state.deformed(0).positions[0], glm::vec3(0, 0, 0));
    EXPECT_EQ(state.deformed(0).positions[1], glm::vec3(3, 0, 0));
    EXPECT_EQ(state.deformed(0).positions[2], glm::vec3(4, 1, 0));
}

FrameChanges moving(std::vector<ObjectId> moved)
{
    FrameChanges changes;
    changes.moved = changes.changed = std::move(moved);
    return changes;
}

TEST(SceneState, ManyObjectsOnOneSkinOfManyJoints)
{
    constexpr int many = 20'000;
    Scene scene = scene_with_triangle_mesh();
    SkinBinding& binding = scene.meshes.edit(0).skin.emplace();
    binding.joints[0].assign(3, glm::u16vec4(0));
    binding.weights[0].assign(3, glm::vec4(1, 0, 0, 0));
    const NodeId dynamic_object = scene.add_node("dynamic object", none);
    scene.nodes[dynamic_object].transform = std::make_shared<Slide>(1, 2);
    Skin skin;
    for (int i = 0; i < many; ++i) skin.joints.push_back(scene.add_node("joint", dynamic_object));
    skin.inverse_bind.assign(many, glm::dmat4(1));
    scene.skins.push_back(skin);
    for (int i = 0; i < many; ++i) scene.nodes[add_object(scene)].skin = 0;
    scene.finish();

    // Joints times objects would be 400 million.
    const std::clock_t start = std::clock();
    SceneState state(std::make_shared<const Scene>(std::move(scene)), 0);
    EXPECT_EQ(state.advance(1.5).deformed.size(), static_cast<std::size_t>(many));
    EXPECT_EQ(state.deformed(many - 1).positions[1], glm::vec3(1.5f, 0, 0));
    EXPECT_EQ(state.advance(3).deformed.size(), static_cast<std::size_t>(many));
    EXPECT_EQ(state.deformed(0).positions[1], glm::vec3(2, 0, 0));
    EXPECT_TRUE(state.advance(4).deformed.empty());
    EXPECT_LT(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC, 2.0 * test::k_patience);
}

TEST(Mobility, WakesAtOnceAndSleepsAfterItsRest)
{
    Mobility mobility(3, 2);
    mobility.update(moving({1}));
    EXPECT_EQ(mobility.became_dynamic(), ids({1}));
    mobility.update(moving({}));
    EXPECT_TRUE(mobility.is_dynamic(1));
    mobility.update(moving({1}));   // moved again during its rest
    mobility.update(moving({}));
    EXPECT_TRUE(mobility.is_dynamic(1));
    mobility.update(moving({}));
    EXPECT_EQ(mobility.became_static(), ids({1}));
    EXPECT_FALSE(mobility.is_dynamic(1));
    mobility.update(moving({}));
    EXPECT_EQ(mobility.touched(), 0u);
}

TEST(Mobility, ObeysItsAuthor)
{
    Mobility mobility(2, 1);
    mobility.set_override(0, MobilityOverride::always_static);
    mobility.set_override(1, MobilityOverride::always_dynamic);
    for (int i = 0; i < 4; ++i) mobility.update(moving(i == 0 ? std::vector<ObjectId>{0} : std::vector<ObjectId>{}));
    EXPECT_FALSE(mobility.is_dynamic(0));
    EXPECT_TRUE(mobility.is_dynamic(1));
    mobility.set_override(1, MobilityOverride::automatic);
    mobility.update(moving({}));
    EXPECT_FALSE(mobility.is_dynamic(1));
}

}   // namespace
}   // namespace gnomon::scene
