// SPDX-License-Identifier: Apache-2.0
// A long-lived frame engine whose options, times and values of a host change makes the same images as a new engine each
// time.
#include "frame/frame_engine.h"

#include <gtest/gtest.h>

#include "api/scene_access.h"
#include "base/bits.h"
#include "base/random.h"
#include "gnomon/scene.h"
#include "scene/builtin/builtin.h"

namespace gnomon {
namespace {

using frame::FrameEngine;
using frame::HostValues;
using frame::Shown;

constexpr Size k_size{40, 32};

struct Case {
    RenderOptions options;
    bool compared = true;   // not an overlay of a cache, nor the culling that depends on history
};

// Every technique, at least once with each of its own options changed.
std::vector<Case> traced_cases()
{
    std::vector<Case> cases;
    const auto add = [&](const auto& change, bool compared = true) {
        Case& c = cases.emplace_back();
        change(c.options);
        c.compared = compared;
    };
    add([](RenderOptions&) {});
    add([](RenderOptions& o) { o.layers = true; });
    add([](RenderOptions& o) { o.samples = 2; });
    add([](RenderOptions& o) { o.max_depth = 0; });
    add([](RenderOptions& o) { o.shadow_culling = ShadowCulling::off; });
    add([](RenderOptions& o) { o.shadow_culling = ShadowCulling::paper; }, false);
    add([](RenderOptions& o) { o.indirect_memory = 1; });
    add([](RenderOptions& o) { o.indirect = Indirect::off; });
    add([](RenderOptions& o) { o.indirect = Indirect::rsm; });
    add([](RenderOptions& o) { o.indirect = Indirect::rsm, o.rsm_samples = 40; });
    add([](RenderOptions& o) { o.indirect = Indirect::quadtree; });
    add([](RenderOptions& o) { o.indirect = Indirect::quadtree, o.indirect_level = 4; });
    add([](RenderOptions& o) { o.indirect = Indirect::quadtree, o.indirect_at_every_pixel = true; });
    add([](RenderOptions& o) { o.reference = ReferenceLightOptions{.spp = 4}; });
    add([](RenderOptions& o) { o.overlay = Overlay::shadow_states; }, false);
    add([](RenderOptions& o) { o.indirect = Indirect::quadtree, o.overlay = Overlay::clusters; });
    add([](RenderOptions& o) { o.accelerator = Accelerator::kdtree; });
    return cases;
}

struct Rendered {
    std::vector<float> color, indirect;
    std::vector<std::uint8_t> overlay;
};

Rendered render(FrameEngine& engine, const std::shared_ptr<const scene::Scene>& scene, double time,
                const RenderOptions& options, HostValues* host = nullptr)
{
    engine.advance(scene, time, options, host);
    engine.render(engine.make_view(0, k_size), {.overlay_lights = {0}});
    if (host) host->end_frame();
    Rendered result;
    if (engine.shown() == Shown::shadow_states || engine.shown() == Shown::clusters) {
        result.overlay = engine.paint_overlay({"light 0"}).data;
        return result;
    }
    result.color = engine.buffers().color.data;
    if (options.layers && engine.has_indirect()) result.indirect = engine.buffers().indirect.data;
    return result;
}

// Balls, some of which move, under an environment image.
std::shared_ptr<const scene::Scene> under_a_studio(int moving)
{
    return api::scene_of(
        load("builtin:spheres?objects=20&dynamic=" + std::to_string(moving)).with_environment("builtin:studio"));
}

// Renders `steps` random cases at random times by one engine, and each of them by an engine of its own.
void compare_with_new_engines(const std::vector<Case>& cases, int steps, std::uint64_t seed)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    Random random(seed);
    FrameEngine kept({.threads = 2, .culls_first_frame = true});
    for (int step = 0; step < steps; ++step) {
        const auto count = static_cast<std::uint32_t>(cases.size());
        const std::size_t which =
            static_cast<std::uint32_t>(step) < count ? static_cast<std::size_t>(step) : random.below(count);
        const Case& c = cases[which];
        const double time = scene->timeline.time_of(1 + static_cast<int>(random.below(12)));
        const Rendered now = render(kept, scene, time, c.options);
        if (!c.compared) continue;
        FrameEngine fresh({.threads = 1});
        const Rendered expected = render(fresh, scene, time, c.options);
        EXPECT_TRUE(same_bits(now.color, expected.color)) << "step " << step << ", case " << which;
        EXPECT_TRUE(same_bits(now.indirect, expected.indirect)) << "step " << step << ", case " << which;
        EXPECT_EQ(now.overlay, expected.overlay) << "step " << step << ", case " << which;
    }
}

TEST(FrameEngine, SameBytesSwitchedThroughAllTracedOptionsAsNew)
{
    compare_with_new_engines(traced_cases(), 36, 1);
}

#ifdef GNOMON_VULKAN
TEST(FrameEngine, SameBytesSwitchedBetweenTraceAndRasterAsNew)
{
    std::vector<Case> cases;
    for (const Indirect indirect : {Indirect::off, Indirect::quadtree, Indirect::visible})
        for (const RenderMethod method : {RenderMethod::raster, RenderMethod::trace}) {
            Case& c = cases.emplace_back();
            c.options.renderer = method;
            c.options.indirect = indirect;
        }
    Case& hard = cases.emplace_back();
    hard.options.renderer = RenderMethod::raster;
    hard.options.indirect = Indirect::off;
    hard.options.shadow_filter = 0;
    Case& redrawn = cases.emplace_back(hard);
    redrawn.options.overlay = Overlay::redrawn;
    redrawn.compared = false;
    compare_with_new_engines(cases, 11, 2);
}
#endif

// Values that differ by more than rounding.
int different(const std::vector<float>& a, const std::vector<float>& b)
{
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += std::abs(a[i] - b[i]) > 1e-3f;
    return count;
}

TEST(FrameEngine, TransformsOfAHostTakeEffectAndAreReleased)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    RenderOptions options;
    options.indirect = Indirect::off;
    scene::NodeId node = scene::none;
    for (const scene::Object& object : scene->objects)
        if (!object.dynamic) node = object.node;
    ASSERT_NE(node, scene::none);
    FrameEngine engine({.threads = 1});
    const Rendered before = render(engine, scene, 0, options);

