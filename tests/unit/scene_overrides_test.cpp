// SPDX-License-Identifier: Apache-2.0
// What a host sets in a scene's state: what each setter changes, that equal values change nothing, and that a step
// costs what was set.
#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "gnomon/error.h"
#include "scene/state.h"

namespace gnomon::scene {
namespace {

// Slides along +X, at one unit a second from 0 to 9 seconds.
class Slide final : public TransformTrack {
 public:
    glm::dmat4 evaluate(double time) const override
    {
        return glm::translate(glm::dmat4(1), glm::dvec3(std::clamp(time, 0.0, 9.0), 0, 0));
    }
    std::vector<Interval> changing() const override { return {{0, 9}}; }
};

// One weight that grows by 1 a second, from 0 to 9 seconds.
class Growing final : public WeightsTrack {
 public:
    void evaluate(double time, std::vector<float>& weights) const override
    {
        weights[0] = static_cast<float>(std::clamp(time, 0.0, 9.0));
    }
    std::vector<Interval> changing() const override { return {{0, 9}}; }
};

using Ids = std::vector<std::uint32_t>;

glm::dmat4 at(double x, double y = 0)
{
    return glm::translate(glm::dmat4(1), glm::dvec3(x, y, 0));
}

Mesh square()
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.normals.assign(4, glm::vec3(0, 0, 1));
    mesh.tangents.assign(4, glm::vec4(1, 0, 0, -1));
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.parts = {{0, 0, 2}};
    return mesh;
}

Scene scene_with_square()
{
    Scene scene;
    scene.materials.emplace_back();
    scene.meshes.push_back(square());
    return scene;
}

NodeId add_object(Scene& scene, NodeId parent = none)
{
    const NodeId node = scene.add_node("", parent);
    scene.nodes[node].mesh = 0;
    return node;
}

std::shared_ptr<const Scene> finished(Scene& scene)
{
    scene.finish();
    return std::make_shared<Scene>(scene);
}

DeformedMesh raised(float height)
{
    DeformedMesh shape;
    shape.positions = square().positions;
    for (glm::vec3& p : shape.positions) p.z += height;
    return shape;
}

TEST(SharedList, CopiesShareElementsUntilOneIsEdited)
{
    SharedList<Mesh> list;
    list.push_back(square());
    list.push_back(square());
    SharedList<Mesh> copy = list;
    EXPECT_EQ(&copy[0], &list[0]);
    const Mesh* const shared = &list[0];
    copy.edit(0).name = "edited";
    EXPECT_EQ(&list[0], shared);
    EXPECT_TRUE(list[0].name.empty());
    EXPECT_EQ(copy[0].name, "edited");
    EXPECT_EQ(&copy[1], &list[1]) << "others stay shared";
    const Mesh* const own = &copy[0];
    copy.edit(0).name = "again";
    EXPECT_EQ(&copy[0], own) << "an element of one list is edited in place";
    EXPECT_EQ(std::distance(list.begin(), list.end()), 2);
    EXPECT_THROW(list.edit(2), InternalError);
    EXPECT_THROW(list.at(2), InternalError);
}

TEST(SceneFinish, ComputesEverythingAnewAndCopiesNoMesh)
{
    Scene scene = scene_with_square();
    const NodeId first = add_object(scene), second = add_object(scene);
    scene.nodes[first].transform = std::make_shared<Slide>();
    scene.finish();
    EXPECT_TRUE(scene.objects[0].dynamic);
    EXPECT_FALSE(scene.objects[1].dynamic);

    Scene copy = scene;
    copy.nodes[first].transform = nullptr;
    copy.nodes[second].deforms = true;
    copy.finish();
    EXPECT_FALSE(copy.objects[0].dynamic);
    EXPECT_TRUE(copy.objects[1].dynamic && copy.objects[1].deforming);
    EXPECT_EQ(copy.objects.size(), 2u);
    EXPECT_TRUE(copy.groups.empty() && copy.track_nodes.empty());
    EXPECT_EQ(&copy.meshes[0], &scene.meshes[0]);

    // A mesh is copied where its triangles must be sorted.
    copy.materials.emplace_back();
    copy.materials[0].transmission = 1;
    copy.meshes.edit(0).parts = {{0, 0, 1}, {1, 1, 1}};
    scene.meshes = copy.meshes;
    copy.finish();
    EXPECT_NE(&copy.meshes[0], &scene.meshes[0]);
    EXPECT_EQ(copy.meshes[0].parts[0].material, 1u);
    EXPECT_EQ(scene.meshes[0].parts[0].material, 0u);
}

TEST(Overrides, TheStateEditsItsOwnSceneAndSharesMeshes)
{
    Scene scene = scene_with_square();
    scene.lights.push_back({.name = "light", .type = LightType::spot, .node = add_object(scene)});
    const auto given = finished(scene);
    SceneState state(given, 0);
    EXPECT_NE(&state.scene(), given.get());
    EXPECT_EQ(&state.scene().meshes[0], &given->meshes[0]);
    Light dim = given->lights[0];
    dim.color = glm::vec3(0.1f);
    state.set_light(0, dim);
    EXPECT_EQ(state.scene().lights[0].color, glm::vec3(1)) << "not before the next step";
    state.advance(0);
    EXPECT_EQ(state.scene().lights[0].color, dim.color);
    EXPECT_EQ(given->lights[0].color, glm::vec3(1));
}

TEST(Overrides, VisibilityHidesWhatIsBelowAndGivesItBack)
{
    Scene scene = scene_with_square();
    const NodeId shelf = scene.add_node("shelf", none);
    const NodeId on_it = add_object(scene, shelf);
    add_object(scene);
    auto late = std::make_shared<VisibilityTrack>();
    late->times = {0, 5};
    late->visible = {false, true};
    scene.nodes[on_it].visibility = late;
    const auto given = finished(scene);
    SceneState state(given, 1);

    state.override_visibility(on_it, true);
    EXPECT_EQ(state.advance(2).appeared, Ids{0});
    EXPECT_FALSE(state.advance(6).anything()) << "the track is not followed";
    state.override_visibility(shelf, false);
    EXPECT_EQ(state.advance(6).vanished, Ids{0});
    state.override_visibility(on_it, {});
    state.override_visibility(shelf, {});
    EXPECT_EQ(state.advance(7).appeared, Ids{0});
    EXPECT_EQ(state.advance(1).vanished, Ids{0}) << "the track is followed again";
}

TEST(Overrides, HidingAStaticObjectPromotesItAndHidingAMemberSeparatesIt)
{
    Scene scene = scene_with_square();
    const NodeId fixed = add_object(scene);
    const NodeId anchor = scene.add_node("anchor", none);
    scene.nodes[anchor].animated = true;
    const NodeId member = add_object(scene, anchor), other = add_object(scene, anchor);
    const auto given = finished(scene);
    SceneState state(given, 0);
    state.override_visibility(fixed, false);
    state.override_visibility(member, false);
    EXPECT_EQ(state.advance(0).promoted, Ids{0});
    EXPECT_EQ(state.changes().separated, Ids{1});
    EXPECT_EQ(state.taken_objects(), (Ids{0, 1}));

    // A member that was hidden together with its group is separated when the group is shown without it.
    state.override_visibility(anchor, false);
    state.advance(0);
    state.override_visibility(other, false);
    EXPECT_TRUE(state.advance(0).separated.empty());
    state.override_visibility(anchor, true);
    EXPECT_EQ(state.advance(0).separated, Ids{2});
    EXPECT_FALSE(state.object_visible(2));
}

TEST(Overrides, WeightsReplaceTheTrack)
{
    Scene scene = scene_with_square();
    Mesh& mesh = scene.meshes.edit(0);
    mesh.morph_targets.resize(1);
    mesh.morph_targets[0].positions.assign(4, glm::vec3(0, 0, 1));
    mesh.morph_weights = {0};
    const NodeId node = add_object(scene);
    scene.nodes[node].weights = std::make_shared<Growing>();
    const auto given = finished(scene);
    SceneState state(given, 1);
    EXPECT_EQ(state.deformed(0).positions[0].z, 1);
    state.override_weights(0, std::vector<float>{5});
    EXPECT_EQ(state.advance(2).deformed, Ids{0});
    EXPECT_EQ(state.deformed(0).positions[0].z, 5);
    EXPECT_TRUE(state.advance(3).deformed.empty()) << "the track does not bear on the shape";
    state.override_weights(0, {});
    EXPECT_EQ(state.advance(4).deformed, Ids{0});
    EXPECT_EQ(state.deformed(0).positions[0].z, 4);
    EXPECT_THROW(state.override_weights(0, std::vector<float>{1, 2}), InternalError);
}

TEST(Overrides, VerticesReplaceKeysWeightsAndJoints)
{
    Scene scene = scene_with_square();
    scene.nodes[add_object(scene)].deforms = true;
    const NodeId rigid = add_object(scene);
    const auto given = finished(scene);
    EXPECT_TRUE(given->objects[0].dynamic && given->objects[0].deforming);
    SceneState state(given, 0);
    EXPECT_EQ(state.deformed(0).positions, square().positions);
    state.override_vertices(0, std::make_shared<DeformedMesh>(raised(2)));
    EXPECT_EQ(state.advance(0).deformed, Ids{0});
    EXPECT_EQ(state.deformed(0).positions[3].z, 2);

    // Equal vertices at another address change nothing.
    state.override_vertices(0, std::make_shared<DeformedMesh>(raised(2)));
    EXPECT_FALSE(state.advance(0).anything());
    EXPECT_EQ(state.changes().touched_nodes, 0u);

    // What is handed over while the object is hidden is there when it appears.
    state.override_visibility(given->objects[0].node, false);
    state.advance(0);
    state.override_vertices(0, std::make_shared<DeformedMesh>(raised(3)));
    EXPECT_FALSE(state.advance(0).anything());
    state.override_visibility(given->objects[0].node, {});
    EXPECT_EQ(state.advance(0).deformed, Ids{0});
    EXPECT_EQ(state.deformed(0).positions[3].z, 3);

    state.override_vertices(0, nullptr);
    EXPECT_EQ(state.advance(0).deformed, Ids{0});
    EXPECT_EQ(state.deformed(0).positions, square().positions);
    EXPECT_THROW(state.override_vertices(given->nodes[rigid].mesh + 1, std::make_shared<DeformedMesh>(raised(1))),
                 InternalError)
        << "a rigid object";
    EXPECT_THROW(state.override_vertices(0, std::make_shared<DeformedMesh>()), InternalError);
}

TEST(Overrides, MissingNormalsAndTangentsAreMade)
{
    const Mesh mesh = square();
    DeformedMesh handed, out;
    handed.positions = {{0, 0, 0}, {0, 0, -1}, {0, 1, -1}, {0, 1, 0}};   // turned about +Y
    complete_vertices(mesh, handed, out);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(glm::length(out.normals[i] - glm::vec3(1, 0, 0)), 0, 1e-6);
        // The mesh's tangent is along the new normal, so nothing of it is left: it stays as it is.
        EXPECT_EQ(out.tangents[i], glm::vec4(1, 0, 0, -1));
    }
    handed.positions = {{0, 0, 0}, {1, 0, -1}, {1, 1, -1}, {0, 1, 0}};
    complete_vertices(mesh, handed, out);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(glm::dot(out.normals[i], glm::vec3(out.tangents[i])), 0, 1e-6);
        EXPECT_NEAR(glm::length(glm::vec3(out.tangents[i])), 1, 1e-6);
        EXPECT_EQ(out.tangents[i].w, -1);
    }
    // A vertex of two triangles gets their mean, weighted by area.
    handed.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 3}};
    complete_vertices(mesh, handed, out);
    const glm::vec3 sum =
        glm::cross(glm::vec3(1, 0, 0), glm::vec3(1, 1, 0)) + glm::cross(glm::vec3(1, 1, 0), glm::vec3(0, 0, 3));
    EXPECT_NEAR(glm::length(out.normals[0] - glm::normalize(sum)), 0, 1e-6);
    EXPECT_EQ(out.normals[1], glm::vec3(0, 0, 1));

    // What the mesh lacks is left out; what is handed over is taken.
    Mesh bare = mesh;
    bare.normals.clear(), bare.tangents.clear();
    handed.normals.assign(4, glm::vec3(0, 1, 0));
    complete_vertices(bare, handed, out);
    EXPECT_TRUE(out.normals.empty() && out.tangents.empty());
    complete_vertices(mesh, handed, out);
    EXPECT_EQ(out.normals, handed.normals);
}

