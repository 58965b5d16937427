// SPDX-License-Identifier: Apache-2.0
// Shadow culling as published [Nah 2009]: its tables line by line, its modes, and how a frame updates them.
// LONG: one fixture for the whole scheme, by the letter and not.
#include "shadow_culling/nah2009/paper_culling.h"

#include <gtest/gtest.h>

#include "base/tasks.h"
#include "scene_helpers.h"

namespace gnomon::shadow_culling {
namespace {

using Notes = PaperCulling::Notes;

constexpr OcclusionMode k_init = OcclusionMode::init, k_partial = OcclusionMode::partially_occluded,
                        k_whole = OcclusionMode::fully_rendered, k_dynamic = OcclusionMode::dynamic;

scene::Mesh triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    scene::Mesh mesh;
    mesh.positions = {a, b, c};
    mesh.triangles = {{0, 1, 2}};
    mesh.parts = {{0, 0, 1}};
    return mesh;
}

// Five objects of one triangle each, so that primitive and object have the same number, and two lights.
enum : PrimitiveId { wide, small, beside, dynamic_object, other, primitive_count };

std::shared_ptr<const scene::Scene> five_triangles()
{
    scene::Scene scene;
    scene.materials.emplace_back();
    for (scene::Mesh& mesh : std::vector<scene::Mesh>{
             triangle({-40, -40, 0}, {40, -40, 0}, {0, 60, 0}),    // behind the next one
             triangle({1, 1, 1}, {3, 1, 1}, {1, 3, 1}),            // between it and the lights
             triangle({900, 0, 0}, {902, 0, 0}, {900, 2, 0}),      // far away
             triangle({-5, -5, 2}, {-3, -5, 2}, {-5, -3, 2}),      // moves
             triangle({-900, 0, 0}, {-902, 0, 0}, {-900, 2, 0}),   // far away, on the other side
         })
        scene.meshes.push_back(std::move(mesh));
    for (scene::MeshId m = 0; m < primitive_count; ++m)
        scene.nodes[test::add_object(scene, m)].animated = m == dynamic_object;
    for (int l = 0; l < 2; ++l) {
        scene.lights.emplace_back();
        scene.lights.back().node = scene.add_node("light", scene::none, test::translation(0.5 + l, 0.5, 50));
    }
    return test::finished(scene);
}

PaperOptions by_clip(int part_levels = 0)
{
    PaperOptions options;
    options.mobility = PaperMobility::by_clip;
    options.part_levels = part_levels;
    return options;
}

PrimaryHit pixel(PrimitiveId primitive, float x = 50, float y = 50)
{
    return {primitive, {x, y, 10}, {0, 0, -1}};
}

class PaperCullingTest : public testing::Test {
 protected:
    std::shared_ptr<const scene::Scene> scene_ = five_triangles();
    scene::SceneState state_{scene_, 0};
    ray::RayScene rays_{state_};
    SceneTriangles triangles_{state_, rays_};
    Modes modes_{primitive_count, 2};
    PaperCulling culling_{state_, rays_, by_clip()};
    std::vector<Notes> notes_ = std::vector<Notes>(1);

