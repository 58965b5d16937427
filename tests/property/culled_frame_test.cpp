// SPDX-License-Identifier: Apache-2.0
// Certified shadow culling changes no bit: whole videos with and without it, warm and cold, on any number of threads.
#include <gtest/gtest.h>

#include <atomic>
#include <glm/gtc/matrix_transform.hpp>

#include "base/hash.h"
#include "base/random.h"
#include "gnomon/gnomon.h"
#include "ray/ray_scene.h"
#include "scene/builtin/builtin.h"
#include "scene_helpers.h"
#include "shadow_culling/certified/certified_culling.h"
#include "soup.h"
#include "support.h"
#include "trace/shadow_testers.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

std::vector<std::uint64_t> frame_hashes(const Scene& scene, FrameRange frames, Indirect indirect, ShadowCulling culling,
                                        int threads = 1)
{
    RenderOptions options;
    options.size = {160, 120};
    options.threads = threads;
    options.indirect = indirect;
    options.shadow_culling = culling;
    Renderer renderer(options);
    std::vector<std::uint64_t> hashes;
    for (int frame = frames.first; frame <= frames.last; ++frame)
        hashes.push_back(hash_span(renderer.render(scene, frame).layers[0].values()));
    return hashes;
}

// Bounced light casts no shadow rays that are culled, and takes most of the time, so most scenes go without.
void expect_same(const Scene& scene, FrameRange frames, Indirect indirect = Indirect::off)
{
    const auto plain = frame_hashes(scene, frames, indirect, ShadowCulling::off);
    EXPECT_EQ(plain, frame_hashes(scene, frames, indirect, ShadowCulling::certified));
    EXPECT_EQ(plain, frame_hashes(scene, frames, indirect, ShadowCulling::certified, 3));
    // Cold: a renderer that starts in the middle.
    const FrameRange late{frames.first + frames.count() / 2, frames.last};
    const auto cold = frame_hashes(scene, late, indirect, ShadowCulling::certified);
    EXPECT_TRUE(std::equal(cold.begin(), cold.end(), plain.end() - static_cast<std::ptrdiff_t>(cold.size())));
}

TEST(CulledFrame, EqualsTheFullTraceOnBuiltinScenes)
{
    expect_same(load("builtin:cornell"), {1, 12}, Indirect::visible);
    expect_same(load("builtin:kinetic"), {40, 46});
    expect_same(load("builtin:spheres?objects=60&dynamic=20&vertices=200"), {1, 8});
}

TEST(CulledFrame, EqualsTheFullTraceOnKitchenWithTheCarMoving)
{
    GNOMON_NEED_SCENE(file, "bart/kitchen/aff/kitchen.aff");
    expect_same(load(file.string()), {196, 204});
}

TEST(CulledFrame, EqualsTheFullTraceOnRobots)
{
    GNOMON_NEED_SCENE(file, "bart/robots/aff/Robot.aff");
    expect_same(load(file.string()), {200, 206});
}

TEST(CulledFrame, SkipsRaysFromTheSecondFrameOn)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer({.size = {160, 120}, .threads = 1});
    EXPECT_EQ(renderer.render(scene, 1).counters.shadow.rays_skipped, 0u);
    renderer.render(scene, 2);
    const FrameCounters::Shadow shadow = renderer.render(scene, 3).counters.shadow;
    EXPECT_GT(shadow.rays_skipped, shadow.rays / 2);
    EXPECT_GT(shadow.rays_dynamic_only, 0u);
}

