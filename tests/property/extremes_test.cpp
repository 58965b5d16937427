// SPDX-License-Identifier: Apache-2.0
// Scenes from a tenth of a millimetre to a thousand kilometres, at the origin and far from it: certified culling is
// exact, updated light views equal redrawn ones, and all layers of all images are finite.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "aff_files.h"
#include "api/scene_access.h"
#include "gnomon/gnomon.h"
#include "light_views/light_views.h"
#include "light_views/software.h"
#include "scene/state.h"

namespace gnomon {
namespace {

constexpr int k_frames = 8;

// The same room at any size and place: a floor, a wall, a mirror, glass, a column, a flying ball, a slab that rotates
// and rests for a while; one light above and one between the objects.
std::string room(double size, double offset)
{
    const auto at = [&](double x, double y, double z) {
        return fmt::format(" {:.9g} {:.9g} {:.9g}", size * (x + offset), size * y, size * (z - offset));
    };
    const auto by = [&](double x, double y, double z) {
        return fmt::format(" {:.9g} {:.9g} {:.9g}", size * x, size * y, size * z);
    };
    std::string text = fmt::format("v from{} at{} up 0 1 0 angle 45 hither {:.9g} resolution 48 36\n", at(.5, 2, 7),
                                   at(0, .5, 0), std::max(size * .01, 1e-4));   // less means 1 in AFF
    text += fmt::format("b .1 .2 .3\na 0 7 {}\nl{} .8 .8 .7\nl{} .2 .3 .4\n", k_frames, at(3, 5, 3), at(-1.5, 1, 1));
    text += "f .8 .7 .6 .9 .05 8 0 1\np 4" + at(-4, 0, -4) + at(-4, 0, 4) + at(4, 0, 4) + at(4, 0, -4) + "\n";
    text += "f .4 .6 .8 .9 0 8 0 1\np 4" + at(-4, 0, -4) + at(4, 0, -4) + at(4, 4, -4) + at(-4, 4, -4) + "\n";
    text += fmt::format("c{} {:.9g}{} {:.9g}\n", at(2, 0, -1), size * .4, at(2, 2, -1), size * .2);
    text += "fm .05 .05 .05 .1 .1 .1 .9 .9 .9 50 0 1\n";
    text += fmt::format("s{} {:.9g}\n", at(-2, .8, -1), size * .8);
    text += "fm 0 0 0 .1 .1 .1 .1 .1 .1 20 .8 1.5\n";
    text += fmt::format("s{} {:.9g}\nf .8 .2 .2 .9 .1 8 0 1\nx ball {{ s{} {:.9g} }}\nx slab {{\n", at(.6, .5, 1.5),
                        size * .5, at(0, 1.5, 0), size * .3);
    text += "p 4" + at(-1, 1, .4) + at(1, 1, .4) + at(1, 1, -.4) + at(-1, 1, -.4) + " }\n";
    text += "k ball { transl 4 0" + by(0, 0, 0) + " 0 0 0 2" + by(.5, .4, .5) + " 0 0 0 5" + by(-.8, .2, 1) +
            " 0 0 0 7" + by(0, 0, 0) + " 0 0 0 }\n";
    text += "k slab { transl 4 0" + by(0, 0, 0) + " 0 0 0 2" + by(0, .3, 0) + " 0 0 0 3" + by(0, .3, 0) + " 0 0 0 7" +
            by(.4, 0, 0) + " 0 0 0 }\n";
    return text;
}

struct World {
    double size, offset;   // the size of a unit; the distance from the origin in units
};

constexpr World k_worlds[] = {{1, 0},    {1e-4, 0}, {1e-2, 0},    {1e2, 0},   {1e4, 0},    {1e6, 0},
                              {1, 1000}, {1, 1e5},  {1e-4, 1000}, {1e6, 500}, {1e-4, 1e5}, {1e6, 1e5}};

class Extremes : public testing::TestWithParam<World> {
 protected:
    Scene scene() const
    {
        folder_.write(folder_.main(), room(GetParam().size, GetParam().offset));
        return load(folder_.main().string());
    }