    // Tests a pixel away from all edges of the screen. Returns the extra tests.
    std::uint64_t test_pixel(const PrimaryHit& current, PrimitiveId left, PrimitiveId upper)
    {
        const PrimaryHit sky;
        const std::vector<PrimaryHit> above = {sky, sky, pixel(upper), sky}, row = {sky, pixel(left), current, sky};
        return test_occlusion(row, above, false, triangles_, modes_).extra_tests;
    }
    void expect_modes(std::initializer_list<OcclusionMode> marked) const
    {
        PrimitiveId p = 0;
        for (const OcclusionMode mode : marked) {
            EXPECT_EQ(modes_.marked(p), mode) << "primitive " << p;
            ++p;
        }
    }
    // Renders a frame that shows some primitives in the given number of pixels each, far from edges and from one
    // another.
    void frame(std::initializer_list<std::pair<PrimitiveId, std::size_t>> shown, const PaperChanges& changes = {})
    {
        culling_.begin_frame(state_, rays_, changes);
        see(shown);
        culling_.end_frame(notes_);
    }
    void see(std::initializer_list<std::pair<PrimitiveId, std::size_t>> shown)
    {
        constexpr std::size_t width = 200;
        std::vector<PrimaryHit> image(3 * width);
        std::size_t x = 2;
        for (const auto& [primitive, pixels] : shown) {
            for (std::size_t i = 0; i < pixels; ++i) image[width + x++] = pixel(primitive);
            x += 2;
        }
        culling_.see_image(image, width);
    }
    ShadowDecision decide(PrimitiveId primitive, int light = 0) { return culling_.decide(primitive, light, notes_[0]); }
    void note(PrimitiveId primitive, StaticPart part, int light = 0, bool dynamic = false)
    {
        culling_.note(primitive, light, part, dynamic, notes_[0]);
    }
};

// Table 1.

TEST_F(PaperCullingTest, MarksMovingPrimitivesDynamicEvenAtTheEdge)
{
    const std::vector<PrimaryHit> row = {pixel(dynamic_object), pixel(dynamic_object), pixel(dynamic_object)};
    EXPECT_EQ(test_occlusion(row, {}, true, triangles_, modes_).extra_tests, 0u);
    expect_modes({k_init, k_init, k_init, k_dynamic, k_init});
}

TEST_F(PaperCullingTest, ScreenBorderMarksPartlyOccludedOnAllFourSides)
{
    const PrimaryHit sky;
    const std::vector<PrimaryHit> none(3, sky), left = {pixel(small), sky, sky}, right = {sky, sky, pixel(small)},
                                                middle = {sky, pixel(small), sky};
    const auto marks = [&](const std::vector<PrimaryHit>& row, std::span<const PrimaryHit> above, bool last) {
        Modes modes(primitive_count, 1);
        modes.set_occlusion(small, k_whole);   // even if it was seen whole before
        EXPECT_EQ(test_occlusion(row, above, last, triangles_, modes).extra_tests, 0u);
        return modes.marked(small) == k_partial;
    };
    EXPECT_TRUE(marks(left, none, false));
    EXPECT_TRUE(marks(right, none, false));
    EXPECT_TRUE(marks(middle, {}, false));
    EXPECT_TRUE(marks(middle, none, true));
    EXPECT_FALSE(marks(middle, none, false));
}

TEST_F(PaperCullingTest, MarksANeighbourThatContinuesBehindPartlyOccluded)
{
    // The ray at (1.5, 1.5) hits `small` first, and would also hit `wide`.
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), wide, no_primitive), 1u);
    expect_modes({k_partial, k_init, k_init, k_init, k_init});
}

TEST_F(PaperCullingTest, TestsTheUpperNeighbourLikeTheLeft)
{
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), no_primitive, wide), 1u);
    expect_modes({k_partial, k_init, k_init, k_init, k_init});
}

TEST_F(PaperCullingTest, DoesNotMarkANeighbourThatEndsBeforeThisPixel)
{
    EXPECT_EQ(test_pixel(pixel(wide, 10, 10), small, no_primitive), 1u);
    expect_modes({k_init, k_init, k_init, k_init, k_init});
}

TEST_F(PaperCullingTest, TestsOnceIfBothNeighboursAreEqual)
{
    // The test fails, so that the mark of the first does not prevent the second.
    EXPECT_EQ(test_pixel(pixel(wide, 10, 10), small, small), 1u);
    EXPECT_EQ(test_pixel(pixel(wide, 10, 10), small, beside), 2u);
}

TEST_F(PaperCullingTest, DoesNotTestBackgroundItselfOrMarkedPrimitives)
{
    EXPECT_EQ(test_pixel({}, wide, small), 0u);
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), no_primitive, no_primitive), 0u);
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), small, small), 0u);
    expect_modes({k_init, k_init, k_init, k_init, k_init});
    modes_.set_occlusion(wide, k_whole);
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), wide, no_primitive), 0u);
    expect_modes({k_init, k_init, k_init, k_init, k_init});
}

TEST_F(PaperCullingTest, DoesNotTestMarkedPrimitivesAgain)
{
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), wide, no_primitive), 1u);
    EXPECT_EQ(test_pixel(pixel(small, 1.5f, 1.5f), wide, no_primitive), 0u);
}

TEST_F(PaperCullingTest, TestsMarkedPrimitivesAgainOnRequest)
{
    const PrimaryHit sky, front = pixel(small, 1.5f, 1.5f);
    const std::vector<PrimaryHit> above(4, sky), row = {sky, pixel(wide), front, sky};
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(test_occlusion(row, above, false, triangles_, modes_, {.test_marked = true}).extra_tests, 1u);
    expect_modes({k_partial, k_init, k_init, k_init, k_init});
}