// Frames that do not wait for certificates, as in the viewer: judging stops anywhere and goes on later.
TEST(CulledFrame, SameForAnyNumberOfCertificatesPerFrame)
{
    const auto scene =
        std::make_shared<const scene::Scene>(scene::make_builtin("spheres?objects=60&dynamic=20&vertices=500"));
    Tasks tasks(2);
    for (const int every : {0, 1, 3}) {   // chunks a frame
        scene::SceneState state(scene, 0);
        ray::RayScene rays(state);
        shadow_culling::CertifiedCulling culling(state, rays, {});
        shading::FrameBuffers buffers, plain;
        std::uint64_t skipped = 0;
        int stopped = 0;
        const auto frame_at = [&](int frame) {
            state.advance(scene->timeline.time_of(frame));
            rays.update(state);
            const scene::View view = scene::make_view(state, 0, {160, 120});
            trace::CertifiedShadows shadows(culling, true);
            skipped = trace::trace_frame(state, rays, view, {}, tasks, buffers, {&shadows}).shadow.rays_skipped;
            trace::trace_frame(state, rays, view, {}, tasks, plain);
            EXPECT_EQ(buffers.color.data, plain.color.data) << frame << ", " << every << " chunks";
        };
        for (int frame = 1; frame <= 8; ++frame) {
            frame_at(frame);
            std::atomic<int> asked = 0;
            stopped += !culling.judge(tasks, [&] { return asked++ < every; });
        }
        EXPECT_GT(stopped, 0) << "there was more to judge";
        if (every == 0) {
            EXPECT_EQ(skipped, 0u) << "nothing was judged";
        }
        for (int frame = 9; frame <= 11; ++frame) {
            frame_at(frame);
            EXPECT_TRUE(culling.judge(tasks, [] { return true; }));
        }
        EXPECT_GT(skipped, 500u) << every << ": what was left is judged in the end";
    }
}

// --- Random triangle soups: lights anywhere, on and inside geometry too; points everywhere; what is remembered is
// asked again and again, and must be what rays say.

// Asks `rounds` batches of random surface points and returns how many answers differ from single rays.
std::uint64_t wrong_answers(std::uint64_t seed, int rounds, std::uint64_t& skipped, std::size_t dynamic_objects = 0)
{
    using namespace shadow_culling;
    const auto scene = Soup(seed, static_cast<int>(dynamic_objects)).take();
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    CertifiedOptions options;
    // Of these few points blocks are hardly worth drawing: mostly, they are drawn all the same.
    if (dynamic_objects > 0) options.mask.asked = 1;
    if (dynamic_objects > 0 && seed % 3 != 0) options.mask.edges_per_ray = k_infinity;
    CertifiedCulling culling(state, rays, options);
    Tasks one(1);
    Random random(seed, 77);
    std::uint64_t wrong = 0;
    for (int round = 0; round < rounds; ++round) {
        if (dynamic_objects > 0 && round % 3 != 2) move_last(*scene, state, random, dynamic_objects);
        state.advance(0);
        rays.update(state);
        culling.begin_frame(state, rays, {glm::vec3(0, 0, 4), 0.004f, 0});
        const std::vector<ShadowPoint> points = random_points(*scene, rays, random, 400);
        std::vector<std::unique_ptr<CertifiedCulling::Batch>> batches;
        batches.push_back(culling.make_batch());
        culling.classify(*batches[0], points);
        std::vector<std::uint8_t> occluded(points.size() + 8);
        for (std::size_t l = 0; l < scene->lights.size(); ++l) {
            culling.shadow(*batches[0], static_cast<int>(l), occluded.data());
            const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
            const bool directional = scene->lights[l].type == scene::LightType::directional;
            for (std::size_t i = 0; i < points.size(); ++i) {
                const glm::vec3 d = directional ? -at.direction : at.position - points[i].origin;
                const bool faces = glm::dot(d, points[i].normal) > 0;
                const bool truth =
                    !faces || rays.occluded_single(points[i].origin, 0, d, directional ? k_infinity : 0.9999f);
                wrong += truth != static_cast<bool>(occluded[i]);
            }
        }
        culling.end_frame(batches, one);
        skipped += culling.counters().skipped;
    }
    return wrong;
}

