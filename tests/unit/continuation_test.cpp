// SPDX-License-Identifier: Apache-2.0
#include "scene/continuation.h"

#include <gtest/gtest.h>

#include "scene/state.h"

namespace gnomon::scene {
namespace {

class Rest final : public TransformTrack {
 public:
    glm::dmat4 evaluate(double) const override { return glm::dmat4(1); }
    std::vector<Interval> changing() const override { return {}; }
};

Mesh triangle(float size)
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    return mesh;
}

NodeId place(Scene& scene, MeshId mesh, bool moves, NodeId parent = none)
{
    const NodeId node = scene.add_node("", parent);
    scene.nodes[node].mesh = mesh;
    scene.nodes[node].animated = moves;
    return node;
}

// A floor, a light, and objects that may move on nodes 2, 3 and 4; object 4 carries 5.
Scene made()
{
    Scene scene;
    scene.materials.emplace_back();
    for (const float size : {9.0f, 1.0f, 2.0f}) scene.meshes.push_back(triangle(size));
    place(scene, 0, false);
    scene.lights.emplace_back().node = scene.add_node("light", none);
    for (const MeshId mesh : {1, 2, 1}) place(scene, mesh, true);
    place(scene, 2, false, 4);
    scene.finish();
    return scene;
}

void remove(Scene& scene, NodeId node)
{
    scene.nodes[node] = {};
}

std::optional<Continuation> continued(const Scene& before, Scene& wanted)
{
    wanted.finish();
    return continuation(before, wanted);
}

TEST(Continuation, ObjectsThatStayKeepTheirNumbers)
{
    const Scene before = made();
    ASSERT_EQ(before.objects.size(), 5u);
    Scene wanted = before;
    remove(wanted, 2);
    place(wanted, 2, true);
    const auto next = continued(before, wanted);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->removed, std::vector<ObjectId>{1});
    EXPECT_EQ(next->added, std::vector<ObjectId>{5});
    EXPECT_EQ(next->replaced, (std::vector<NodeId>{2, 6}));
    const Scene& scene = *next->scene;
    ASSERT_EQ(scene.objects.size(), 6u);
    EXPECT_TRUE(scene.objects[1].removed);
    for (const ObjectId o : {0, 2, 3, 4}) {
        EXPECT_FALSE(scene.objects[o].removed);
        EXPECT_EQ(scene.objects[o].node, before.objects[o].node);
        EXPECT_EQ(scene.objects[o].group, before.objects[o].group);
    }
    EXPECT_EQ(scene.objects[5].node, 6u);
    EXPECT_EQ(scene.groups[scene.objects[5].group].objects, std::vector<ObjectId>{5});
    EXPECT_EQ(scene.groups[scene.objects[5].group].anchor, 6u);
    EXPECT_EQ(scene.statistics().objects, 5u);
}

TEST(Continuation, AnObjectTakesTheNumberOfOneWithItsMeshThatWentBefore)
{
    const Scene first = made();
    Scene second = first;
    remove(second, 2);
    const auto without = continued(first, second);
    ASSERT_TRUE(without);
    Scene third = second;
    place(third, 2, true);
    place(third, 1, true);
    const auto next = continued(*without->scene, third);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->added, (std::vector<ObjectId>{1, 5}));
    EXPECT_EQ(next->scene->objects[1].mesh, 1u);
    EXPECT_EQ(next->scene->objects[1].node, 7u);
    EXPECT_FALSE(next->scene->objects[1].removed);
    EXPECT_EQ(next->scene->objects[5].mesh, 2u);
}

TEST(Continuation, AGroupThatLosesOrGainsAnObjectIsReplacedWhole)
{
    const Scene before = made();
    Scene without = before;
    remove(without, 5);
    const auto lost = continued(before, without);
    ASSERT_TRUE(lost);
    EXPECT_EQ(lost->removed, (std::vector<ObjectId>{3, 4}));
    EXPECT_EQ(lost->added.size(), 1u);

    Scene with = before;
    place(with, 1, false, 3);
    const auto gained = continued(before, with);
    ASSERT_TRUE(gained);
    EXPECT_EQ(gained->removed, std::vector<ObjectId>{2});
    EXPECT_EQ(gained->added.size(), 2u);
}