TEST_F(PaperCullingTest, MissesAnOccluderOverTheLeftPart)
{
    // A limitation of the paper: `small` is left of `wide`, the ray beside it does not hit `small`, and no test checks
    // whether `wide` continues to the left.
    EXPECT_EQ(test_pixel(pixel(wide, 3.5f, 1.5f), small, small), 1u);
    expect_modes({k_init, k_init, k_init, k_init, k_init});
}

TEST(PaperIntersects, HandlesInsideOutsideBorderAndBehind)
{
    const glm::vec3 corners[3] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
    const auto meets = [&](float x, float y, float z, float dz) { return intersects({x, y, z}, {0, 0, dz}, corners); };
    EXPECT_TRUE(meets(0.5f, 0.5f, 1, -1));
    EXPECT_TRUE(meets(0.5f, 0.5f, -1, 3));
    EXPECT_TRUE(meets(1, 1, 1, -1));
    EXPECT_FALSE(meets(1.1f, 1.1f, 1, -1));
    EXPECT_FALSE(meets(-0.1f, 0.5f, 1, -1));
    EXPECT_FALSE(meets(0.5f, 0.5f, 1, 1));
    EXPECT_FALSE(intersects({-1, 0.5f, 0}, {1, 0, 0}, corners)) << "in its plane";
}

// Table 2.

TEST(PaperShadowTest, DecidesAsTable2)
{
    using enum ShadowDecision;
    const auto decision = [](OcclusionMode occlusion, ShadowMode shadow) {
        Modes modes(1, 1);
        std::vector<PrimitiveId> touched;
        modes.set_occlusion(0, occlusion);
        modes.note_shadow(0, 0, shadow, touched);
        modes.merge_shadow(0);
        EXPECT_EQ(modes.occlusion(0), occlusion);
        EXPECT_EQ(modes.shadow(0, 0), shadow);
        return test_shadow(modes, 0, 0);
    };
    EXPECT_EQ(decision(k_whole, ShadowMode::full_shadow), in_shadow);   // the listing's `false` is an error
    EXPECT_EQ(decision(k_whole, ShadowMode::non_shadow), dynamic_only);
    EXPECT_EQ(decision(k_whole, ShadowMode::partial_shadow), full_traversal);
    EXPECT_EQ(decision(k_whole, ShadowMode::init), full_traversal);
    for (const OcclusionMode occlusion : {k_init, k_partial, k_dynamic})
        for (const ShadowMode shadow :
             {ShadowMode::init, ShadowMode::full_shadow, ShadowMode::non_shadow, ShadowMode::partial_shadow})
            EXPECT_EQ(decision(occlusion, shadow), full_traversal);
}

// Table 3 and 2.6.

TEST(PaperSetModes, SetsShadowModesAsTable3)
{
    using enum ShadowMode;
    const SetModesOptions ours;
    EXPECT_EQ(shadow_bits(StaticPart::occluded, false, ours), full_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::occluded, true, ours), full_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::free, false, ours), non_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::free, true, ours), non_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::unknown, true, ours), init);
    const SetModesOptions printed{.remember_dynamic_blockers = true};
    EXPECT_EQ(shadow_bits(StaticPart::occluded, false, printed), full_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::free, false, printed), non_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::free, true, printed), full_shadow);
    EXPECT_EQ(shadow_bits(StaticPart::unknown, true, printed), full_shadow);
}

TEST(PaperSetModes, SetsOcclusionModeAtTheEndOfTheFrame)
{
    const SetModesOptions options;
    EXPECT_EQ(occlusion_after(k_init, k_init, 5, 0, options), k_whole);
    EXPECT_EQ(occlusion_after(k_init, k_partial, 5, 0, options), k_partial);
    EXPECT_EQ(occlusion_after(k_whole, k_partial, 5, 5, options), k_partial);
    EXPECT_EQ(occlusion_after(k_whole, k_dynamic, 5, 5, options), k_dynamic);
    EXPECT_EQ(occlusion_after(k_whole, k_init, 40, 10, options), k_whole);
    EXPECT_EQ(occlusion_after(k_whole, k_init, 41, 10, options), k_init);
    EXPECT_EQ(occlusion_after(k_whole, k_init, 0xffffffffu, 0x7fffffffu, options), k_whole) << "no overflow";
}

