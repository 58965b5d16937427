// SPDX-License-Identifier: Apache-2.0
// The four methods of rasterised shadows [Oh and Shin 2004]: they render the same frames, as printed as well, what the
// texture's colour alone decides wrongly is counted, and textures are made for receivers in sight alone.
#include "vk_helpers.h"

#ifdef GNOMON_VULKAN
#include <cmath>

#include "gnomon/gnomon.h"
#include "support.h"

namespace gnomon {
namespace {

class ShadowMethods : public test::VulkanTest {};

constexpr ShadowTextures k_methods[] = {ShadowTextures::items, ShadowTextures::coherent, ShadowTextures::depth,
                                        ShadowTextures::per_caster};

RenderOptions options_of(ShadowTextures method, Size size, int filter, bool as_printed)
{
    RenderOptions options;
    options.renderer = RenderMethod::raster;
    options.size = size;
    options.indirect = Indirect::off;
    options.layers = true;
    options.exposure = 0.0;
    options.shadow_textures = method;
    options.shadow_filter = filter;
    options.as_printed = as_printed;
    return options;
}

const Layer& layer_of(const Frame& frame, const std::string& name)
{
    const Layer* const layer = frame.layer(name);
    if (!layer) throw std::runtime_error("no layer " + name);
    return *layer;
}

std::size_t values_different(const Frame& a, const Frame& b, const std::string& name)
{
    const auto x = layer_of(a, name).values(), y = layer_of(b, name).values();
    std::size_t different = x.size() == y.size() ? 0 : x.size();
    for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) different += x[i] != y[i];
    return different;
}

// Renders some frames in turn by every method, each by a renderer that keeps what it can, and compares them with those
// of items.
void expect_same_frames(const std::string& name, FrameRange frames, Size size, int filter, bool as_printed,
                        double least_shadowed)
{
    const Scene scene = load(name);
    std::vector<Renderer> renderers;
    for (const ShadowTextures method : k_methods) renderers.emplace_back(options_of(method, size, filter, as_printed));
    std::size_t dark = 0, all = 0;
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        const Frame items = renderers[0].render(scene, frame);
        for (const float lit : layer_of(items, "shadow").values()) dark += lit < 1, ++all;
        for (std::size_t m = 1; m < renderers.size(); ++m) {
            const Frame other = renderers[m].render(scene, frame);
            for (const char* layer : {"", "shadow"})
                EXPECT_EQ(values_different(items, other, layer), 0u)
                    << name << ", frame " << frame << ", method " << m << ", filter " << filter << ", layer '" << layer
                    << "'" << (as_printed ? ", as printed" : "");
            EXPECT_EQ(items.counters.shadow.looked_up, other.counters.shadow.looked_up);
            EXPECT_EQ(items.counters.shadow.looked_up_wrong, other.counters.shadow.looked_up_wrong);
        }
    }
    EXPECT_GT(static_cast<double>(dark), least_shadowed * static_cast<double>(all));
}

TEST_F(ShadowMethods, RenderTheSameFrames)
{
    expect_same_frames("builtin:cornell", {1, 3}, {96, 96}, 1, false, 0.1);
    expect_same_frames("builtin:cornell", {4, 4}, {96, 96}, 2, false, 0.1);
    expect_same_frames("builtin:cornell", {5, 5}, {96, 96}, 0, false, 0.1);
    expect_same_frames("builtin:spheres?objects=30&dynamic=20", {1, 3}, {96, 96}, 1, false, 0.1);
}

TEST_F(ShadowMethods, RenderTheSameFramesAsPrinted)
{
    expect_same_frames("builtin:cornell", {1, 2}, {96, 96}, 1, true, 0.1);
    expect_same_frames("builtin:spheres?objects=30&dynamic=20", {1, 2}, {96, 96}, 0, true, 0.1);
}

// Hard edges come from triangles: no texture is made for them.
TEST_F(ShadowMethods, NoTextureIsMadeThatNothingReads)
{
    const Scene scene = load("builtin:cornell");
    for (const ShadowTextures method : k_methods) {
        Renderer soft(options_of(method, {32, 32}, 1, false)), hard(options_of(method, {32, 32}, 0, false)),
            printed(options_of(method, {32, 32}, 0, true));
        const bool makes = method != ShadowTextures::items;
        EXPECT_EQ(soft.render(scene, 1).counters.shadow.textures > 0, makes);
        EXPECT_EQ(hard.render(scene, 1).counters.shadow.textures, 0u);
        EXPECT_EQ(printed.render(scene, 1).counters.shadow.textures > 0, makes);
    }
}