    // Raise a static object. The values then declare it dynamic, in a scene of their own.
    HostValues host(scene);
    glm::dmat4 raised = scene->nodes[node].local;
    raised[3] += glm::dvec4(0, 0.3, 0, 0);
    host.set_transform(node, &raised);
    host.settle();
    ASSERT_NE(host.scene(), scene);
    const Rendered moved = render(engine, host.scene(), 0, options, &host);
    EXPECT_GT(different(moved.color, before.color), 100);
    FrameEngine fresh({.threads = 1});
    EXPECT_TRUE(same_bits(render(fresh, host.scene(), 0, options, &host).color, moved.color));

    // A promoted object keeps an instance of its own, so that its vertices are rounded differently.
    host.set_transform(node, nullptr);
    host.settle();
    EXPECT_LT(different(render(engine, host.scene(), 0, options, &host).color, before.color), 20);
}

TEST(FrameEngine, RendersAfterAnInterruptedFrame)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    for (const Indirect indirect : {Indirect::off, Indirect::quadtree, Indirect::visible}) {
        RenderOptions options;
        options.indirect = indirect;
        FrameEngine engine({.threads = 1}), fresh({.threads = 1});
        engine.advance(scene, 0, options);
        EXPECT_THROW(engine.render(engine.make_view(0, k_size), {}, [](const ProgressStep&) { return false; }),
                     InterruptedError);
        const double later = scene->timeline.time_of(3);
        EXPECT_TRUE(same_bits(render(engine, scene, later, options).color, render(fresh, scene, later, options).color));
    }
}

TEST(FrameEngine, FollowsAnAdvanceThatWasNotRendered)
{
    const RenderOptions options;
    for (const auto& scene :
         {std::make_shared<const scene::Scene>(scene::make_builtin("cornell")), under_a_studio(5)}) {
        FrameEngine engine({.threads = 1, .culls_first_frame = true}), fresh({.threads = 1});
        for (const int frame : {1, 2, 3}) render(engine, scene, scene->timeline.time_of(frame), options);
        const double missed = scene->timeline.time_of(20);
        for (const double time : {scene->timeline.time_of(4), missed}) {
            for (int again = 0; again < 2; ++again) engine.advance(scene, missed, options);
            EXPECT_TRUE(
                same_bits(render(engine, scene, time, options).color, render(fresh, scene, time, options).color));
        }
    }
}

// An advance that changes nothing, as of a frame that was interrupted before it was rendered, forgets no rays.
TEST(FrameEngine, KeepsWhatIsSeenOfAnEnvironmentAfterAnAdvanceThatChangedNothing)
{
    const auto scene = under_a_studio(0);
    const RenderOptions options{.indirect = Indirect::off, .keep_image = false};
    FrameEngine engine({.threads = 1});
    const auto rays = [&] {
        engine.advance(scene, 0, options);
        return engine.render(engine.make_view(0, k_size), {}).shadow.rays;
    };
    const std::uint64_t first = rays();
    rays();
    const std::uint64_t again = rays();   // what mirrors show
    EXPECT_LT(20 * again, first);
    engine.advance(scene, 0, options);
    EXPECT_EQ(rays(), again);
}

// Where rays are limited, pixels without points begin with roughly what they get in the end: not with what a surface
// gets directly from an image or from emission, too, and not without what it gets from a sky.
TEST(FrameEngine, RoughLightIsThatOfPixels)
{
    const Scene balls = load("builtin:spheres?objects=20&dynamic=0");
    for (const Scene& scene : {load("builtin:cornell"), balls, balls.with_environment("builtin:studio")}) {
        const RenderOptions options{.size = {64, 48}, .layers = true, .interactive = true};
        const auto mean = [&](std::uint64_t limit) {
            FrameInput input;
            input.indirect_ray_limit = limit;
            const Frame frame = Renderer(options).render(scene, input);
            EXPECT_EQ(frame.complete, limit == 0);
            const std::vector<float> light = frame.layer("indirect")->copy();
            double sum = 0;
            for (const float value : light) sum += static_cast<double>(value);
            return sum / static_cast<double>(light.size());
        };
        const double rough = mean(1), whole = mean(0);
        EXPECT_GT(whole, 0);
        EXPECT_GT(rough, 0.6 * whole);
        EXPECT_LT(rough, 1.5 * whole);
    }
}

}   // namespace
}   // namespace gnomon