// Memory.

TEST(PaperModes, BitsOfManyLightsAreIndependent)
{
    for (const int lights : {0, 1, 9, 15, 16, 17, 40}) {
        Modes modes(3, lights);
        std::vector<PrimitiveId> touched;
        for (int l = 0; l < lights; ++l)
            if (l % 4 != 0) modes.note_shadow(1, l, static_cast<ShadowMode>(l % 4), touched);
        modes.set_occlusion(1, k_whole);
        for (int l = 0; l < lights; ++l)
            EXPECT_EQ(modes.shadow(1, l), ShadowMode::init) << "before the end of the frame";
        EXPECT_LE(touched.size(), 1u);
        for (const PrimitiveId p : touched) modes.merge_shadow(p);
        for (int l = 0; l < lights; ++l) {
            EXPECT_EQ(modes.shadow(1, l), static_cast<ShadowMode>(l % 4)) << "light " << l << " of " << lights;
            EXPECT_EQ(modes.shadow(0, l), ShadowMode::init);
            EXPECT_EQ(modes.shadow(2, l), ShadowMode::init);
        }
        EXPECT_EQ(modes.occlusion(1), k_whole);
        EXPECT_EQ(modes.occlusion(0), k_init);

        // Reset one light's modes; the others stay.
        if (lights < 3) continue;
        modes.forget_light(lights - 1);
        for (int l = 0; l < lights; ++l)
            EXPECT_EQ(modes.shadow(1, l), l == lights - 1 ? ShadowMode::init : static_cast<ShadowMode>(l % 4));
        modes.forget_shadow(1);
        for (int l = 0; l < lights; ++l) EXPECT_EQ(modes.shadow(1, l), ShadowMode::init);
        EXPECT_EQ(modes.occlusion(1), k_whole);
    }
}

TEST(PaperModes, FullAndNonShadowMergeToPartial)
{
    Modes modes(1, 1);
    std::vector<PrimitiveId> touched;
    modes.note_shadow(0, 0, ShadowMode::full_shadow, touched);
    modes.merge_shadow(0);
    EXPECT_EQ(modes.shadow(0, 0), ShadowMode::full_shadow);
    modes.note_shadow(0, 0, ShadowMode::non_shadow, touched);
    modes.merge_shadow(0);
    EXPECT_EQ(modes.shadow(0, 0), ShadowMode::partial_shadow);
    EXPECT_EQ(touched.size(), 2u) << "once per frame";
}

// The frame.

TEST_F(PaperCullingTest, UsesModesOfThePreviousFrame)
{
    culling_.begin_frame(state_, rays_, PaperChanges{});
    EXPECT_EQ(decide(wide), ShadowDecision::full_traversal);
    note(wide, StaticPart::occluded, 0);
    note(wide, StaticPart::free, 1);
    see({{wide, 10}});
    EXPECT_EQ(decide(wide), ShadowDecision::full_traversal) << "no change within the frame";
    culling_.end_frame(notes_);
    culling_.begin_frame(state_, rays_, PaperChanges{});
    EXPECT_EQ(decide(wide, 0), ShadowDecision::in_shadow);
    EXPECT_EQ(decide(wide, 1), ShadowDecision::dynamic_only);
    EXPECT_EQ(decide(small, 0), ShadowDecision::full_traversal);
    culling_.end_frame(notes_);
    EXPECT_EQ(culling_.counters().rays, 3u);
    EXPECT_EQ(culling_.counters().skipped, 1u);
    EXPECT_EQ(culling_.counters().dynamic_only, 1u);
}

TEST_F(PaperCullingTest, PartlyOccludedIsReset)
{
    culling_.begin_frame(state_, rays_, PaperChanges{});
    note(wide, StaticPart::free);
    const std::vector<PrimaryHit> edge(1, pixel(wide));
    culling_.see_image(edge, 1);
    culling_.end_frame(notes_);
    EXPECT_EQ(culling_.modes().occlusion(wide), k_partial);
    culling_.begin_frame(state_, rays_, PaperChanges{});
    EXPECT_EQ(culling_.modes().occlusion(wide), k_init);
    EXPECT_EQ(decide(wide), ShadowDecision::full_traversal);
    see({{wide, 10}});
    culling_.end_frame(notes_);
    EXPECT_EQ(culling_.modes().occlusion(wide), k_whole);
    EXPECT_EQ(decide(wide), ShadowDecision::dynamic_only) << "its shadow bits are kept";
}

