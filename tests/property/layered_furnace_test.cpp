// SPDX-License-Identifier: Apache-2.0
// A white furnace for layered materials: a white square under an even environment of radiance 1 shows at most that.
#include <gtest/gtest.h>

#include <cmath>

#include "gnomon/gnomon.h"
#include "host_scene.h"
#ifdef GNOMON_VULKAN
#include "vk_helpers.h"
#endif

namespace gnomon {
namespace {

float seen(const Material& material, double tilt)
{
    SceneBuilder b;
    const test::Shape shape = test::square(2);
    b.instance(b.mesh(shape.mesh()), b.material(material),
               Transform::translation(0, 0, -4) * Transform::rotation({1, 0, 0}, tilt));
    const std::vector<float> even(std::size_t{64} * 32 * 3, 1.0f);
    b.environment({.width = 64, .height = 32, .pixels = even});
    b.camera(test::camera_along_z());
    Renderer renderer(test::plain({32, 32}));
    return renderer.render(b.finish(), 1).layers.front().value(16, 17, 1);
}

TEST(LayeredFurnace, NoMaterialShowsMoreThanItsSurroundings)
{
    MaterialLayers coat, rough_coat, sheen, specular, iridescence, thin, brushed;
    coat.clearcoat = rough_coat.clearcoat = 1, rough_coat.clearcoat_roughness = .6f;
    sheen.sheen_color = {1, 1, 1}, sheen.sheen_roughness = .5f;
    specular.specular_color = {20, 20, 20};
    iridescence.iridescence = 1;
    thin.thin_walled = true;
    brushed.anisotropy = 1;
    const std::pair<const char*, const MaterialLayers*> cases[] = {
        {"coat", &coat},       {"rough coat", &rough_coat},   {"sheen", &sheen}, {"specular", &specular},
        {"brushed", &brushed}, {"iridescence", &iridescence}, {"thin", &thin}};
    for (const auto& [name, layers] : cases)
        for (const float roughness : {0.0f, .3f, 1.0f})
            for (const double tilt : {0.0, -1.2}) {
                Material material{.base_color = {1, 1, 1}, .double_sided = true, .roughness = roughness};
                if (layers == &thin) material.transmission = 1;
                material.layers = *layers;
                const float there = seen(material, tilt);
                EXPECT_LE(there, 1.02f) << name << ' ' << roughness << ' ' << tilt;
                EXPECT_GE(there, .85f) << name << ' ' << roughness << ' ' << tilt;
            }
}

// A ball of each material in one image, before and within an even environment of radiance 1.
struct Ball {
    const char* name;
    Material material;
    float least;   // of what it must show: what its layers lose, and rays that end after many bounces
};

Material white(float roughness, const auto& layered)
{
    Material material{.base_color = {1, 1, 1}, .roughness = roughness};
    material.layers.emplace();
    layered(material, *material.layers);
    return material;
}

std::vector<Ball> balls()
{
    using L = MaterialLayers;
    const auto glass = [](Material& m, bool thin) { m.transmission = 1, m.layers->thin_walled = thin; };
    return {
        {"white", Material{.base_color = {1, 1, 1}, .roughness = 1}, .9f},
        {"metal", Material{.base_color = {1, 1, 1}, .metallic = 1, .roughness = .3f}, .85f},
        {"unlit", Material{.model = ShadingModel::unlit, .base_color = {1, 1, 1}}, .999f},
        {"specular",
         white(.4f,
               [](Material&, L& l) {
                   l.specular_color = {20, 20, 20};
               }),
         .8f},
        {"clearcoat", white(.6f, [](Material&, L& l) { l.clearcoat = 1; }), .85f},
        {"rough clearcoat", white(.6f, [](Material&, L& l) { l.clearcoat = 1, l.clearcoat_roughness = .5f; }), .8f},
        {"sheen",
         white(1,
               [](Material&, L& l) {
                   l.sheen_color = {1, 1, 1}, l.sheen_roughness = .5f;
               }),
         .8f},
        {"anisotropy", white(.3f, [](Material& m, L& l) { m.metallic = 1, l.anisotropy = 1; }), .7f},
        {"iridescence", white(.2f, [](Material&, L& l) { l.iridescence = 1; }), .8f},
        {"thin glass", white(0, [&](Material& m, L&) { glass(m, true); }), .9f},
        {"rough thin glass", white(.4f, [&](Material& m, L&) { glass(m, true); }), .8f},
        {"glass", white(0, [&](Material& m, L&) { glass(m, false); }), .9f},
        {"rough glass", white(.4f, [&](Material& m, L&) { glass(m, false); }), .8f},
        {"diamond", white(0, [&](Material& m, L&) { glass(m, false), m.ior = 2.4f; }), .8f},
        {"dispersion", white(0, [&](Material& m, L& l) { glass(m, false), l.dispersion = 5; }), .85f},
        {"volume", white(0, [&](Material& m, L& l) { glass(m, false), l.attenuation_distance = .1f; }), .9f},
    };
}

constexpr int k_columns = 4, k_pixels = 24;   // a side of a ball's square

Scene scene_of_balls(const std::vector<Ball>& all)
{
    test::Shape shape;
    std::vector<Vec3> normals;
    constexpr int k_rings = 24, k_around = 48;
    for (int ring = 0; ring <= k_rings; ++ring)
        for (int step = 0; step <= k_around; ++step) {
            const double polar = 3.14159265358979 * ring / k_rings, turn = 2 * 3.14159265358979 * step / k_around;
            normals.push_back({static_cast<float>(std::sin(polar) * std::cos(turn)),
                               static_cast<float>(std::cos(polar)),
                               static_cast<float>(std::sin(polar) * std::sin(turn))});
            shape.positions.push_back({.45f * normals.back().x, .45f * normals.back().y, .45f * normals.back().z});
        }
    for (std::uint32_t ring = 0; ring < k_rings; ++ring)
        for (std::uint32_t step = 0; step < k_around; ++step) {
            const std::uint32_t a = ring * (k_around + 1) + step, c = a + k_around + 1;
            if (ring > 0) shape.indices.insert(shape.indices.end(), {a, a + 1, c});
            if (ring + 1 < k_rings) shape.indices.insert(shape.indices.end(), {a + 1, c + 1, c});
        }
    Mesh mesh = shape.mesh();
    mesh.normals = normals;
    SceneBuilder b;
    const auto id = b.mesh(mesh);
    const int rows = static_cast<int>(all.size()) / k_columns;
    for (std::size_t i = 0; i < all.size(); ++i)
        b.instance(id, b.material(all[i].material),
                   Transform::translation(static_cast<double>(i % k_columns) - 1.5,
                                          .5 * (rows - 1) - static_cast<double>(i / k_columns), 0));
    const std::vector<float> even(std::size_t{64} * 32 * 3, 1.0f);
    b.environment({.width = 64, .height = 32, .pixels = even});
    Camera camera;
    camera.transform = Transform::look_at({0, 0, 40}, {0, 0, 0});
    camera.vertical_fov = 2 * std::atan(.5 * rows / 40);
    b.camera(camera);
    return b.finish();
}

// Expects the mean and the largest value of each ball's middle within limits. Single pixels may show more than their
// surroundings where light is interpolated and balls mirror each other, but no ball does as a whole.
void expect_even(const std::vector<Ball>& all, const RenderOptions& options, float most, float most_anywhere,
                 float of_least = 1)
{
    const Scene scene = scene_of_balls(all);
    Renderer renderer(options);
    const Frame frame = renderer.render(scene, 1);
    for (std::size_t i = 0; i < all.size(); ++i) {
        double sum = 0;
        float largest = 0;
        int count = 0;
        for (int y = 0; y < k_pixels; ++y)
            for (int x = 0; x < k_pixels; ++x) {
                const float dx = (static_cast<float>(x) + .5f) / k_pixels - .5f,
                            dy = (static_cast<float>(y) + .5f) / k_pixels - .5f;
                if (dx * dx + dy * dy > .4f * .4f) continue;
                const float value = frame.layers.front().value(static_cast<int>(i % k_columns) * k_pixels + x,
                                                               static_cast<int>(i / k_columns) * k_pixels + y, 1);
                sum += static_cast<double>(value), ++count;
                largest = std::max(largest, value);
            }
        EXPECT_LE(sum / count, static_cast<double>(most)) << all[i].name;
        EXPECT_GE(sum / count, static_cast<double>(of_least * all[i].least)) << all[i].name;
        EXPECT_LE(largest, most_anywhere) << all[i].name;
    }
}

RenderOptions options_for(const std::vector<Ball>& all)
{
    RenderOptions options;
    options.size = {k_columns * k_pixels, static_cast<int>(all.size()) / k_columns * k_pixels};
    return options;
}

TEST(LayeredFurnace, NoBallShinesInTracedFrames)
{
    const std::vector<Ball> all = balls();
    expect_even(all, options_for(all), 1.01f, 1.5f);
}

TEST(LayeredFurnace, NoBallShinesInReferences)
{
    const std::vector<Ball> all = balls();
    RenderOptions options = options_for(all);
    options.reference = ReferenceLightOptions{.spp = 64, .bounces = 16};
    expect_even(all, options, 1.02f, 3);   // single pixels have noise
}

#ifdef GNOMON_VULKAN
class LayeredFurnaceVulkan : public test::VulkanTest {};

TEST_F(LayeredFurnaceVulkan, NoBallShinesInRasterisedFrames)
{
    const std::vector<Ball> all = balls();
    RenderOptions options = options_for(all);
    options.renderer = RenderMethod::raster;
    expect_even(all, options, 1.01f, 1.2f, .8f);   // reflections within glass end at its first surface
}
#endif

}   // namespace
}   // namespace gnomon
