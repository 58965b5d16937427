// SPDX-License-Identifier: Apache-2.0
// The traced frame with the published shadow culling: the same for any number of threads, its faults counted to the
// last one and marked, its memory its history.
#include <gtest/gtest.h>

#include "base/hash.h"
#include "gnomon/gnomon.h"
#include "ray/ray_scene.h"
#include "scene/builtin/builtin.h"
#include "shadow_culling/nah2009/paper_culling.h"
#include "support.h"
#include "trace/checked_shadows.h"
#include "trace/traced_frame.h"

namespace gnomon {
namespace {

struct Clip {
    std::vector<std::vector<float>> color, shadow;   // by frame
    std::vector<FrameCounters> counters;
};

Clip render(const Scene& scene, FrameRange frames, RenderOptions options)
{
    Renderer renderer(std::move(options));
    Clip clip;
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        const Frame image = renderer.render(scene, frame);
        clip.color.push_back(image.layers[0].copy());
        if (const Layer* layer = image.layer("shadow")) clip.shadow.push_back(layer->copy());
        clip.counters.push_back(image.counters);
    }
    return clip;
}

RenderOptions options_of(ShadowCulling culling)
{
    RenderOptions options;
    options.size = {160, 120};
    options.threads = 1;
    options.shadow_culling = culling;
    options.indirect = Indirect::off;   // it casts no shadow rays that are culled, and takes most of the time
    return options;
}

TEST(PaperFrame, SameForAnyThreadCount)
{
    for (const char* name : {"builtin:cornell", "builtin:kinetic", "builtin:spheres?objects=60&dynamic=20"}) {
        SCOPED_TRACE(name);
        const Scene scene = load(name);
        RenderOptions options = options_of(ShadowCulling::paper);
        const Clip one = render(scene, {3, 9}, options);
        std::uint64_t saved = 0;
        for (const int threads : {2, 5}) {
            options.threads = threads;
            const Clip many = render(scene, {3, 9}, options);
            EXPECT_EQ(one.color, many.color);
            for (std::size_t f = 0; f < one.counters.size(); ++f) {
                const FrameCounters::Shadow &a = one.counters[f].shadow, &b = many.counters[f].shadow;
                EXPECT_EQ(a.rays, b.rays);
                EXPECT_EQ(a.rays_skipped, b.rays_skipped);
                EXPECT_EQ(a.rays_dynamic_only, b.rays_dynamic_only);
                saved += a.rays_skipped + a.rays_dynamic_only;
            }
        }
        if (std::string(name) != "builtin:spheres?objects=60&dynamic=20") {
            EXPECT_GT(saved, 0u);
        }
    }
}

TEST(PaperFrame, FirstFrameIsAFullTraceWithTheSameShadowRays)
{
    const Scene scene = load("builtin:kinetic");
    const Clip off = render(scene, {40, 43}, options_of(ShadowCulling::off));
    const Clip paper = render(scene, {40, 43}, options_of(ShadowCulling::paper));
    EXPECT_EQ(off.color[0], paper.color[0]);
    EXPECT_EQ(paper.counters[0].shadow.rays_skipped + paper.counters[0].shadow.rays_dynamic_only, 0u);
    for (std::size_t f = 0; f < 4; ++f) {
        EXPECT_EQ(off.counters[f].shadow.rays, paper.counters[f].shadow.rays) << "frame " << f;
        EXPECT_FALSE(paper.counters[f].shadow.rays_wrong.has_value()) << "nobody asked";
        if (f > 0) {
            EXPECT_GT(paper.counters[f].shadow.rays_skipped, 0u);
        }
    }
}

// At primary hits alone, the shadow layer holds every answer: what differs from a full trace is what is counted.
TEST(PaperFrame, CountsEveryWrongShadow)
{
    const Scene scene = load("builtin:kinetic");
    RenderOptions options = options_of(ShadowCulling::off);
    options.max_depth = 0;
    options.layers = true;
    const Clip off = render(scene, {40, 45}, options);
    options.shadow_culling = ShadowCulling::paper;
    const Clip paper = render(scene, {40, 45}, options);
    options.overlay = Overlay::shadow_states;
    const Clip shown = render(scene, {40, 45}, options);
    std::uint64_t total = 0;
    for (std::size_t f = 0; f < off.shadow.size(); ++f) {
        std::uint64_t different = 0;
        for (std::size_t i = 0; i < off.shadow[f].size(); ++i) different += off.shadow[f][i] != paper.shadow[f][i];
        EXPECT_EQ(shown.counters[f].shadow.rays_wrong, different) << "frame " << f;
        EXPECT_EQ(shown.counters[f].shadow.rays_skipped, paper.counters[f].shadow.rays_skipped);
        total += different;
    }
    EXPECT_GT(total, 20u) << "else nothing was put to the test";
}

// With mirrors, glass and several samples: where no light is marked wrong, the pixel is that of a full trace, to the
// bit.
TEST(PaperFrame, MarksEveryWrongPixel)
{
    const auto scene = std::make_shared<scene::Scene>(scene::make_kinetic());
    scene::SceneState state(scene, scene->timeline.time_of(50));
    ray::RayScene rays(state);
    shadow_culling::PaperCulling paper(state, rays);
    trace::StateMap states;
    for (int l = 0; l < static_cast<int>(scene->lights.size()); ++l) states.lights.push_back(l);
    Tasks tasks(2);
    trace::TracedOptions options;
    options.samples = 2;
    options.lobe_rays = 0;   // pixels share what the rays of their lobes find
    std::uint64_t wrong_pixels = 0, behind = 0;
    for (int frame = 50; frame < 55; ++frame) {
        state.advance(scene->timeline.time_of(frame));
        rays.update(state);
        const scene::View view = scene::make_view(state, 0, {150, 110});
        shading::FrameBuffers culled, plain;
        trace::NahShadows shadows(paper);
        trace::CheckedShadows checked(shadows, states);
        const FrameCounters counters = trace::trace_frame(state, rays, view, options, tasks, culled, {&checked});
        trace::trace_frame(state, rays, view, options, tasks, plain);
        std::uint64_t different = 0;
        for (int y = 0; y < view.size.height; ++y)
            for (int x = 0; x < view.size.width; ++x) {
                bool marked = false;
                for (std::size_t l = 0; l < states.lights.size(); ++l) {
                    const trace::StateCell cell = states.cell(l, x, y);
                    marked = marked || cell.wrong || cell.wrong_behind;
                    behind += cell.wrong_behind;
                }
                const bool differs =
                    !std::equal(plain.color.pixel(x, y), plain.color.pixel(x, y) + 3, culled.color.pixel(x, y));
                EXPECT_TRUE(marked || !differs) << "frame " << frame << " pixel " << x << ", " << y;
                different += differs;
            }
        EXPECT_LE(different, *counters.shadow.rays_wrong);
        wrong_pixels += different;
    }
    EXPECT_GT(wrong_pixels, 20u) << "else nothing was put to the test";
    EXPECT_GT(behind, 0u);
}

TEST(PaperFrame, CertifiedCullingPassesTheSameCheck)
{
    const Scene scene = load("builtin:kinetic");
    RenderOptions options = options_of(ShadowCulling::certified);
    options.overlay = Overlay::shadow_states;
    const Clip shown = render(scene, {40, 45}, options);
    for (const FrameCounters& counters : shown.counters) EXPECT_EQ(counters.shadow.rays_wrong, 0u);
    EXPECT_GT(shown.counters.back().shadow.rays_skipped, 0u);
}

// An overlay changes nothing of what it shows.
TEST(PaperFrame, DependsOnEarlierFramesAndNotOnTheOverlay)
{
    const Scene scene = load("builtin:kinetic");
    const Clip all = render(scene, {40, 45}, options_of(ShadowCulling::paper));
    const Clip late = render(scene, {44, 45}, options_of(ShadowCulling::paper));
    const Clip again = render(scene, {40, 45}, options_of(ShadowCulling::paper));
    EXPECT_EQ(all.color, again.color);
    EXPECT_NE(all.color[4], late.color[0]) << "a memory that begins late says something else";
    RenderOptions options = options_of(ShadowCulling::paper);
    options.overlay = Overlay::shadow_states;
    const Clip shown = render(scene, {40, 45}, options);
    for (std::size_t f = 0; f < 6; ++f)
        EXPECT_EQ(all.counters[f].shadow.rays_skipped, shown.counters[f].shadow.rays_skipped);
}

TEST(PaperFrame, InterruptedFrameLeavesNoTrace)
{
    const Scene scene = load("builtin:kinetic");
    Renderer stopped(options_of(ShadowCulling::paper)), fresh(options_of(ShadowCulling::paper));
    stopped.render(scene, 40);
    EXPECT_THROW(stopped.render(scene, 41, [](const ProgressStep& step) { return step.done < 0.3; }), InterruptedError);
    EXPECT_EQ(stopped.render(scene, 42).layers[0].copy(), fresh.render(scene, 42).layers[0].copy());
}

}   // namespace
}   // namespace gnomon
