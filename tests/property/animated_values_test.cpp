// SPDX-License-Identifier: Apache-2.0
// Frames of clips that animate the values of lights, materials and cameras: those of a renderer that walked through the
// clip have the bytes of those that were rendered anew.
#include <gtest/gtest.h>

#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "pointer_document.h"
#include "same_frames.h"

namespace gnomon {
namespace {

using test::PointerDocument;

constexpr double k_times[] = {0, 0.25, 0.5, 0.5, 1.5, 2, 0.25};

const std::string k_light = test::k_light_pointer;

void animate_lights(PointerDocument& d)
{
    d.animate(k_light + "0/intensity", {0, 1, 2}, {4, 0, 6}, "SCALAR");
    d.animate(k_light + "1/color", {0, 2}, {1, 0, 0, 0, 1, 0}, "VEC3");
    d.animate(k_light + "1/spot/outerConeAngle", {0, 2}, {0.6f, 1.2f}, "SCALAR");
}

void animate_surfaces(PointerDocument& d)
{
    d.animate("/materials/0/pbrMetallicRoughness/baseColorFactor", {0, 2}, {1, 0, 0.5f, 1, 0, 1, 0.5f, 1}, "VEC4");
    d.animate("/materials/0/pbrMetallicRoughness/metallicFactor", {0, 2}, {0, 0.5f}, "SCALAR");
    d.animate("/materials/1/pbrMetallicRoughness/roughnessFactor", {0, 2}, {0.3f, 1}, "SCALAR");
}

void animate_emission(PointerDocument& d)
{
    d.animate("/materials/2/emissiveFactor", {0, 1, 2}, {0, 0, 0, 1, 0.5f, 0.25f, 1, 1, 1}, "VEC3");
    d.animate("/materials/1/extensions/KHR_materials_emissive_strength/emissiveStrength", {0, 1, 2}, {1, 1, 0},
              "SCALAR");
}

// Renders the clip with one renderer, and each frame with a new one.
void compare(PointerDocument& d, Indirect indirect)
{
    const auto loaded = std::make_shared<const scene::Scene>(d.load());
    ASSERT_TRUE(loaded->warnings.empty()) << loaded->warnings.front();
    const Scene scene = api::public_scene(loaded);
    RenderOptions options;
    options.size = {40, 30};
    options.indirect = indirect;
    options.layers = true;
    Renderer warm(options);
    std::vector<float> last;
    double time_before = -1;
    for (const double time : k_times) {
        SCOPED_TRACE(time);
        FrameInput input;
        input.time = time;
        const Frame walked = warm.render(scene, input);
        test::expect_same(walked, Renderer(options).render(scene, input));
        const auto now = walked.layers.front().values();
        const bool same = !last.empty() && std::equal(now.begin(), now.end(), last.begin(), last.end());
        EXPECT_EQ(same, time == time_before) << "what is animated shows";
        time_before = time;
        last.assign(now.begin(), now.end());
    }
}

TEST(AnimatedValues, LightsGiveTheFramesOfANewRenderer)
{
    for (const Indirect indirect : {Indirect::off, Indirect::visible}) {
        PointerDocument d;
        animate_lights(d);
        compare(d, indirect);
    }
}

TEST(AnimatedValues, SurfacesGiveTheFramesOfANewRenderer)
{
    for (const Indirect indirect : {Indirect::off, Indirect::visible}) {
        PointerDocument d;
        animate_surfaces(d);
        compare(d, indirect);
    }
}

TEST(AnimatedValues, EmissionGivesTheFramesOfANewRenderer)
{
    for (const Indirect indirect : {Indirect::off, Indirect::visible}) {
        PointerDocument d;
        animate_emission(d);
        compare(d, indirect);
    }
}

TEST(AnimatedValues, CamerasGiveTheFramesOfANewRenderer)
{
    PointerDocument d;
    d.animate("/cameras/0/perspective/yfov", {0, 2}, {0.9f, 0.3f}, "SCALAR");
    compare(d, Indirect::visible);
}

// A host's values take the place of the tracks, and give way to them again.
TEST(AnimatedValues, AHostsValuesWinUntilTheyAreReleased)
{
    PointerDocument d;
    animate_lights(d);
    animate_surfaces(d);
    animate_emission(d);
    const Scene scene = api::public_scene(std::make_shared<const scene::Scene>(d.load()));
    RenderOptions options;
    options.size = {40, 30};
    Renderer warm(options);
    const auto at = [](double time) {
        FrameInput input;
        input.time = time;
        return input;
    };
    FrameInput held = at(0.5);
    held.lights = {{scene.lights()[0], {.color = {3, 2, 1}}}};
    held.materials = {{scene.materials()[0], {.base_color = {0.25f, 0.5f, 0.25f}}}};
    warm.render(scene, at(0));
    warm.render(scene, held);
    FrameInput later = held;
    later.time = 1.5;
    test::expect_same(warm.render(scene, at(1.5)), Renderer(options).render(scene, later));
    FrameInput released = at(2);
    released.released_lights = {scene.lights()[0]};
    released.released_materials = {scene.materials()[0]};
    test::expect_same(warm.render(scene, released), Renderer(options).render(scene, at(2)));
}

}   // namespace
}   // namespace gnomon