TEST(Continuation, AMeshThatWasEditedGetsANewNumber)
{
    const Scene before = made();
    Scene wanted = before;
    wanted.meshes.replace(1, triangle(3));
    const auto next = continued(before, wanted);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->scene->meshes.size(), 4u);
    EXPECT_EQ(next->removed, (std::vector<ObjectId>{1, 3, 4}));   // 3 and 4 move together
    EXPECT_EQ(next->scene->nodes[2].mesh, 3u);
    EXPECT_EQ(next->scene->meshes[3].positions[1].x, 3);
}

TEST(Continuation, MaterialsKeepTheirLookToRaysOrWereInNoUse)
{
    Scene before = made();
    before.materials.emplace_back();
    before.finish();
    Scene wanted = before;
    wanted.materials[0].base_color = glm::vec4(0.1f);
    wanted.materials[1].alpha_mode = AlphaMode::mask;
    const auto next = continued(before, wanted);
    ASSERT_TRUE(next);
    EXPECT_EQ(next->edited, std::vector<MaterialId>{0});
    EXPECT_EQ(next->scene->materials[1].alpha_mode, AlphaMode::mask);
    wanted.materials[0].alpha_mode = AlphaMode::mask;
    EXPECT_FALSE(continued(before, wanted));
}

TEST(Continuation, AnythingElseBeginsAnew)
{
    const Scene before = made();
    const auto refuses = [&](const auto& edit) {
        Scene wanted = before;
        edit(wanted);
        return !continued(before, wanted).has_value();
    };
    EXPECT_FALSE(refuses([](Scene&) {}));
    EXPECT_TRUE(refuses([](Scene& s) { remove(s, 0); }));                       // static
    EXPECT_TRUE(refuses([](Scene& s) { place(s, 1, false); }));                 // static
    EXPECT_TRUE(refuses([](Scene& s) { s.nodes[0].local[3].x = 1; }));          // static
    EXPECT_TRUE(refuses([](Scene& s) { s.nodes[0].animated = true; }));         // static no longer
    EXPECT_TRUE(refuses([](Scene& s) { s.meshes.replace(0, triangle(4)); }));   // static
    EXPECT_TRUE(refuses([](Scene& s) { s.lights.emplace_back().node = 1; }));
    EXPECT_TRUE(refuses([](Scene& s) { s.lights[0].type = LightType::directional; }));
    EXPECT_TRUE(refuses([](Scene& s) { s.nodes[1].local[3].y = 2; }));   // the light's place
    EXPECT_TRUE(refuses([](Scene& s) { s.background.color = glm::vec3(1); }));
    EXPECT_TRUE(refuses([](Scene& s) { s.ambient = glm::vec3(1); }));
    EXPECT_TRUE(refuses([](Scene& s) { s.timeline.frames = 2; }));
    EXPECT_TRUE(refuses([](Scene& s) { s.nodes[2].transform = std::make_shared<const Rest>(); }));
    EXPECT_FALSE(refuses([](Scene& s) { s.lights[0].color = glm::vec3(4); }));   // a value
    EXPECT_FALSE(refuses([](Scene& s) { s.cameras.emplace_back().node = 0; }));
    EXPECT_FALSE(refuses([](Scene& s) { s.nodes[3].local[3].x = 1; }));   // it may move
}

TEST(Continuation, TooManyRemovedObjectsBeginAnew)
{
    Scene scene = made();
    const std::size_t base = scene.nodes.size();
    constexpr int k_many = 1100;
    for (int i = 0; i < k_many; ++i) place(scene, 1, true);
    scene.finish();
    Scene few = scene;
    for (int i = 0; i < 1000; ++i) remove(few, static_cast<NodeId>(base + static_cast<std::size_t>(i)));
    EXPECT_TRUE(continued(scene, few));
    for (int i = 1000; i < k_many; ++i) remove(few, static_cast<NodeId>(base + static_cast<std::size_t>(i)));
    EXPECT_FALSE(continued(scene, few));
}

