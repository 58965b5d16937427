// SPDX-License-Identifier: Apache-2.0
// Coats under lights with size: their lobe reflects the light as far as it is rough, and their mirror ray as far as it
// is smooth. A light is counted once.
#include <gtest/gtest.h>

#include <cmath>

#include "gnomon/gnomon.h"
#include "host_scene.h"
#include "two_references.h"

namespace gnomon {
namespace {

using test::plain;

// A black surface of index 1 below a coat: the coat is all that it reflects.
Material coated(float roughness, float coat = 1)
{
    Material material{.base_color = {0, 0, 0}, .roughness = 1, .ior = 1};
    material.layers.emplace();
    material.layers->clearcoat = coat;
    material.layers->clearcoat_roughness = roughness;
    return material;
}

// A coated floor before an emissive panel, of which a post hides a part.
Scene floor_and_panel(const Material& floor)
{
    SceneBuilder b;
    const test::Shape ground{{{-6, -1, 6}, {6, -1, 6}, {6, -1, -3}, {-6, -1, -3}}, {0, 1, 2, 0, 2, 3}};
    b.instance(b.mesh(ground.mesh()), b.material(floor));
    b.instance(b.mesh(test::square(1).mesh()), b.material({.base_color = {0, 0, 0}, .emissive = {6, 4, 2}, .ior = 1}),
               Transform::translation(0, .6, -2));
    b.instance(b.mesh(test::cube(.25f).mesh()), b.material({.base_color = {0, 0, 0}, .roughness = 1, .ior = 1}),
               Transform::translation(.5, -.6, -1));
    Camera camera;
    camera.transform = Transform::look_at({0, 1.5, 4}, {0, -1, .3});
    camera.vertical_fov = .6;
    b.camera(camera);
    return b.finish();
}

std::vector<float> rendered(const Scene& scene, const RenderOptions& options)
{
    const Frame frame = Renderer(options).render(scene, 1);
    const auto values = frame.layers.front().values();
    return {values.begin(), values.end()};
}

RenderOptions options_of(int size)
{
    RenderOptions options = plain({size, size});
    options.indirect = Indirect::visible;
    options.bounces = 1;
    return options;
}

std::vector<float> reference(const Scene& scene, std::uint64_t seed)
{
    RenderOptions options = options_of(32);
    options.reference = ReferenceLightOptions{.spp = 512, .bounces = 1, .seed = seed};
    return rendered(scene, options);
}

TEST(Coats, ReflectAPanelAsTheReferenceDoes)
{
    for (const float roughness : {.2f, .35f, .6f}) {
        const Scene scene = floor_and_panel(coated(roughness));
        const test::ErrorOfImage error =
            test::error_of(rendered(scene, options_of(32)), reference(scene, 1), reference(scene, 2));
        RecordProperty("nrmse", std::to_string(error.nrmse));
        EXPECT_LE(error.nrmse, .1) << roughness;
        EXPECT_NEAR(error.energy, 1, .03) << roughness;
    }
}

TEST(Coats, AnotherRoughnessIsNotThatOfTheReference)
{
    const Scene right = floor_and_panel(coated(.2f)), wrong = floor_and_panel(coated(.5f));
    EXPECT_GT(test::error_of(rendered(wrong, options_of(32)), reference(right, 1), reference(right, 2)).nrmse, .25);
}

// Within emissive walls a coat reflects what its Fresnel reflectance says, whatever its roughness: neither less, nor by
// the ray and the lobe both.
TEST(Coats, CountALightOnce)
{
    for (const double height : {4.0, 1.5}) {
        const double cosine = height / std::hypot(height, 3.0);
        const double fresnel = .04 + .96 * std::pow(1 - cosine, 5);
        for (const float roughness : {0.0f, .06f, .1f, .14f, .2f, .5f})
            for (const bool truth : {false, true}) {
                SceneBuilder b;
                const test::Shape ground{{{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}}, {0, 1, 2, 0, 2, 3}};
                b.instance(b.mesh(ground.mesh()), b.material(coated(roughness, .5f)));
                b.instance(
                    b.mesh(test::cube(20).mesh()),
                    b.material({.base_color = {0, 0, 0}, .double_sided = true, .emissive = {1, 1, 1}, .ior = 1}));
                Camera camera;
                camera.transform = Transform::look_at({0, static_cast<float>(height), 3}, {0, 0, 0});
                camera.vertical_fov = .02;
                b.camera(camera);
                RenderOptions options = options_of(8);
                if (truth) options.reference = ReferenceLightOptions{.spp = 256, .bounces = 1};
                const std::vector<float> image = rendered(b.finish(), options);
                double mean = 0;
                for (const float value : image) mean += static_cast<double>(value) / static_cast<double>(image.size());
                EXPECT_NEAR(mean / (.5 * fresnel), 1, .04) << height << ' ' << roughness << ' ' << truth;
            }
    }
}

}   // namespace
}   // namespace gnomon
