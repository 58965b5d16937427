// SPDX-License-Identifier: Apache-2.0
// Errors of the published shadow culling against a full trace, and cases without errors [Nah 2009, Fig. 5].
#include <gtest/gtest.h>

#include "bench/culling/bench.h"
#include "scene/builtin/builtin.h"
#include "scene_helpers.h"

namespace gnomon {
namespace {

constexpr int k_pixels = 32;

void add_triangle(scene::Scene& scene, const glm::vec3 (&p)[3])
{
    scene::Mesh mesh;
    mesh.positions = {p[0], p[1], p[2]};
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    scene.meshes.push_back(mesh);
    test::add_object(scene, static_cast<scene::MeshId>(scene.meshes.size() - 1));
}

/// A floor of one triangle, completely visible from above and lit from the side. Between light and floor, outside the
/// view, a triangle casts this shadow onto it.
scene::Scene floor_under_light(const glm::vec3 (&shadow)[3])
{
    const glm::vec3 light(9, 0, 9);
    scene::Scene scene;
    scene.materials.emplace_back();
    scene.materials[0].double_sided = true;
    add_triangle(scene, {{-1.9f, -1.8f, 0}, {1.9f, -1.7f, 0}, {0.1f, 1.9f, 0}});
    glm::vec3 occluder[3];
    for (int i = 0; i < 3; ++i) occluder[i] = shadow[i] + 0.6f * (light - shadow[i]);
    add_triangle(scene, occluder);
    scene.lights.emplace_back();
    scene.lights[0].node = scene.add_node("light", scene::none, test::translation(light.x, light.y, light.z));
    scene.cameras.emplace_back();
    return scene;
}

/// The camera looks down from one place in the first frame, and from another from the second frame on.
std::shared_ptr<const scene::Scene> seen_from(scene::Scene& scene, const glm::dvec3& first, const glm::dvec3& then)
{
    const scene::NodeId node = scene.add_node("camera", scene::none);
    scene.nodes[node].transform = std::make_shared<test::JumpTrack>(0.5, glm::translate(glm::dmat4(1), first),
                                                                    glm::translate(glm::dmat4(1), then));
    scene.cameras[0].node = node;
    scene.timeline.start = 0, scene.timeline.end = 4, scene.timeline.frames = 5, scene.timeline.fps = 1;
    return test::finished(scene);
}

bench::CullingBenchResult bench(const std::shared_ptr<const scene::Scene>& scene, int threads = 1, int last_frame = 4,
                                const shadow_culling::PaperOptions& paper_options = {})
{
    bench::CullingBenchOptions options;
    options.paper_options = paper_options;
    options.frames = {1, last_frame};
    options.size = {k_pixels, k_pixels};
    options.threads = threads;
    options.certified = false;
    return bench::bench_culling(scene, options);
}

shadow_culling::PaperOptions by_clip()
{
    shadow_culling::PaperOptions options;
    options.mobility = shadow_culling::PaperMobility::by_clip;
    return options;
}

TEST(PaperWrongPixels, MissesAShadowBetweenPixels)
{
    // A pixel is 0.25 wide. The shadow, 0.1 wide, lies between four pixel centres in the first frame; then the camera
    // moves by half a pixel, and one centre lies in it.
    scene::Scene scene = floor_under_light({{-0.05f, -0.05f, 0}, {0.06f, -0.05f, 0}, {0, 0.07f, 0}});
    scene.cameras[0].orthographic_height = 8;
    const auto result = bench(seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12}));
    EXPECT_EQ(result.frames[0].paper.wrong, 0u);
    EXPECT_EQ(result.frames[0].paper.skipped, 0u) << "nothing is known yet";
    for (std::size_t f = 1; f < 4; ++f) {
        EXPECT_EQ(result.frames[f].paper.wrong, 1u) << "frame " << f + 1;
        EXPECT_EQ(result.frames[f].paper.skipped, result.frames[f].paper.rays) << "nothing is dynamic";
    }
    EXPECT_EQ(result.paper_wrong_mean, 0.75);
}