TEST(Continuation, AStateListsWhatCameAndWent)
{
    const auto before = std::make_shared<Scene>(made());
    SceneState state(before, 0);
    Scene wanted = *before;
    remove(wanted, 3);
    wanted.nodes[3].mesh = 1;   // another object in the same place
    wanted.nodes[3].animated = true;
    wanted.nodes[3].local[3] = glm::dvec4(1, 2, 3, 1);
    const auto next = continued(*before, wanted);
    ASSERT_TRUE(next);
    state.continue_with(*next);
    const FrameChanges& changes = state.advance(0);
    EXPECT_EQ(changes.removed, std::vector<ObjectId>{2});
    EXPECT_EQ(changes.vanished, std::vector<ObjectId>{2});
    EXPECT_EQ(changes.added, std::vector<ObjectId>{5});
    EXPECT_EQ(changes.appeared, std::vector<ObjectId>{5});
    EXPECT_TRUE(changes.promoted.empty());
    EXPECT_FALSE(state.object_visible(2));
    EXPECT_TRUE(state.object_visible(5));
    EXPECT_EQ(state.object_at(3), 5u);
    EXPECT_EQ(state.object_matrix(5)[3], glm::vec4(1, 2, 3, 1));
    EXPECT_TRUE(state.advance(0).changed.empty());
    EXPECT_TRUE(state.changes().added.empty());
}

TEST(Continuation, WhatIsNumberedAnewAppears)
{
    // Object 4 rode on object 3; now it may move by itself, so both get other numbers and groups.
    const auto before = std::make_shared<Scene>(made());
    SceneState state(before, 0);
    Scene wanted = *before;
    wanted.nodes[5].animated = true;
    const auto next = continued(*before, wanted);
    ASSERT_TRUE(next);
    state.continue_with(*next);
    glm::dmat4 place(1);
    place[3] = glm::dvec4(1, 2, 3, 1);
    state.override_transform(5, &place);
    const FrameChanges& changes = state.advance(0);
    EXPECT_EQ(changes.vanished, (std::vector<ObjectId>{3, 4}));
    EXPECT_EQ(changes.added, (std::vector<ObjectId>{5, 6}));
    EXPECT_EQ(changes.appeared, changes.added) << "one of them stands where it was, the other moves";
    EXPECT_TRUE(changes.moved.empty());
    EXPECT_EQ(changes.groups_moved.size(), 2u);
}

TEST(Continuation, AStateKeepsTheOverridesThatAHostStillHas)
{
    const auto before = std::make_shared<Scene>(made());
    SceneState state(before, 0);
    glm::dmat4 moved(1);
    moved[3].y = 7;
    state.override_transform(2, &moved);
    state.override_transform(3, &moved);
    Light dim = before->lights[0];
    dim.color = glm::vec3(0.5f);
    state.set_light(0, dim);
    state.advance(0);
    Scene wanted = *before;
    place(wanted, 1, true);
    state.continue_with(*continued(*before, wanted));
    const auto yes = [](std::uint32_t) { return true; };
    state.keep_overrides(
        {[](std::uint32_t n) { return n == 2; }, yes, yes, yes, [](std::uint32_t) { return false; }, yes});
    const FrameChanges& changes = state.advance(0);
    EXPECT_EQ(changes.moved, std::vector<ObjectId>{2});
    EXPECT_EQ(changes.appeared, std::vector<ObjectId>{5});
    EXPECT_EQ(changes.lights_relit, std::vector<LightId>{0});
    EXPECT_EQ(state.world(2)[3].y, 7);
    EXPECT_EQ(state.world(3)[3].y, 0);
    EXPECT_EQ(state.scene().lights[0].color, before->lights[0].color);
}

}   // namespace
}   // namespace gnomon::scene