TEST(Overrides, LightsAreRelitOrReachElsewhere)
{
    Scene scene = scene_with_square();
    const NodeId node = add_object(scene);
    scene.lights.push_back({.name = "light", .type = LightType::spot, .node = node});
    scene.lights.push_back({.name = "other", .type = LightType::point, .node = node});
    const auto given = finished(scene);
    SceneState state(given, 0);
    Light values = given->lights[0];
    values.name = "another name";
    values.type = LightType::directional;
    values.node = 77;
    state.set_light(0, values);
    EXPECT_FALSE(state.advance(0).anything()) << "what is kept is no change";

    values.color = glm::vec3(3);
    state.set_light(0, values);
    const FrameChanges& changes = state.advance(0);
    EXPECT_EQ(changes.lights_relit, Ids{0});
    EXPECT_TRUE(changes.lights_moved.empty());
    EXPECT_TRUE(changes.anything() && changes.light_changed(0) && !changes.light_changed(1));
    EXPECT_EQ(state.scene().lights[0].name, "light");
    EXPECT_EQ(state.scene().lights[0].type, LightType::spot);
    EXPECT_EQ(state.scene().lights[0].node, node);

    values.outer_angle = 0.2f;
    state.set_light(0, values);
    Light far = given->lights[1];
    far.range = 4;
    state.set_light(1, far);
    EXPECT_EQ(state.advance(0).lights_moved, (Ids{0, 1}));
    EXPECT_TRUE(changes.lights_relit.empty());
    EXPECT_EQ(changes.lights_started, (Ids{0, 1}));
    EXPECT_EQ(state.advance(0).lights_stopped, (Ids{0, 1}));

    // Set and taken back before a step: nothing.
    Light other = values;
    other.color = glm::vec3(9);
    state.set_light(0, other);
    state.set_light(0, values);
    EXPECT_FALSE(state.advance(0).anything());
    EXPECT_EQ(state.changes().touched_nodes, 0u);
}