TEST_F(ShadowMethods, CoherentDrawsLessThanDepthWhileLittleMoves)
{
    const Scene scene = load("builtin:spheres?objects=30&dynamic=10");
    Renderer coherent(options_of(ShadowTextures::coherent, {64, 64}, 1, false)),
        depth(options_of(ShadowTextures::depth, {64, 64}, 1, false)),
        items(options_of(ShadowTextures::items, {64, 64}, 1, false));
    for (int frame = 1; frame <= 4; ++frame) {
        const auto c = coherent.render(scene, frame).counters, d = depth.render(scene, frame).counters,
                   i = items.render(scene, frame).counters;
        EXPECT_GT(d.shadow.textures, 0u);
        EXPECT_EQ(i.shadow.textures, 0u);
        if (frame < 3) continue;   // the first frames draw everything
        EXPECT_LT(c.shadow.textures, d.shadow.textures);
        EXPECT_GT(c.shadow.textures, 0u);
        EXPECT_LT(i.draws, c.draws);
        EXPECT_LT(c.draws, d.draws);
    }
}

// Counted on the device: at least the results of the layer `shadow` that differ. A surface beyond the light's cone, or
// whose shading normal faces away, is counted, too, although it has no light to lose.
TEST_F(ShadowMethods, ErrorsAsPrintedAreCounted)
{
    const Scene scene = load("builtin:cornell");
    const Size size{96, 96};
    const Frame compared = Renderer(options_of(ShadowTextures::depth, size, 1, false)).render(scene, 1),
                printed = Renderer(options_of(ShadowTextures::depth, size, 1, true)).render(scene, 1);
    EXPECT_FALSE(compared.counters.shadow.looked_up.has_value());
    const auto a = layer_of(compared, "shadow").values(), b = layer_of(printed, "shadow").values();
    std::uint64_t wrong = 0, same = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        wrong += (a[i] >= 0.5f) != (b[i] >= 0.5f);
        same += (a[i] >= 0.5f) == (b[i] >= 0.5f);
    }
    ASSERT_TRUE(printed.counters.shadow.looked_up_wrong.has_value());
    EXPECT_GT(wrong, 3u);
    EXPECT_GT(same, 20 * wrong);
    EXPECT_GE(*printed.counters.shadow.looked_up_wrong, wrong);
    EXPECT_LE(*printed.counters.shadow.looked_up_wrong, *printed.counters.shadow.looked_up);
    EXPECT_LE(*printed.counters.shadow.looked_up, static_cast<std::uint64_t>(size.width) * size.height);
}

// A single triangle that faces the light: its texture is white wherever it covers a texel's centre, so only its rim is
// decided wrongly.
TEST_F(ShadowMethods, OnlyTheRimOfALoneSurfaceIsWrongAsPrinted)
{
    SceneBuilder builder;
    const std::vector<Vec3> corners{{-1, 0, 1}, {1, 0, 1}, {0, 0, -1}};
    const MeshId mesh = builder.mesh({.positions = corners});
    builder.instance(mesh, builder.material({.double_sided = true}));
    builder.light({.color = {5, 5, 5}}, Transform::translation(0, 3, 0));
    const Scene scene = builder.finish({.default_camera = true});
    const Frame printed = Renderer(options_of(ShadowTextures::coherent, {96, 96}, 0, true)).render(scene, 1);
    ASSERT_TRUE(printed.counters.shadow.looked_up.has_value());
    EXPECT_GT(*printed.counters.shadow.looked_up, 1000u);
    EXPECT_LT(*printed.counters.shadow.looked_up_wrong, *printed.counters.shadow.looked_up / 50);
}

// The camera passes through the courtyard: objects come into sight, and their textures with them.
TEST_F(ShadowMethods, TexturesWaitUntilTheirReceiversAreInSight)
{
    const Scene scene = load("builtin:kinetic");
    const Size size{96, 54};
    RenderOptions with_textures = options_of(ShadowTextures::coherent, size, 1, false),
                  by_items = options_of(ShadowTextures::items, size, 1, false);
    with_textures.turntable_seconds = by_items.turntable_seconds = 0.25;
    Renderer coherent(with_textures), items(by_items);
    std::uint64_t waited = 0, came = 0, before = 0;
    for (int frame = 1; frame <= 4; ++frame) {
        const Frame a = coherent.render(scene, frame), b = items.render(scene, frame);
        EXPECT_EQ(values_different(a, b, ""), 0u) << "frame " << frame;
        waited += a.counters.shadow.textures_waiting;
        came += frame > 1 && a.counters.shadow.textures_waiting < before;
        before = a.counters.shadow.textures_waiting;
    }
    EXPECT_GT(waited, 0u);
    EXPECT_GT(came, 0u);
}

}   // namespace
}   // namespace gnomon
#endif