// A static object that a user override moves no longer casts its remembered shadow, but one from where it is.
// Cornell, with surfaces that are seen from behind if turned.
std::shared_ptr<const scene::Scene> cornell(bool turned)
{
    scene::Scene scene = scene::make_cornell();
    if (turned) {
        for (scene::MeshId m = 0; m < scene.meshes.size(); ++m)
            for (glm::uvec3& triangle : scene.meshes.edit(m).triangles) std::swap(triangle.y, triangle.z);
        for (scene::Material& material : scene.materials) material.double_sided = true;
        scene.finish();
    }
    return std::make_shared<const scene::Scene>(std::move(scene));
}

class CertifiedCullingOfSides : public testing::TestWithParam<bool> {};

TEST_P(CertifiedCullingOfSides, FollowsUserOverridesOfStaticObjects)
{
    const auto scene = cornell(GetParam());
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    shadow_culling::CertifiedCulling culling(state, rays, {});
    Tasks one(1);
    trace::TracedOptions options;
    const scene::View view = scene::make_view(state, 0, {120, 120});
    const auto compare = [&](int frame) {
        shading::FrameBuffers culled, plain;
        trace::CertifiedShadows shadows(culling);
        trace::trace_frame(state, rays, view, options, one, culled, {&shadows});
        trace::trace_frame(state, rays, view, options, one, plain);
        EXPECT_EQ(culled.color.data, plain.color.data) << "frame " << frame;
    };
    scene::NodeId block = scene::none;   // the second static object above the floor: any will do
    for (const scene::Object& object : scene->objects)
        if (!object.dynamic) block = object.node;
    ASSERT_NE(block, scene::none);
    for (int frame = 0; frame < 12; ++frame) {
        if (frame >= 4 && frame % 2 == 0) {
            glm::dmat4 moved = scene->nodes[block].local;
            moved[3] += glm::dvec4(-0.08 * frame, 0.1, 0.05 * frame, 0);
            state.override_transform(block, &moved);
        }
        state.advance(scene->timeline.time_of(1 + frame));
        rays.update(state);
        compare(frame);
    }
}
INSTANTIATE_TEST_SUITE_P(Each, CertifiedCullingOfSides, testing::Bool());

// Blocks are drawn for whoever asks, however little that saves: so that all that can be wrong with them is.
shadow_culling::CertifiedOptions every_block()
{
    shadow_culling::CertifiedOptions certified;
    certified.mask.asked = 1;
    certified.mask.edges_per_ray = k_infinity;
    return certified;
}

scene::View small_view(Size size, float away, float pixel)
{
    scene::View view;
    view.size = size;
    view.eye = glm::vec3(0, 0, away), view.forward = glm::vec3(0, 0, -1);
    view.right = glm::vec3(0.5f * pixel * static_cast<float>(size.width), 0, 0);
    view.up = glm::vec3(0, 0.5f * pixel * static_cast<float>(size.height), 0);
    view.pixel_spread = pixel;
    return view;
}

// Objects hidden by a scale of 0, and objects that a parent's scale flattens at an angle: rays hit them roughly or not
// at all. The mask must give the results that rays give.
TEST(CertifiedCulling, IsExactForDynamicObjectsWithSingularTransforms)
{
    std::uint64_t skipped = 0;
    for (const double thin : {0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.1}) {
        const auto scene = Soup(7, 6).take();
        scene::SceneState state(scene, 0);
        ray::RayScene rays(state);
        shadow_culling::CertifiedCulling culling(state, rays, every_block());
        Tasks one(1);
        const scene::View view = small_view({64, 64}, 4, 0.025f);
        for (int frame = 0; frame < 4; ++frame) {
            for (std::size_t i = 1; i <= 6; ++i) {
                const double turn = 0.3 + 0.2 * frame + static_cast<double>(i);
                const glm::dmat4 flat_transform =
                    glm::scale(glm::dmat4(1), glm::dvec3(1, i % 2 ? thin : 1, i % 2 ? 1 : thin));
                const glm::dmat4 turned = glm::rotate(glm::dmat4(1), turn, glm::normalize(glm::dvec3(1, 2, 3)));
                const glm::dmat4 local = i % 3 ? flat_transform * turned : turned * flat_transform;
                state.override_transform(scene->objects[scene->objects.size() - i].node, &local);
            }
            state.advance(0);
            rays.update(state);
            shading::FrameBuffers culled, plain;
            trace::CertifiedShadows shadows(culling);
            skipped += trace::trace_frame(state, rays, view, {}, one, culled, {&shadows}).shadow.rays_skipped;
            trace::trace_frame(state, rays, view, {}, one, plain);
            EXPECT_EQ(culled.color.data, plain.color.data) << "frame " << frame << ", as thin as " << thin;
        }
    }
    EXPECT_GT(skipped, 1000u);
}

