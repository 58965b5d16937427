// SPDX-License-Identifier: Apache-2.0
// Frames with lights with size: the same bytes cold and warm, remembered or not, for any number of threads; and as many
// rays as what moves needs.

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"
#include "same_frames.h"

namespace gnomon {
namespace {

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<std::uint32_t> k_down{0, 1, 2, 0, 2, 3}, k_up{0, 2, 1, 0, 3, 2};

// A floor with a bench and a still ball under two emitters, one of them two-sided; a ball that moves.
struct Stage {
    SceneBuilder builder;
    InstanceId ball;
    std::optional<Scene> made;
    const Scene& scene() const { return *made; }

    // @param around  of the ball that moves: its quadrilaterals around its axis
    // @param bulb    also a sphere that shines, of 16 clusters
    explicit Stage(std::uint32_t around = 12, bool bulb = false)
    {
        if (bulb)
            builder.area_light({.shape = AreaLightShape::sphere, .width = 0.4f, .radiance = {3, 4, 5}},
                               Transform::translation(0.9, 1.4, -0.6));
        const MaterialId emitter = builder.material({.base_color = {0, 0, 0}, .emissive = {4, 3, 2}});
        const MaterialId both =
            builder.material({.base_color = {0, 0, 0}, .double_sided = true, .emissive = {1, 2, 3}});
        const MaterialId white =
            builder.material({.base_color = {0.7f, 0.7f, 0.7f}, .double_sided = true, .roughness = 1});
        const MeshId down = builder.mesh({.positions = k_square, .indices = k_down}),
                     up = builder.mesh({.positions = k_square, .indices = k_up});
        builder.instance(down, emitter, Transform::translation(0, 2, 0));
        builder.instance(
            down, both,
            Transform::translation(-1.5, 1, 0) * Transform::rotation({0, 0, 1}, 1.5) * Transform::scaling(0.4, 1, 0.6));
        builder.instance(up, white, Transform::scaling(8, 1, 8));
        builder.instance(up, white, Transform::translation(0.3, 0.5, 0.2) * Transform::scaling(0.9, 1, 0.4));
        const MeshId round = ball_mesh();
        builder.instance(round, white, Transform::translation(-0.8, 0.3, 0.3));
        ball = builder.instance(ball_mesh(around), white, at(0), {.mobility = Mobility::may_move});
        Camera camera;
        camera.transform = Transform::look_at({0.5f, 2, 4}, {0, 0.4f, 0});
        camera.vertical_fov = 0.8;
        builder.camera(camera);
        made = builder.finish();
    }
    // A ball of radius .25.
    MeshId ball_mesh(std::uint32_t around = 12)
    {
        constexpr std::uint32_t k_rings = 8;
        constexpr float k_half_turn = 3.14159265f;
        std::vector<Vec3> positions;
        std::vector<std::uint32_t> indices;
        for (std::uint32_t r = 0; r <= k_rings; ++r)
            for (std::uint32_t a = 0; a < around; ++a) {
                const float polar = k_half_turn * static_cast<float>(r) / k_rings,
                            turn = 2 * k_half_turn * static_cast<float>(a) / around;
                positions.push_back({0.25f * std::sin(polar) * std::cos(turn), 0.25f * std::cos(polar),
                                     0.25f * std::sin(polar) * std::sin(turn)});
            }
        for (std::uint32_t r = 0; r < k_rings; ++r)
            for (std::uint32_t a = 0; a < around; ++a) {
                const std::uint32_t p = r * around + a, q = r * around + (a + 1) % around;
                for (const std::uint32_t i : {p, q, q + around, p, q + around, p + around}) indices.push_back(i);
            }
        return builder.mesh({.positions = positions, .indices = indices});
    }
    static Transform at(int step) { return Transform::translation(-1.0 + 0.1 * step, 0.8, 0.1 * step); }
    FrameInput input(int step) const
    {
        FrameInput input;
        input.time = 0.0;
        input.transforms.push_back({ball, at(step)});
        return input;
    }
};

RenderOptions options_with(ShadowCulling culling, int threads = 2)
{
    RenderOptions options;
    options.size = {64, 48};
    options.shadow_culling = culling;
    options.indirect = Indirect::off;
    options.layers = true;
    options.threads = threads;
    options.keep_image = false;   // frames of one view are lit again and again
    return options;
}

TEST(ProvenVisibility, FramesHaveTheSameBytesColdAndWarmRememberedOrNot)
{
    const Stage stage;
    Renderer kept(options_with(ShadowCulling::certified)), forgetful(options_with(ShadowCulling::off)),
        single(options_with(ShadowCulling::certified, 1));
    for (const int step : {0, 1, 2, 2, 5, 1}) {
        const Frame expected =
            Renderer(options_with(ShadowCulling::certified)).render(stage.scene(), stage.input(step));
        test::expect_same(kept.render(stage.scene(), stage.input(step)), expected);
        test::expect_same(forgetful.render(stage.scene(), stage.input(step)), expected);
        test::expect_same(single.render(stage.scene(), stage.input(step)), expected);
        ASSERT_FALSE(HasFailure()) << "step " << step;
    }
}

TEST(ProvenVisibility, ClustersHaveTheSameBytesColdAndWarmRememberedOrNot)
{
    const Stage stage(12, true);
    Renderer kept(options_with(ShadowCulling::certified)), forgetful(options_with(ShadowCulling::off)),
        single(options_with(ShadowCulling::certified, 1));
    for (const int step : {0, 1, 4, 1}) {
        const Frame expected =
            Renderer(options_with(ShadowCulling::certified)).render(stage.scene(), stage.input(step));
        test::expect_same(kept.render(stage.scene(), stage.input(step)), expected);
        test::expect_same(forgetful.render(stage.scene(), stage.input(step)), expected);
        test::expect_same(single.render(stage.scene(), stage.input(step)), expected);
        ASSERT_FALSE(HasFailure()) << "step " << step;
    }
    // Rays contradict no proof.
    RenderOptions checked = options_with(ShadowCulling::certified);
    checked.layers = false;
    checked.overlay = Overlay::shadow_states;
    EXPECT_EQ(Renderer(checked).render(stage.scene(), stage.input(0)).counters.shadow.rays_wrong, 0u);
}

TEST(ProvenVisibility, ASphereOverAFloorNeedsNoRays)
{
    // Its own triangles lie behind those that face the floor. A board in between costs rays where its penumbra may be,
    // and a ball that moves where it may shadow the floor.
    for (const int occluders : {0, 1, 2}) {
        SceneBuilder builder;
        const MaterialId white = builder.material({.base_color = {0.7f, 0.7f, 0.7f}, .double_sided = true});
        const MeshId up = builder.mesh({.positions = k_square, .indices = k_up});
        builder.area_light({.shape = AreaLightShape::sphere, .width = 0.4f, .radiance = {3, 4, 5}},
                           Transform::translation(0, 1.4, 0));
        builder.instance(up, white, Transform::scaling(8, 1, 8));
        if (occluders > 0)
            builder.instance(up, white, Transform::translation(0.3, 0.4, 0) * Transform::scaling(0.4, 1, 0.4),
                             {.mobility = occluders == 1 ? Mobility::fixed : Mobility::may_move});
        Camera camera;
        camera.transform = Transform::look_at({0.5f, 2, 4}, {0, 0, 0});
        camera.vertical_fov = 0.8;
        builder.camera(camera);
        const Scene scene = builder.finish();
        const FrameCounters::Shadow counts =
            Renderer(options_with(ShadowCulling::certified)).render(scene, 1).counters.shadow;
        // Were every point to trace rays to all places that face it, there would be millions.
        EXPECT_EQ(counts.rays > 0, occluders > 0);
        EXPECT_LT(counts.rays, 300'000u) << occluders;
        EXPECT_EQ(counts.rays_dynamic_only > 0, occluders == 2);
    }
}

TEST(ProvenVisibility, OnlyPointsThatAMovingObjectMayShadowPayForIt)
{
    // A few triangles are listed. Rays then go from the object's own points alone.
    Stage stage;
    Renderer renderer(options_with(ShadowCulling::certified));
    renderer.render(stage.scene(), stage.input(0));
    const Frame frame = renderer.render(stage.scene(), stage.input(1));
    EXPECT_EQ(frame.counters.shadow.rays_dynamic_only, 0u);
    EXPECT_GT(frame.counters.shadow.rays, 0u);
    // Hidden, it costs nothing.
    FrameInput hidden = stage.input(1);
    hidden.visibility.push_back({stage.ball, false});
    EXPECT_EQ(renderer.render(stage.scene(), hidden).counters.shadow.rays, 0u);

    // Very many triangles are met by rays, against what moves alone.
    const Stage fine(1200);
    Renderer by_rays(options_with(ShadowCulling::certified));
    by_rays.render(fine.scene(), fine.input(0));
    EXPECT_GT(by_rays.render(fine.scene(), fine.input(1)).counters.shadow.rays_dynamic_only, 0u);
}

TEST(ProvenVisibility, ShadowsOfAMovingObjectAreThoseOfAStillOne)
{
    // The same scene, in which the ball cannot move: its shadow is then remembered.
    Stage moving;
    Stage still;
    still.builder.set_mobility(still.ball, Mobility::fixed);
    still.builder.set_transform(still.ball, Stage::at(3));
    still.made = still.builder.finish();
    const RenderOptions options = options_with(ShadowCulling::certified);
    const Frame a = Renderer(options).render(moving.scene(), moving.input(3)),
                b = Renderer(options).render(still.scene(), 1);
    const auto x = a.layers.front().values(), y = b.layers.front().values();
    ASSERT_EQ(x.size(), y.size());
    double square = 0, sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        square += std::pow(static_cast<double>(x[i] - y[i]), 2);
        sum += static_cast<double>(y[i]);
    }
    const auto count = static_cast<double>(x.size());
    EXPECT_LE(std::sqrt(square / count) / (sum / count), 1e-4);
}

}   // namespace
}   // namespace gnomon