TEST(PaperWrongPixels, VisibleShadowIsPartialAndAlwaysTraced)
{
    scene::Scene scene = floor_under_light({{-0.5f, -0.5f, 0}, {0.6f, -0.5f, 0}, {0, 0.7f, 0}});
    scene.cameras[0].orthographic_height = 8;
    const auto result = bench(seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12}));
    for (const bench::CullingFrame& frame : result.frames) {
        EXPECT_EQ(frame.paper.wrong, 0u);
        EXPECT_EQ(frame.paper.skipped + frame.paper.dynamic_only, 0u);
        EXPECT_GT(frame.paper.rays, 50u);
        EXPECT_EQ(frame.paper.rays, frame.off.rays);
    }
}

TEST(PaperWrongPixels, NoErrorWithoutAShadow)
{
    scene::Scene scene = floor_under_light({{40, 0, 0}, {41, 0, 0}, {40, 1, 0}});
    scene.cameras[0].orthographic_height = 8;
    const auto result = bench(seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12}));
    EXPECT_EQ(result.paper_wrong_mean, 0);
    EXPECT_EQ(result.frames[3].paper.skipped, result.frames[3].paper.rays);
}

TEST(PaperWrongPixels, SkipsAFloorFullyInShadow)
{
    scene::Scene scene = floor_under_light({{-3.2f, -20, 0}, {20, 0, 0}, {-3.2f, 20, 0}});
    scene.cameras[0].orthographic_height = 8;
    const auto result = bench(seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12}));
    EXPECT_EQ(result.paper_wrong_mean, 0);
    EXPECT_EQ(result.frames[0].paper.skipped, 0u);
    EXPECT_EQ(result.frames[3].paper.skipped, result.frames[3].paper.rays);
}

TEST(PaperWrongPixels, ZoomInShowsASmallShadowOneFrameLate)
{
    // From distance 12 to 5 the floor covers 5.8 times the pixels. The frame of the zoom still uses the old mode.
    scene::Scene scene = floor_under_light({{0.02f, 0.02f, 0}, {0.11f, 0.02f, 0}, {0.06f, 0.12f, 0}});
    const auto result = bench(seen_from(scene, {0, 0, 12}, {0, 0, 5}));
    EXPECT_EQ(result.frames[0].paper.wrong, 0u);
    EXPECT_GT(result.frames[1].paper.wrong, 0u);
    EXPECT_EQ(result.frames[2].paper.wrong, 0u);
    EXPECT_EQ(result.frames[2].paper.skipped, 0u);
    EXPECT_EQ(result.frames[3].paper.wrong, 0u);
    EXPECT_EQ(result.frames[3].paper.skipped, 0u) << "PARTIAL_SHADOW now";
}

TEST(PaperWrongPixels, MovingLightIsNeitherCulledNorWrong)
{
    scene::Scene scene = floor_under_light({{-0.05f, -0.05f, 0}, {0.06f, -0.05f, 0}, {0, 0.07f, 0}});
    scene.cameras[0].orthographic_height = 8;
    scene.nodes[scene.lights[0].node].transform = std::make_shared<test::SwayTrack>(glm::dvec3(9, 0, 9), 3);
    const auto result = bench(seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12}));
    for (const bench::CullingFrame& frame : result.frames) {
        EXPECT_EQ(frame.paper.skipped + frame.paper.dynamic_only, 0u);
        EXPECT_EQ(frame.paper.wrong, 0u);
    }
}

