// SPDX-License-Identifier: Apache-2.0
// Rasterised frames under environment images and suns with a size, against traced ones.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <algorithm>
#include <cmath>
#include <string>

#include "gnomon/gnomon.h"
#include "same_frames.h"
#include "support.h"

namespace gnomon {
namespace {

class RasterEnvironment : public test::VulkanTest {};

const std::vector<Vec3> k_square{{-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
const std::vector<std::uint32_t> k_up{0, 2, 1, 0, 3, 2};

// Grey above and dark below, with one bright square.
std::vector<float> uneven_sky(int width, int height)
{
    std::vector<float> pixels(static_cast<std::size_t>(width * height * 3));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                float& value = pixels[static_cast<std::size_t>(3 * (y * width + x) + c)];
                value = 2 * y < height ? 0.5f + 0.1f * static_cast<float>(c) : 0.15f;
                if (x > width / 8 && x < width / 4 && y > height / 5 && y < height / 3) value += 8;
            }
    return pixels;
}

enum class Sky : std::uint8_t { image, sun };

// Boxes of matte, glossy and half-transparent material over a floor, and one that may move.
Scene boxes(Sky sky, InstanceId* moving = nullptr, bool transparent = true)
{
    SceneBuilder builder;
    const MaterialId grey = builder.material({.base_color = {0.6f, 0.6f, 0.6f}, .double_sided = true, .roughness = 1}),
                     metal = builder.material(
                         {.base_color = {0.9f, 0.7f, 0.5f}, .double_sided = true, .metallic = 1, .roughness = 0.6f}),
                     gauze = builder.material({.base_color = {0.2f, 0.5f, 0.8f},
                                               .double_sided = true,
                                               .alpha = 0.4f,
                                               .alpha_mode = AlphaMode::blend,
                                               .roughness = 1});
    const MeshId square = builder.mesh({.positions = k_square, .indices = k_up});
    builder.instance(square, grey, Transform::scaling(8, 1, 8));
    builder.instance(
        square, grey,
        Transform::translation(-0.9, 0.6, 0) * Transform::rotation({0, 0, 1}, 1.2) * Transform::scaling(1.2, 1, 1));
    builder.instance(square, metal, Transform::translation(0.8, 0.5, 0.2) * Transform::rotation({1, 0, 0}, 0.8));
    if (transparent)
        builder.instance(square, gauze, Transform::translation(0, 0.5, 1.2) * Transform::rotation({1, 0, 0}, 1.5));
    const InstanceId may_move =
        builder.instance(square, grey, Transform::translation(0.1, 1, 0) * Transform::scaling(0.7, 1, 0.7),
                         {.mobility = moving ? Mobility::may_move : Mobility::fixed});
    if (moving) *moving = may_move;
    if (sky == Sky::image) {
        const std::vector<float> pixels = uneven_sky(64, 32);
        builder.environment({.width = 64, .height = 32, .pixels = pixels});
    } else {
        builder.light({.type = LightType::directional, .color = {2, 2, 2}}, Transform::rotation({1, 0, 0}, -1.2));
    }
    Camera camera;
    camera.transform = Transform::look_at({0.5f, 2, 4}, {0, 0.4f, 0});
    camera.vertical_fov = 0.8;
    builder.camera(camera);
    return builder.finish();
}

RenderOptions options_of(RenderMethod renderer)
{
    RenderOptions options;
    options.renderer = renderer;
    options.size = {96, 72};
    options.indirect = Indirect::off;
    options.layers = true;
    options.max_depth = 0;
    options.exposure = 0;
    options.sun_size = 8;
    return options;
}

std::vector<float> values(const Frame& image, const std::string& name)
{
    for (const Layer& l : image.layers)
        if (l.name == name) return l.copy();
    throw std::runtime_error("no layer " + name);
}

// How two frames differ where both see the same surface.
struct Difference {
    double rmse = 0, mean = 0;   // mean: of the first
    std::size_t compared = 0;
};
Difference difference(const Frame& a, const Frame& b, const std::string& name)
{
    const std::vector<float> va = values(a, name), vb = values(b, name), za = values(a, "depth"),
                             zb = values(b, "depth");
    const std::size_t channels = va.size() / za.size();
    Difference result;
    double square = 0;
    for (std::size_t i = 0; i < va.size(); ++i) {
        const float depth = za[i / channels];
        if (!(depth > 0) || std::abs(depth - zb[i / channels]) > 1e-4f * depth) continue;
        square += std::pow(static_cast<double>(va[i] - vb[i]), 2);
        result.mean += static_cast<double>(va[i]), ++result.compared;
    }
    result.rmse = std::sqrt(square / static_cast<double>(result.compared));
    result.mean /= static_cast<double>(result.compared);
    return result;
}

TEST_F(RasterEnvironment, LightOfAnImageIsThatOfTheTracedFrame)
{
    // Without reflected and refracted rays, the traced frame does not show what lies behind transparent surfaces: then
    // the first layer of surfaces is compared.
    for (const bool transparent : {false, true}) {
        const Scene scene = boxes(Sky::image, nullptr, transparent);
        const Frame traced = Renderer(options_of(RenderMethod::trace)).render(scene, 1),
                    raster = Renderer(options_of(RenderMethod::raster)).render(scene, 1);
        const Difference d = difference(traced, raster, transparent ? "direct" : "");
        EXPECT_GT(d.compared, 96u * 72 * 3 / 2);
        EXPECT_GT(d.mean, 0.1);
        EXPECT_LE(d.rmse, 0.01 * d.mean) << transparent;
        EXPECT_GT(raster.counters.shadow.rays, 1000u);
    }
}

TEST_F(RasterEnvironment, PenumbraOfASunIsThatOfTheTracedFrame)
{
    const Scene scene = boxes(Sky::sun, nullptr, false);
    const Frame traced = Renderer(options_of(RenderMethod::trace)).render(scene, 1),
                raster = Renderer(options_of(RenderMethod::raster)).render(scene, 1);
    for (const char* name : {"", "shadow"}) {
        const Difference d = difference(traced, raster, name);
        EXPECT_GT(d.mean, 0.1) << name;
        EXPECT_LE(d.rmse, 0.01 * d.mean) << name;
    }
    // Some of the image lies in the penumbra.
    const std::vector<float> visible = values(raster, "shadow");
    EXPECT_GT(std::ranges::count_if(visible, [](float v) { return v > 0.1f && v < 0.9f; }), 50);
}

// A smooth metal has no ray that shows the image: its lobe does.
TEST_F(RasterEnvironment, SmoothMetalShowsTheImage)
{
    SceneBuilder builder;
    builder.instance(builder.mesh({.positions = k_square, .indices = k_up}),
                     builder.material({.base_color = {1, 1, 1}, .metallic = 1, .roughness = 0}),
                     Transform::scaling(8, 1, 8));
    const std::vector<float> pixels(2 * 3, 0.5f);
    builder.environment({.width = 2, .height = 1, .pixels = pixels});
    Camera camera;
    camera.transform = Transform::look_at({0, 2, 4}, {0, 0, 0});
    camera.vertical_fov = 0.3;
    builder.camera(camera);
    const std::vector<float> image = values(Renderer(options_of(RenderMethod::raster)).render(builder.finish(), 1), "");
    for (const float value : image) EXPECT_NEAR(value, 0.5, 0.01);
}

// A frame after others, in which something moved or nothing did, is that of a renderer that has seen no other.
TEST_F(RasterEnvironment, FramesAfterOthersAreThoseOfANewRenderer)
{
    for (const Sky sky : {Sky::image, Sky::sun}) {
        InstanceId moving{};
        const Scene scene = boxes(sky, &moving, false);   // without transparency, surfaces at rest are kept
        const RenderOptions options = options_of(RenderMethod::raster);
        Renderer kept(options);
        std::uint64_t first = 0;
        for (const double x : {0.1, 0.4}) {
            FrameInput input;
            input.transforms = {{moving, Transform::translation(x, 1, 0) * Transform::scaling(0.7, 1, 0.7)}};
            const Frame frame = kept.render(scene, input), fresh = Renderer(options).render(scene, input);
            test::expect_same(frame, fresh);
            if (first == 0)
                first = frame.counters.shadow.rays;
            else
                EXPECT_LT(frame.counters.shadow.rays, first);
            if (x == 0.1) continue;
            // Where nothing moves any more, no ray is traced.
            kept.render(scene, input);
            const Frame again = kept.render(scene, input);
            EXPECT_EQ(again.counters.shadow.rays, 0u);
            test::expect_same(again, fresh);
        }
    }
}

}   // namespace
}   // namespace gnomon
#endif