// A user override that takes an object out of a moving group: the object casts its shadow from where it is.
TEST(CertifiedCulling, FollowsUserOverridesWithinAMovingGroup)
{
    scene::Scene made = test::scene_with_balls();
    test::add_object(made, 0, scene::none, glm::scale(test::translation(0, -2, 0), glm::dvec3(4, 0.2, 4)));   // a floor
    const scene::NodeId anchor = made.add_node("anchor", scene::none, test::translation(60, 0, 0));
    made.nodes[anchor].animated = true;
    const scene::NodeId arm =
        made.add_node("arm", anchor, glm::scale(test::translation(-60, 0, 0), glm::dvec3(0.8, 0.5, 0.9)));
    const scene::NodeId passenger = test::add_object(made, 0, arm);
    test::add_object(made, 0, anchor, glm::scale(glm::dmat4(1), glm::dvec3(0.1)));
    scene::Light light;
    light.color = glm::vec3(100);
    light.node = made.add_node("light", scene::none, test::translation(0.5, 5, 0.3));
    made.lights.push_back(light);
    const auto scene = test::finished(made);
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    shadow_culling::CertifiedCulling culling(state, rays, every_block());
    Tasks one(1);
    const scene::View view = small_view({64, 48}, 9, 0.02f);
    for (int frame = 0; frame < 6; ++frame) {
        const glm::dmat4 place = test::translation(0.2 * frame, 0, 1);
        if (frame > 1) state.override_transform(passenger, &place);
        state.advance(0);
        rays.update(state);
        shading::FrameBuffers culled, plain;
        trace::CertifiedShadows shadows(culling);
        trace::trace_frame(state, rays, view, {}, one, culled, {&shadows});
        trace::trace_frame(state, rays, view, {}, one, plain);
        EXPECT_EQ(culled.color.data, plain.color.data) << "frame " << frame;
    }
}

TEST(CertifiedCulling, IsExactOnRandomSoups)
{
    std::uint64_t wrong = 0, skipped = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) wrong += wrong_answers(seed, 12, skipped);
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(skipped, 100'000u);   // else nothing was put to the test
}

// Dynamic objects come and go, and stand still every third round.
TEST(CertifiedCulling, IsExactOnRandomSoupsWithDynamicObjects)
{
    std::uint64_t wrong = 0, skipped = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) wrong += wrong_answers(seed, 12, skipped, 3 + seed % 4);
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(skipped, 25'000u);
}

TEST(CertifiedCullingFull, IsExactOnAThousandRandomSoupsWithDynamicObjects)
{
    std::uint64_t wrong = 0, skipped = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) wrong += wrong_answers(seed, 12, skipped, 3 + seed % 4);
    EXPECT_EQ(wrong, 0u);
}

TEST(CertifiedCullingFull, IsExactOnAThousandRandomSoups)
{
    std::uint64_t wrong = 0, skipped = 0;
    for (std::uint64_t seed = 1; seed <= 1000; ++seed) wrong += wrong_answers(seed, 12, skipped);
    EXPECT_EQ(wrong, 0u);
}

}   // namespace
}   // namespace gnomon
