// SPDX-License-Identifier: Apache-2.0
// Shadows of what is partly transparent: light of every kind reaches a floor through a sheet, by every renderer, as far
// as the sheet's alpha leaves it; and outlines cast none.
#include <gtest/gtest.h>

#include <cmath>

#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "vk_helpers.h"

namespace gnomon {
namespace {

using test::plain;

enum class Lit { sun, spot, surface, image };

struct Setting {
    Lit lit = Lit::sun;
    Material sheet{};
    bool there = true;   // the sheet
};

// A floor in the plane z = -4 below a camera at the origin; a box of `sheet` around the floor and the camera lies
// between them and the light.
Scene make_scene(const Setting& setting)
{
    SceneBuilder b;
    const MaterialId white = b.material({.base_color = {.8f, .8f, .8f}, .roughness = 1});
    const test::Shape floor = test::square(2);
    b.instance(b.mesh(floor.mesh()), white, Transform::translation(0, 0, -4));
    if (setting.there) {
        const test::Shape box = test::cube(6);
        b.instance(b.mesh(box.mesh()), b.material(setting.sheet));
    }
    switch (setting.lit) {
        case Lit::sun:
            b.light({.type = LightType::directional, .color = {2, 2, 2}});
            break;
        case Lit::spot:
            b.light({.type = LightType::spot, .color = {900, 900, 900}, .outer_angle = .6f},
                    Transform::translation(0, 0, 20));
            break;
        case Lit::surface:
            b.area_light({.width = 8, .height = 8, .radiance = {20, 20, 20}}, Transform::translation(0, 0, 20));
            break;
        case Lit::image: {
            const std::vector<float> even(64 * 32 * 3, 1.0f);
            b.environment({.width = 64, .height = 32, .pixels = even});
            break;
        }
    }
    b.camera(test::camera_along_z());
    return b.finish();
}

float brightness(const Setting& setting, RenderOptions options)
{
    Renderer renderer(options);
    const Frame frame = renderer.render(make_scene(setting), 1);
    return frame.layers.front().value(24, 25, 1);
}

Material blend(float alpha)
{
    return {.base_color = {0, 0, 0}, .alpha = alpha, .alpha_mode = AlphaMode::blend, .roughness = 1};
}

TEST(ThinnedLight, PassesAsFarAsAlphaLeavesIt)
{
    for (const Lit lit : {Lit::sun, Lit::spot, Lit::surface, Lit::image}) {
        const RenderOptions options = plain({48, 48});
        const float whole = brightness({lit, {}, false}, options);
        ASSERT_GT(whole, .05f) << static_cast<int>(lit);
        for (const float alpha : {0.0f, .25f, .75f, 1.0f})
            EXPECT_NEAR(brightness({lit, blend(alpha)}, options) / whole, 1 - alpha, .01f)
                << "light " << static_cast<int>(lit) << " alpha " << alpha;
    }
}

TEST(ThinnedLight, IsTintedByThinGlass)
{
    Material glass{.base_color = {.9f, .5f, .1f}, .roughness = 0, .transmission = 1};
    glass.layers.emplace().thin_walled = true;
    const RenderOptions options = plain({48, 48});
    EXPECT_NEAR(brightness({Lit::sun, glass}, options) / brightness({Lit::sun, {}, false}, options), .5f, .01f);
    // A body of glass lets all of it through, as before.
    glass.layers.reset();
    EXPECT_NEAR(brightness({Lit::sun, glass}, options) / brightness({Lit::sun, {}, false}, options), 1, .01f);
}

TEST(ThinnedLight, ReachesTheReferenceToo)
{
    RenderOptions options = plain({48, 48});
    options.indirect = Indirect::visible;
    options.reference = ReferenceLightOptions{.spp = 256, .bounces = 1};
    for (const Lit lit : {Lit::surface, Lit::image}) {
        const float whole = brightness({lit, {}, false}, options);
        EXPECT_NEAR(brightness({lit, blend(.75f)}, options) / whole, .25f, .05f) << static_cast<int>(lit);
    }
}

TEST(ThinnedLight, PassesOutlinesWhole)
{
    Material outline{.base_color = {0, 0, 0}, .roughness = 1};
    outline.outline = true;
    const RenderOptions options = plain({48, 48});
    for (const Lit lit : {Lit::sun, Lit::spot, Lit::surface, Lit::image})
        EXPECT_EQ(brightness({lit, outline}, options), brightness({lit, {}, false}, options)) << static_cast<int>(lit);
    // The same box without the mark leaves the floor dark.
    outline.outline = false;
    EXPECT_LT(brightness({Lit::sun, outline}, options), 1e-3f);
}

TEST(ThinnedLight, AnotherAlphaFromAHostShowsInTheNextFrame)
{
    SceneBuilder b;
    const test::Shape floor = test::square(2), box = test::cube(6);
    b.instance(b.mesh(floor.mesh()), b.material({.base_color = {.8f, .8f, .8f}, .roughness = 1}),
               Transform::translation(0, 0, -4));
    const MaterialId sheet = b.material(blend(.25f));
    b.instance(b.mesh(box.mesh()), sheet);
    b.light({.type = LightType::directional, .color = {2, 2, 2}});
    b.camera(test::camera_along_z());
    const Scene scene = b.finish();
    Renderer renderer(plain({48, 48}));
    const float before = renderer.render(scene, 1).layers.front().value(24, 25, 1);
    FrameInput input;
    input.materials.push_back({sheet, blend(.5f)});
    const float after = renderer.render(scene, input).layers.front().value(24, 25, 1);
    EXPECT_NEAR(after / before, .5f / .75f, .01f);
}

#ifdef GNOMON_VULKAN
class ThinnedLightVulkan : public test::VulkanTest {};

TEST_F(ThinnedLightVulkan, RasterisedFramesAgree)
{
    RenderOptions options = plain({48, 48});
    const RenderOptions traced = options;
    options.renderer = RenderMethod::raster;
    // One case: pipelines are made anew for each renderer, which takes long on a device in software.
    const Setting setting{Lit::spot, blend(.75f)};
    const float expected = brightness(setting, traced);
    EXPECT_NEAR(brightness(setting, options), expected, .01f * expected + 2e-3f);
}
#else
TEST(ThinnedLightVulkan, RasterisedFramesAgree)
{
    GNOMON_SKIP_WITHOUT_VULKAN;
}
#endif

}   // namespace
}   // namespace gnomon