TEST_F(PaperCullingTest, ZoomInByMoreThanFourResets)
{
    culling_.begin_frame(state_, rays_, PaperChanges{});
    note(wide, StaticPart::free);
    see({{wide, 10}});
    culling_.end_frame(notes_);
    frame({{wide, 40}});   // exactly 4 times: not yet
    EXPECT_EQ(culling_.modes().occlusion(wide), k_whole);
    EXPECT_EQ(culling_.modes().most_pixels(wide), 40u);
    frame({{wide, 3}});
    EXPECT_EQ(culling_.modes().most_pixels(wide), 40u);
    frame({{wide, 161}});
    EXPECT_EQ(culling_.modes().occlusion(wide), k_init);
    EXPECT_EQ(culling_.modes().most_pixels(wide), 161u);
    EXPECT_EQ(culling_.modes().shadow(wide, 0), ShadowMode::non_shadow) << "the shadow bits are kept";
    culling_.begin_frame(state_, rays_, PaperChanges{});
    EXPECT_EQ(decide(wide), ShadowDecision::full_traversal);
    note(wide, StaticPart::occluded);   // a shadow that was too small to be seen
    see({{wide, 161}});
    culling_.end_frame(notes_);
    EXPECT_EQ(culling_.modes().occlusion(wide), k_whole);
    EXPECT_EQ(culling_.modes().shadow(wide, 0), ShadowMode::partial_shadow);
}

TEST_F(PaperCullingTest, MirrorHitsUpdateShadowModesButNotOcclusionModes)
{
    culling_.begin_frame(state_, rays_, PaperChanges{});
    note(small, StaticPart::occluded);
    see({{wide, 10}});
    culling_.end_frame(notes_);
    EXPECT_EQ(culling_.modes().shadow(small, 0), ShadowMode::full_shadow);
    EXPECT_EQ(culling_.modes().occlusion(small), k_init);
    EXPECT_EQ(decide(small), ShadowDecision::full_traversal);
}

TEST_F(PaperCullingTest, MovedLightResetsItsOwnModesOnly)
{
    culling_.begin_frame(state_, rays_, PaperChanges{});
    note(wide, StaticPart::occluded, 0);
    note(wide, StaticPart::occluded, 1);
    see({{wide, 10}});
    culling_.end_frame(notes_);
    const scene::LightId moved[] = {1};
    culling_.begin_frame(state_, rays_, {.lights = moved, .started = {}, .stopped = {}});
    EXPECT_EQ(decide(wide, 0), ShadowDecision::in_shadow);
    EXPECT_EQ(decide(wide, 1), ShadowDecision::full_traversal);
}

TEST_F(PaperCullingTest, StartingOrStoppingObjectResetsPrimitivesItMayShadow)
{
    const auto learn = [&] {
        culling_.begin_frame(state_, rays_, PaperChanges{});
        for (const PrimitiveId p : {wide, small, beside, other}) note(p, StaticPart::occluded);
        see({{wide, 10}, {small, 4}, {beside, 4}, {other, 4}});
        culling_.end_frame(notes_);
    };
    learn();
    const scene::ObjectId objects[] = {small};
    culling_.begin_frame(state_, rays_, {.lights = {}, .started = objects, .stopped = {}});
    EXPECT_TRUE(culling_.triangles().is_dynamic(small));
    EXPECT_EQ(culling_.modes().shadow(wide, 0), ShadowMode::init) << "below it";
    EXPECT_EQ(culling_.modes().shadow(small, 0), ShadowMode::init) << "itself";
    EXPECT_EQ(culling_.modes().shadow(beside, 0), ShadowMode::full_shadow) << "far away";
    EXPECT_EQ(culling_.modes().shadow(other, 0), ShadowMode::full_shadow) << "far away";
    culling_.end_frame(notes_);
    learn();
    EXPECT_EQ(culling_.modes().occlusion(small), k_dynamic);
    EXPECT_EQ(culling_.modes().shadow(small, 0), ShadowMode::init) << "moving primitives keep their mode";
    EXPECT_EQ(culling_.modes().shadow(wide, 0), ShadowMode::full_shadow);
    culling_.begin_frame(state_, rays_, {.lights = {}, .started = {}, .stopped = objects});
    EXPECT_FALSE(culling_.triangles().is_dynamic(small));
    EXPECT_EQ(culling_.modes().occlusion(small), k_init);
    EXPECT_EQ(culling_.modes().shadow(wide, 0), ShadowMode::init);
    EXPECT_EQ(culling_.modes().shadow(beside, 0), ShadowMode::full_shadow);
}