    test::AffFolder folder_;
};

std::vector<Frame> frames_of(const Scene& scene, RenderOptions options)
{
    options.threads = 2;
    options.layers = true;
    Renderer renderer(options);
    std::vector<Frame> images;
    for (int frame = 1; frame <= scene.frame_count(); ++frame) images.push_back(renderer.render(scene, frame));
    return images;
}

void expect_finite(const Frame& image, const std::string& what)
{
    for (const Layer& layer : image.layers) {
        std::size_t bad = 0;
        for (const float value : layer.values()) bad += !std::isfinite(value);
        EXPECT_EQ(bad, 0u) << what << ", layer " << layer.name << ", frame " << image.frame;
    }
}

TEST_P(Extremes, CertifiedCullingIsExactAndLayersAreFinite)
{
    const Scene scene = this->scene();
    ASSERT_EQ(scene.frame_count(), k_frames);
    RenderOptions options;
    options.keep_image = false;
    const std::vector<Frame> remembered = frames_of(scene, options);
    options.shadow_culling = ShadowCulling::off;
    const std::vector<Frame> traced = frames_of(scene, options);
    std::uint64_t skipped = 0, rays = 0;
    for (std::size_t i = 0; i < remembered.size(); ++i) {
        ASSERT_EQ(remembered[i].layers.size(), traced[i].layers.size());
        for (std::size_t l = 0; l < traced[i].layers.size(); ++l)
            EXPECT_TRUE(remembered[i].layers[l].copy() == traced[i].layers[l].copy())
                << "layer " << traced[i].layers[l].name << ", frame " << i + 1;
        expect_finite(remembered[i], "remembered");
        skipped += remembered[i].counters.shadow.rays_skipped;
        rays += remembered[i].counters.shadow.rays;
    }
    // Up to 1e9 units rays hit everything; beyond, nothing.
    EXPECT_TRUE(rays > 10'000 || GetParam().size * GetParam().offset > 9e8);
    std::printf("%llu of %llu shadow rays left out\n", static_cast<unsigned long long>(skipped),
                static_cast<unsigned long long>(rays));
    // Most rays are left out, wherever floats are fine enough for proofs.
    if (GetParam().offset <= 1000)
        EXPECT_GT(skipped, rays / 2);
    else
        EXPECT_LE(skipped, rays / 2);
    // AFF's lights have no distance falloff: at the origin the room looks the same at every size.
    if (GetParam().offset != 0) return;
    folder_.write(folder_.main(), room(1, 0));
    const std::vector<float> as_it_is = frames_of(load(folder_.main().string()), {})[0].layers[0].copy();
    const std::vector<float> here = remembered[0].layers[0].copy();
    double difference = 0, mean = 0;
    for (std::size_t i = 0; i < here.size(); ++i) {
        difference += std::abs(static_cast<double>(here[i]) - static_cast<double>(as_it_is[i]));
        mean += static_cast<double>(as_it_is[i]);
    }
    EXPECT_LT(difference / mean, 0.03);   // cache points lie on lattices with power-of-two spacing
}

TEST_P(Extremes, IndirectLightHasSameBytesForAnyThreadCountColdAndWarm)
{
    const Scene scene = this->scene();
    const auto bounced = [&](int threads, std::initializer_list<int> frames) {
        RenderOptions options;
        // Where floats are coarse, rays pass objects within rounding: enough rays are needed for some to do so.
        options.size = GetParam().offset > 1e4 ? Size{320, 240} : Size{96, 72};
        options.threads = threads;
        options.layers = true;
        Renderer renderer(options);
        Frame last;
        for (const int frame : frames) last = renderer.render(scene, frame);
        for (const Layer& layer : last.layers)
            if (layer.name == "indirect") return layer.copy();
        ADD_FAILURE() << "layer not found";
        return std::vector<float>();
    };
    const std::vector<float> one = bounced(1, {5});
    for (int round = 0; round < 3; ++round) EXPECT_TRUE(one == bounced(4, {5})) << "round " << round;
    EXPECT_TRUE(one == bounced(2, {8, 1, 5}));
}

TEST_P(Extremes, EveryIndirectMethodStaysFinite)
{
    const Scene scene = this->scene();
    for (const Indirect indirect : {Indirect::visible, Indirect::quadtree, Indirect::rsm}) {
        RenderOptions options;
        options.threads = 2;
        options.layers = true;
        options.indirect = indirect;
        Renderer renderer(options);
        for (const int frame : {1, 3}) expect_finite(renderer.render(scene, frame), "indirect");
    }
    RenderOptions reference;
    reference.size = {16, 12};
    reference.layers = true;
    reference.reference = ReferenceLightOptions{.spp = 4, .bounces = 2};
    expect_finite(Renderer(reference).render(scene, 2), "reference");
}

TEST_P(Extremes, LightViewsEqualAFullRedraw)
{
    const auto scene = api::scene_of(this->scene());
    scene::SceneState state(scene, scene->timeline.time_of(1));
    light_views::LightViewsOptions options;
    options.atlas.view_size = 64;
    options.quiet_frames = 2;
    light_views::LightViews views(state, options);
    std::vector<light_views::SoftwareView> buffers;
    for (const light_views::LightView& view : views.views()) buffers.emplace_back(view.tile.size);
    int shown = 0;
    for (int frame = 1; frame <= k_frames; ++frame) {
        state.advance(scene->timeline.time_of(frame));
        views.update(state);
        for (std::size_t v = 0; v < buffers.size(); ++v) {
            const light_views::LightView& view = views.views()[v];
            if (!view.shown) continue;
            ++shown;
            buffers[v].execute(view.plan, view.projection, state);
            light_views::SoftwareBuffer redrawn(view.tile.size);
            for (scene::ObjectId o = 0; o < scene->objects.size(); ++o)
                if (views.casters().casts(o) && state.object_visible(o))
                    draw_object(redrawn, view.projection, state, o, view.projection.whole());
            EXPECT_TRUE(buffers[v].rendering().depth == redrawn.depth) << "view " << v << ", frame " << frame;
            EXPECT_TRUE(buffers[v].rendering().item == redrawn.item) << "view " << v << ", frame " << frame;
        }
    }
    EXPECT_GT(shown, 0);
}

INSTANTIATE_TEST_SUITE_P(Worlds, Extremes, testing::ValuesIn(k_worlds), [](const auto& chosen) {
    std::string name = fmt::format("Size{:g}Offset{:g}", chosen.param.size, chosen.param.offset);
    for (char& c : name)
        if (c == '-') c = 'm';
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

}   // namespace
}   // namespace gnomon