TEST(PaperWrongPixels, StoresAMovingShadowOnlyAsPrinted)
{
    // A moving screen shades the whole floor in the first two frames, then jumps out of the way.
    const auto with_screen = [] {
        scene::Scene scene = floor_under_light({{-3.2f, -20, 0}, {20, 0, 0}, {-3.2f, 20, 0}});
        scene.nodes[1].transform = std::make_shared<test::JumpTrack>(1.5, glm::dmat4(1), test::translation(500, 0, 0));
        scene.cameras[0].orthographic_height = 8;
        return seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12});
    };
    const auto ours = bench(with_screen());
    EXPECT_EQ(ours.paper_wrong_mean, 0);
    EXPECT_EQ(ours.frames[1].paper.skipped, ours.frames[1].paper.rays) << "the screen rests: its shadow is static";
    EXPECT_EQ(ours.frames[2].paper.skipped, 0u) << "it moved: what it may have shadowed is forgotten";
    const auto clip_wide = bench(with_screen(), 1, 4, by_clip());
    EXPECT_EQ(clip_wide.paper_wrong_mean, 0);
    EXPECT_EQ(clip_wide.frames[1].paper.dynamic_only, clip_wide.frames[1].paper.rays);
    const auto printed = bench(with_screen(), 1, 4, shadow_culling::PaperOptions::as_printed());
    EXPECT_EQ(printed.frames[1].paper.skipped, printed.frames[1].paper.rays);
    EXPECT_EQ(printed.frames[1].paper.wrong, 0u);
    EXPECT_EQ(printed.frames[2].paper.wrong, printed.frames[2].paper.rays);
    EXPECT_GT(printed.frames[2].paper.rays, 100u);
}

TEST(PaperWrongPixels, RestingObjectsAreStaticWhileOthersMove)
{
    // The screen jumps into the light's way in frame 3 and rests from then on. A small object keeps moving above the
    // other end of the floor, so that rays must tell the two apart.
    scene::Scene scene = floor_under_light({{-3.2f, -20, 0}, {20, 0, 0}, {-3.2f, 20, 0}});
    scene.nodes[1].transform = std::make_shared<test::JumpTrack>(1.5, test::translation(500, 0, 0), glm::dmat4(1));
    add_triangle(scene, {{0, -0.4f, 1}, {0.4f, 0.4f, 1}, {-0.4f, 0.4f, 1}});
    const auto restless = static_cast<scene::NodeId>(scene.nodes.size() - 1);
    scene.nodes[restless].transform = std::make_shared<test::SwayTrack>(glm::dvec3(0), 3);
    scene.cameras[0].orthographic_height = 8;
    const auto clip = [&] {
        auto made = seen_from(scene, {0, 0, 12}, {0.125, 0.125, 12});
        auto longer = std::make_shared<scene::Scene>(*made);
        longer->timeline.end = 20, longer->timeline.frames = 21;
        return std::shared_ptr<const scene::Scene>(longer);
    }();
    const auto floor_rays = [](const bench::CullingFrame& f) { return f.paper.rays; };
    const auto by_frame = bench(clip, 1, 16);
    const auto clip_wide = bench(clip, 1, 16, by_clip());
    for (std::size_t f = 0; f < 16; ++f) {
        EXPECT_EQ(by_frame.frames[f].paper.wrong, 0u) << "frame " << f + 1;
        EXPECT_EQ(clip_wide.frames[f].paper.wrong, 0u) << "frame " << f + 1;
        EXPECT_EQ(clip_wide.frames[f].paper.skipped, 0u) << "the screen may move";
    }
    EXPECT_EQ(by_frame.frames[8].paper.skipped, 0u) << "the screen has not rested long enough";
    EXPECT_GT(by_frame.frames[15].paper.skipped, floor_rays(by_frame.frames[15]) / 2);
}

TEST(PaperWrongPixels, SameForAnyThreadCount)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_cornell());
    const auto one = bench(scene, 1, 8), three = bench(scene, 3, 8);
    std::uint64_t culled = 0;
    for (std::size_t f = 0; f < one.frames.size(); ++f) {
        const auto &a = one.frames[f].paper, &b = three.frames[f].paper;
        EXPECT_EQ(a.rays, b.rays);
        EXPECT_EQ(a.skipped, b.skipped);
        EXPECT_EQ(a.dynamic_only, b.dynamic_only);
        EXPECT_EQ(a.wrong, b.wrong);
        EXPECT_EQ(a.extra_tests_per_pixel, b.extra_tests_per_pixel);
        culled += a.skipped + a.dynamic_only;
    }
    EXPECT_GT(culled, 0u);
}

}   // namespace
}   // namespace gnomon