TEST_F(PaperCullingTest, ByFrameAnObjectIsDynamicFromItsMotionUntilItHasRested)
{
    PaperCulling culling(state_, rays_);
    const auto next_frame = [&] {
        state_.advance(0);
        rays_.update(state_);
        culling.begin_frame(state_, rays_);
    };
    const auto see_wide = [&](StaticPart found) {
        culling.note(wide, 0, found, false, notes_[0]);
        std::vector<PrimaryHit> image(15);
        image[7] = pixel(wide);
        culling.see_image(image, 5);
        culling.end_frame(notes_);
    };
    // While nothing moves, not even the object that may move in the clip is dynamic, and NON_SHADOW needs no ray.
    next_frame();
    EXPECT_FALSE(culling.any_dynamic());
    EXPECT_FALSE(culling.is_dynamic(dynamic_object));
    EXPECT_TRUE(culling.some_rest());
    see_wide(StaticPart::free);
    next_frame();
    EXPECT_EQ(culling.decide(wide, 0, notes_[0]), ShadowDecision::lit);
    culling.end_frame(notes_);
    EXPECT_EQ(culling.counters().skipped, 1u);

    // A motion makes it dynamic, and what it may have shadowed is forgotten.
    const glm::dmat4 moved = test::translation(0, 0, 5);
    state_.override_transform(scene_->objects[small].node, &moved);
    next_frame();
    EXPECT_TRUE(culling.is_dynamic(small));
    EXPECT_EQ(culling.modes().shadow(wide, 0), ShadowMode::init);
    see_wide(StaticPart::free);
    next_frame();
    EXPECT_EQ(culling.decide(wide, 0, notes_[0]), ShadowDecision::dynamic_only);
    culling.end_frame(notes_);

    // After eight frames of rest it is static, and what it may shadow now is forgotten.
    int frames = 1;
    for (; culling.is_dynamic(small) && frames < 20; ++frames) {
        next_frame();
        culling.end_frame(notes_);
    }
    EXPECT_EQ(frames, 8);
    EXPECT_EQ(culling.modes().shadow(wide, 0), ShadowMode::init);
    EXPECT_EQ(culling.modes().occlusion(small), k_init);
    EXPECT_FALSE(culling.any_dynamic());
}

// As printed: modes are written at once.

class PaperAsPrinted : public PaperCullingTest {
 protected:
    PaperCulling printed_{state_, rays_, PaperOptions::as_printed()};

    ShadowDecision decide_now(PrimitiveId p, int light = 0) { return printed_.decide(p, light, notes_[0]); }
    void note_now(PrimitiveId p, StaticPart part, int light = 0, bool dynamic = false)
    {
        printed_.note(p, light, part, dynamic, notes_[0]);
    }
    OcclusionMode mode(PrimitiveId p) const { return printed_.modes().occlusion(p); }
};

TEST_F(PaperAsPrinted, ModesChangeWithinTheFrame)
{
    printed_.begin_frame(state_, rays_);
    printed_.see_pixel(pixel(wide), no_primitive, no_primitive, false);
    printed_.end_frame(notes_);
    EXPECT_EQ(mode(wide), k_whole);

    // The first ray of the next frame decides what the second does, although the frame has not ended.
    printed_.begin_frame(state_, rays_);
    EXPECT_EQ(decide_now(wide), ShadowDecision::full_traversal);
    note_now(wide, StaticPart::occluded);
    EXPECT_EQ(decide_now(wide), ShadowDecision::in_shadow);
    // A pixel on the edge of the screen ends that for the rest of the frame.
    printed_.see_pixel(pixel(wide), no_primitive, no_primitive, true);
    EXPECT_EQ(decide_now(wide), ShadowDecision::full_traversal);
    printed_.end_frame(notes_);
    EXPECT_EQ(printed_.counters().full[static_cast<std::size_t>(FullReason::not_shadowed)], 1u);
    EXPECT_EQ(printed_.counters().skipped, 1u);
}