TEST(Overrides, MaterialsChangeWhereRaysMeetTheSameSurfaces)
{
    Scene scene = scene_with_square();
    scene.materials.emplace_back();
    scene.materials[1].alpha_mode = AlphaMode::mask;
    add_object(scene);
    const auto given = finished(scene);
    SceneState state(given, 0);
    Material red = given->materials[0];
    red.base_color = {1, 0, 0};
    red.name = "red";
    state.set_material(0, red);
    EXPECT_EQ(state.advance(0).materials_changed, Ids{0});
    EXPECT_TRUE(state.changes().anything());
    EXPECT_EQ(state.scene().materials[0].base_color, red.base_color);
    EXPECT_TRUE(state.scene().materials[0].name.empty());
    state.set_material(0, red);
    EXPECT_FALSE(state.advance(0).anything());
    EXPECT_EQ(state.changes().touched_nodes, 0u);

    Material glass = red;
    glass.transmission = 1;
    EXPECT_THROW(state.set_material(0, glass), InternalError);
    Material double_sided = red;
    double_sided.double_sided = true;
    EXPECT_THROW(state.set_material(0, double_sided), InternalError);
    Material holes = given->materials[1];
    holes.alpha_cutoff = 0.1f;
    EXPECT_FALSE(same_to_rays(holes, given->materials[1]));
    holes = given->materials[1];
    holes.roughness = 0.1f;
    EXPECT_TRUE(same_to_rays(holes, given->materials[1]));
    EXPECT_FALSE(same_values(holes, given->materials[1]));
}