TEST_F(PaperAsPrinted, PartlyOccludedStaysForEver)
{
    for (int f = 0; f < 3; ++f) {
        printed_.begin_frame(state_, rays_);
        printed_.see_pixel(pixel(wide), no_primitive, no_primitive, f == 0);
        EXPECT_EQ(mode(wide), k_partial) << "frame " << f;
        printed_.end_frame(notes_);
        EXPECT_EQ(mode(wide), k_partial) << "frame " << f;
    }
}

TEST_F(PaperAsPrinted, RemembersShadowsOfDynamicObjects)
{
    printed_.begin_frame(state_, rays_);
    EXPECT_TRUE(printed_.is_dynamic(dynamic_object)) << "it may move in the clip, and rests";
    note_now(wide, StaticPart::free, 1, true);
    EXPECT_EQ(printed_.modes().shadow(wide, 1), ShadowMode::full_shadow);
    note_now(wide, StaticPart::free, 1);
    EXPECT_EQ(printed_.modes().shadow(wide, 1), ShadowMode::partial_shadow);
    printed_.see_pixel(pixel(dynamic_object), no_primitive, no_primitive, true);
    EXPECT_EQ(mode(dynamic_object), k_dynamic);
    printed_.end_frame(notes_);
}

TEST_F(PaperAsPrinted, TestsANeighbourAgainOnlyIfTheFirstTestFailed)
{
    const auto tests = [&](const PrimaryHit& current, PrimitiveId left, PrimitiveId upper) {
        printed_.begin_frame(state_, rays_);
        printed_.see_pixel(current, left, upper, false);
        printed_.end_frame(notes_);
        return printed_.counters().extra_tests;
    };
    // Line 17 repeats lines 9 to 15 for the upper pixel: `small` ends before this pixel, so it is tested twice.
    EXPECT_EQ(tests(pixel(wide, 10, 10), small, small), 2u);
    PaperCulling other(state_, rays_, PaperOptions::as_printed());
    other.begin_frame(state_, rays_);
    other.see_pixel(pixel(small, 1.5f, 1.5f), wide, wide, false);   // `wide` continues: line 9 fails the second time
    other.end_frame(notes_);
    EXPECT_EQ(other.counters().extra_tests, 1u);
    EXPECT_EQ(other.modes().occlusion(wide), k_partial);
}

TEST_F(PaperAsPrinted, ZoomInByMoreThanFourResets)
{
    const auto frame_of = [&](int pixels) {
        printed_.begin_frame(state_, rays_);
        for (int i = 0; i < pixels; ++i) printed_.see_pixel(pixel(wide), no_primitive, no_primitive, false);
        printed_.end_frame(notes_);
        return mode(wide);
    };
    EXPECT_EQ(frame_of(10), k_whole);
    EXPECT_EQ(frame_of(40), k_whole);
    EXPECT_EQ(frame_of(161), k_init);
}

// Parts of triangles.

TEST_F(PaperCullingTest, PartsOfATriangleAreItsTilesWithModesOfTheirOwn)
{
    const SceneTriangles parts(state_, rays_, 3, 1e-6f);
    EXPECT_EQ(parts.size(), primitive_count * 64u);
    double area = 0;
    for (PrimitiveId p = parts.first_of(wide); p < parts.end_of(wide); ++p) {
        glm::vec3 c[3];
        parts.corners(p, c);
        area += 0.5 * glm::length(glm::cross(c[1] - c[0], c[2] - c[0]));
        // The middle of a part lies in it: its barycentric coordinates in the triangle lead back to it.
        const glm::vec3 middle = (c[0] + c[1] + c[2]) / 3.0f;
        const float v = (middle.y + 40) / 100, u = (middle.x + 40 - 40 * v) / 80;
        EXPECT_EQ(parts.at(wide, 0, u, v), p);
        EXPECT_EQ(parts.object_of(p), wide);
    }
    EXPECT_NEAR(area, 0.5 * 80 * 100, 0.01);

    // Small triangles stay whole, and whole triangles are numbered as before.
    const SceneTriangles divided(state_, rays_, 3);
    EXPECT_EQ(divided.end_of(small) - divided.first_of(small), 1u);
    EXPECT_GT(divided.end_of(wide) - divided.first_of(wide), 1u);

    PaperCulling culling(state_, rays_, by_clip(3));
    const PrimitiveId one = culling.primitive(wide, 0, 0.1f, 0.1f), two = culling.primitive(wide, 0, 0.8f, 0.1f);
    EXPECT_NE(one, two);
    culling.begin_frame(state_, rays_);
    culling.note(one, 0, StaticPart::occluded, false, notes_[0]);
    culling.note(two, 0, StaticPart::free, false, notes_[0]);
    culling.end_frame(notes_);
    EXPECT_EQ(culling.modes().shadow(one, 0), ShadowMode::full_shadow);
    EXPECT_EQ(culling.modes().shadow(two, 0), ShadowMode::non_shadow);
}

TEST_F(PaperCullingTest, UserOverrideMakesAStaticObjectDynamic)
{
    const glm::dmat4 moved = test::translation(0, 0, 5);
    state_.override_transform(scene_->objects[small].node, &moved);
    state_.advance(0);
    rays_.update(state_);
    culling_.begin_frame(state_, rays_);
    EXPECT_TRUE(culling_.triangles().is_dynamic(small));
    EXPECT_FALSE(culling_.triangles().is_dynamic(wide));
}

TEST_F(PaperCullingTest, NotesMergeToTheSameForAnyThreadCount)
{
    const auto learn = [&](std::size_t threads) {
        PaperCulling culling(state_, rays_);
        std::vector<Notes> notes(threads);
        Tasks tasks(static_cast<int>(threads));
        culling.begin_frame(state_, rays_, PaperChanges{});
        tasks.for_each(20000, [&](std::size_t i, int worker) {
            const auto p = static_cast<PrimitiveId>(i % primitive_count);
            const bool occluded = p == wide ? i % 3 == 0 : p == small;
            culling.decide(p, static_cast<int>(i % 2), notes[static_cast<std::size_t>(worker)]);
            culling.note(p, static_cast<int>(i % 2), occluded ? StaticPart::occluded : StaticPart::free, false,
                         notes[static_cast<std::size_t>(worker)]);
        });
        culling.end_frame(notes);
        EXPECT_EQ(culling.counters().rays, 20000u);
        std::vector<ShadowMode> modes;
        for (PrimitiveId p = 0; p < primitive_count; ++p)
            for (int l = 0; l < 2; ++l) modes.push_back(culling.modes().shadow(p, l));
        return modes;
    };
    const std::vector<ShadowMode> one = learn(1), four = learn(4);
    EXPECT_EQ(one, four);
    EXPECT_EQ(one[2 * wide], ShadowMode::partial_shadow);
    EXPECT_EQ(one[2 * small], ShadowMode::full_shadow);
    EXPECT_EQ(one[2 * beside], ShadowMode::non_shadow);
}

TEST(PaperMayShadow, IsConservativeAndSometimesFalse)
{
    const auto box = [](const glm::vec3& at, float half) {
        Box3 b;
        b.add(at - half), b.add(at + half);
        return b;
    };
    // Random segments from receivers to lights through occluders: the result is never false where one is occluded.
    Random random(7);
    const auto point = [&](float reach) {
        const float x = random.uniform(-reach, reach), y = random.uniform(-reach, reach);
        return glm::vec3(x, y, random.uniform(-reach, reach));
    };
    for (const scene::LightType type : {scene::LightType::point, scene::LightType::directional}) {
        scene::Light light;
        light.type = type;
        int no = 0;
        for (int i = 0; i < 2000; ++i) {
            scene::LightState at;
            at.position = point(5);
            at.direction = glm::normalize(point(1));
            const Box3 receiver = box(point(10), random.uniform(0.1f, 3)), occluder = box(point(10), 0.5f);
            const glm::vec3 from = receiver.centre() + 0.49f * receiver.size() * point(1);
            const glm::vec3 to_light = type == scene::LightType::point ? at.position - from : -20.0f * at.direction;
            const Box3 in_between = box(from + random.uniform() * to_light + 0.49f * occluder.size() * point(1), 0.5f);
            EXPECT_TRUE(may_shadow(light, at, in_between, receiver));
            no += !may_shadow(light, at, occluder, receiver);
        }
        EXPECT_GT(no, 400);
    }
}

}   // namespace
}   // namespace gnomon::shadow_culling