// 10 of `count` objects are moved, hidden and deformed each step: what a step touches.
std::uint64_t touched_with(int count, bool equal)
{
    Scene scene = scene_with_square();
    std::vector<NodeId> nodes;
    for (int i = 0; i < count; ++i) {
        nodes.push_back(add_object(scene));
        scene.nodes.back().animated = true;
        scene.nodes.back().deforms = i < 10;
    }
    for (int i = 0; i < 10; ++i) scene.lights.push_back({.name = "light", .node = nodes[0]});
    const auto given = finished(scene);
    SceneState state(given, 0);
    for (int step = 1; step < 4; ++step) {
        const float value = equal ? 1.0f : static_cast<float>(step);
        for (std::uint32_t i = 0; i < 10; ++i) {
            const glm::dmat4 place = at(static_cast<double>(value));
            state.override_transform(nodes[i + 10], &place);
            state.override_visibility(nodes[i + 20], equal || step % 2 == 0);
            state.override_vertices(i, std::make_shared<DeformedMesh>(raised(value)));
            Light light = given->lights[i];
            light.color = glm::vec3(value);
            state.set_light(i, light);
        }
        state.advance(0);
    }
    return state.changes().touched_nodes;
}

TEST(Overrides, AStepCostsWhatWasSetNotWhatIsThere)
{
    const std::uint64_t few = touched_with(100, false);
    EXPECT_EQ(few, touched_with(100'000, false));
    EXPECT_LE(few, 60u);
    EXPECT_EQ(touched_with(100, true), 0u) << "values that are in force already";
}

// The bounds of light views.

Scene scene_for_bounds()
{
    Scene scene = scene_with_square();
    add_object(scene);
    const NodeId slides = add_object(scene);
    scene.nodes[slides].transform = std::make_shared<Slide>();
    scene.timeline = {.start = 0, .end = 4, .frames = 5, .fps = 1};
    return scene;
}

TEST(PresentBounds, AreTheClipsWhereOnlyTracksMoveThings)
{
    Scene scene = scene_for_bounds();
    const auto given = finished(scene);
    const SceneBounds clip = clip_bounds(*given);
    EXPECT_EQ(clip.whole.high.x, 5);
    SceneState state(given, 0);
    EXPECT_TRUE(state.present_bounds() == clip);
    state.advance(9);   // beyond the clip's last frame, the track takes the object outside
    EXPECT_TRUE(state.present_bounds() == clip);
    const glm::dmat4 same = Slide().evaluate(9);
    state.override_transform(given->objects[1].node, &same);
    state.advance(9);
    EXPECT_TRUE(state.present_bounds() == clip) << "an override with the track's value";
    state.advance(0);
    EXPECT_FALSE(state.present_bounds() == clip) << "the track moved on, and the override holds";
}

TEST(PresentBounds, GrowInStepsAndDependOnThePresentAlone)
{
    Scene scene = scene_for_bounds();
    const auto given = finished(scene);
    const SceneBounds clip = clip_bounds(*given);
    const NodeId node = given->objects[1].node;
    SceneState state(given, 0);
    const auto moved_to = [&](double x, double y) {
        const glm::dmat4 place = at(x, y);
        state.override_transform(node, &place);
        state.advance(0);
        // A state made anew has the same bounds.
        SceneState anew(given, 0);
        anew.override_transform(node, &place);
        anew.advance(0);
        EXPECT_TRUE(state.present_bounds() == anew.present_bounds());
        return state.present_bounds();
    };
    EXPECT_TRUE(state.present_bounds() == clip);
    EXPECT_TRUE(moved_to(3, 0) == clip) << "inside";
    const SceneBounds little = moved_to(4.1, 0);
    EXPECT_EQ(little.whole.high.x, 5 + 5 / 16.0f);
    EXPECT_TRUE(moved_to(4.3, 0) == little) << "within the same step";
    const SceneBounds far = moved_to(24, -9);
    EXPECT_EQ(far.whole.high.x, 5 + 20);
    EXPECT_EQ(far.whole.low.y, -16);
    EXPECT_EQ(far.whole.high.y, clip.whole.high.y);
    EXPECT_TRUE(same_bits(far.dense, clip.dense));
    EXPECT_TRUE(moved_to(4.2, 0) == little) << "and back";

    // What is hidden, or has a singular transform, or farther than rays go, needs no room.
    moved_to(24, 0);
    state.override_visibility(node, false);
    state.advance(0);
    EXPECT_TRUE(state.present_bounds() == clip);
    state.override_visibility(node, {});
    EXPECT_TRUE(moved_to(1e12, 0) == clip);
    state.override_transform(node, nullptr);
    state.advance(0);
    EXPECT_TRUE(state.present_bounds() == clip);
}

TEST(PresentBounds, FollowVerticesThatAreHandedOver)
{
    Scene scene = scene_for_bounds();
    scene.nodes[0].deforms = true;
    const auto given = finished(scene);
    const SceneBounds clip = clip_bounds(*given);
    SceneState state(given, 0);
    EXPECT_TRUE(state.present_bounds() == clip);
    state.override_vertices(0, std::make_shared<DeformedMesh>(raised(7)));
    state.advance(0);
    const float steps = std::exp2(std::ceil(std::log2(7 / clip.whole.diagonal())));
    EXPECT_FLOAT_EQ(state.present_bounds().whole.high.z, steps * clip.whole.diagonal())
        << "of a flat scene, steps of its diagonal";
    state.override_vertices(0, nullptr);
    state.advance(0);
    EXPECT_TRUE(state.present_bounds() == clip);
}

}   // namespace
}   // namespace gnomon::scene
