// SPDX-License-Identifier: Apache-2.0
// Interrupting the work of a renderer at any time leaves it as if the frame had not been asked for; renderers in
// several threads do not disturb each other; misuse is refused.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "base/random.h"
#include "frame/frame_engine.h"
#include "gnomon/error.h"
#include "gnomon/renderer.h"
#include "scene/builtin/builtin.h"

namespace gnomon {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr int k_frames = 6;   // of a scene that are used

std::vector<std::vector<float>> layers_of(const Frame& frame)
{
    std::vector<std::vector<float>> layers;
    for (const Layer& layer : frame.layers) layers.push_back(layer.copy());
    return layers;
}

struct Case {
    const char* scene;
    RenderOptions options;
    int rounds = 18;
    int frames = k_frames;
};

std::vector<Case> cases()
{
    const RenderOptions usual{.size = {64, 48}, .threads = 4, .layers = true, .keep_image = false};
    std::vector<Case> all{{"builtin:kinetic", usual, 3, 2},
                          {"builtin:cornell", usual},
                          {"builtin:cornell", usual},
                          {"builtin:cornell", usual}};
    all[1].options.threads = 1;
    all[1].options.samples = 4;
    all[2].options.indirect = Indirect::quadtree;
    all[3].options.samples = k_adaptive_samples;
    all[3].options.shutter = 360;
    all[3].rounds = 6;
    return all;
}

// Renders a frame, and cancels it after a while from another thread.
bool is_cancelled(Renderer& renderer, const Scene& scene, int frame, Milliseconds after)
{
    std::atomic<bool> ended = false;
    std::thread canceller([&] {
        const Clock::time_point when = Clock::now() + std::chrono::duration_cast<Clock::duration>(after);
        while (!ended && Clock::now() < when) std::this_thread::sleep_for(std::chrono::microseconds(100));
        renderer.cancel();
    });
    bool cancelled = false;
    try {
        renderer.render(scene, frame);
    } catch (const InterruptedError&) {
        cancelled = true;
    }
    ended = true;
    canceller.join();
    return cancelled;
}

// Frames after cancelled ones have the bytes of a new renderer's frames. Every third renderer starts empty, so that the
// first frame, which builds everything, is cancelled as well.
TEST(Interruption, AFrameAfterCancelledOnesIsThatOfANewRenderer)
{
    int cancelled = 0, asked = 0;
    for (const Case& c : cases()) {
        const Scene scene = load(c.scene);
        std::vector<std::vector<std::vector<float>>> expected;
        double whole = 0;
        for (int frame = 1; frame <= c.frames; ++frame) {
            const Clock::time_point start = Clock::now();
            expected.push_back(layers_of(Renderer(c.options).render(scene, frame)));
            whole = std::max(whole, Milliseconds(Clock::now() - start).count());
        }
        Random random(7);
        Renderer renderer(c.options);
        double later = whole;   // milliseconds of a frame that is not the first
        for (int round = 0; round < c.rounds; ++round) {
            const bool empty = round % 3 == 0;
            if (empty) renderer = Renderer(c.options);
            for (int times = 1 + static_cast<int>(random.below(3)); times > 0; --times, ++asked)
                cancelled += is_cancelled(renderer, scene,
                                          1 + static_cast<int>(random.below(static_cast<std::uint32_t>(c.frames))),
                                          Milliseconds((empty ? whole : later) * random.uniform()));
            const int frame = 1 + static_cast<int>(random.below(static_cast<std::uint32_t>(c.frames)));
            const Clock::time_point start = Clock::now();
            ASSERT_EQ(layers_of(renderer.render(scene, frame)), expected[static_cast<std::size_t>(frame - 1)])
                << c.scene << " round " << round << " frame " << frame;
            if (!empty) later = Milliseconds(Clock::now() - start).count();
        }
    }
    // Whether a cancel comes before the frame ends depends on what else the machine does.
    EXPECT_GE(cancelled, asked / 4);
}

TEST(Interruption, WhatProgressThrowsLeavesRender)
{
    const Scene scene = load("builtin:cornell");
    const RenderOptions options{.size = {64, 48}, .keep_image = false};
    Renderer renderer(options), fresh(options);
    int calls = 0;
    const Progress throws = [&](const ProgressStep&) -> bool {
        if (++calls == 3) throw std::out_of_range("the host's own");
        return true;
    };
    EXPECT_THROW(renderer.render(scene, 1, throws), std::out_of_range);
    EXPECT_EQ(layers_of(renderer.render(scene, 2)), layers_of(fresh.render(scene, 2)));
}

TEST(Interruption, OfATracedFrameKeepsTheTrees)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    const RenderOptions options;
    frame::FrameEngine engine({.threads = 2});
    engine.advance(scene, 0, options);
    const ray::RayScene* const rays = &engine.rays();
    const auto stop = [](const ProgressStep& step) { return step.done < 0.5; };
    EXPECT_THROW(engine.render(engine.make_view(0, {128, 96}), {}, stop), InterruptedError);
    engine.advance(scene, 0.1, options);
    EXPECT_EQ(&engine.rays(), rays);
}

// A frame that is interrupted while light follows what moved costs the next one no more than what moved.
TEST(Interruption, WhileLightFollowsKeepsTheLight)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    const RenderOptions options;
    const Size size{128, 96};
    frame::FrameEngine engine({.threads = 2});
    engine.advance(scene, 0, options);
    const std::uint64_t all = engine.render(engine.make_view(0, size), {}).indirect.rays;
    const auto stop = [](const ProgressStep&) { return false; };
    for (int frame = 1; frame <= 5; ++frame) {
        engine.advance(scene, 0.04 * frame, options);
        EXPECT_THROW(engine.render(engine.make_view(0, size), {}, stop), InterruptedError);
        engine.advance(scene, 0.04 * frame, options);
        EXPECT_LT(engine.render(engine.make_view(0, size), {}).indirect.rays, all / 2) << "frame " << frame;
    }
}

TEST(Interruption, ACancelWithoutARenderHasNoEffect)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer({.size = {32, 24}});
    renderer.cancel();
    EXPECT_NO_THROW(renderer.render(scene, 1));
    renderer.cancel();
    EXPECT_NO_THROW(renderer.render(scene, 2));
}

TEST(Interruption, OfALoadAtAnyTime)
{
    const Clock::time_point begin = Clock::now();
    load("builtin:kinetic");
    const Milliseconds whole = Clock::now() - begin;
    Random random(3);
    int stopped = 0;
    for (int i = 0; i < 20; ++i) {
        const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(whole * random.uniform());
        try {
            load("builtin:kinetic",
                 {.progress = [&](const ProgressStep&) { return Clock::now() < end; }, .threads = 0});
        } catch (const InterruptedError&) {
            ++stopped;
        }
    }
    EXPECT_GT(stopped, 0);
}

TEST(Renderers, InSeveralThreadsOfOneSceneMakeTheSameBytes)
{
    const Scene scene = load("builtin:kinetic");
    RenderOptions options{.size = {64, 48}, .threads = 2, .layers = true, .keep_image = false};
    options.bounces = 1;   // patches of all of the scene take long
    std::vector<std::vector<std::vector<float>>> expected;
    Renderer alone(options);
    for (int frame = 1; frame <= k_frames; ++frame) expected.push_back(layers_of(alone.render(scene, frame)));

    // Each thread renders all frames with a renderer of its own, and cancels that of the next thread now and then.
    constexpr int k_threads = 3;
    std::vector<Renderer> renderers;
    for (int t = 0; t < k_threads; ++t) renderers.emplace_back(options);
    std::atomic<int> different = 0, cancelled = 0, done = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < k_threads; ++t)
        threads.emplace_back([&, t] {
            const auto at = static_cast<std::size_t>(t);
            for (int turn = 0; turn < 2 * k_frames; ++turn) {
                const int frame = 1 + (turn + t) % k_frames;
                if (turn % 3 == t % 3) renderers[(at + 1) % k_threads].cancel();
                try {
                    different +=
                        layers_of(renderers[at].render(scene, frame)) != expected[static_cast<std::size_t>(frame - 1)];
                    ++done;
                } catch (const InterruptedError&) {
                    ++cancelled;
                }
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(different, 0);
    EXPECT_GT(done, 0);
    EXPECT_GT(cancelled, 0);
    EXPECT_EQ(done + cancelled, 2 * k_frames * k_threads);
}

std::string refusal(const std::function<void()>& call)
{
    try {
        call();
    } catch (const UsageError& error) {
        return error.what();
    }
    return {};
}

TEST(Renderers, RefuseASecondRenderAtTheSameTime)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer({.size = {64, 48}});
    std::string from_callback, from_thread, device;
    const Progress asks = [&](const ProgressStep&) {
        if (!from_thread.empty()) return true;
        from_callback = refusal([&] { renderer.render(scene, 1); });
        std::thread([&] { from_thread = refusal([&] { renderer.render(scene, 1); }); }).join();
        device = refusal([&] { renderer.device(); });
        return true;
    };
    EXPECT_NO_THROW(renderer.render(scene, 1, asks));
    EXPECT_NE(from_callback.find("is rendering already"), std::string::npos) << from_callback;
    EXPECT_EQ(from_callback, from_thread);
    EXPECT_EQ(from_callback, device);
    EXPECT_EQ(from_callback.find('\n'), std::string::npos);
    // The refusal leaves through the callback that does not catch it.
    EXPECT_NE(refusal([&] {
                  renderer.render(scene, 2,
                                  [&](const ProgressStep&) { return renderer.render(scene, 1).size.width > 0; });
              }),
              "");
    EXPECT_NO_THROW(renderer.render(scene, 3));
}

TEST(Renderers, RefuseEverythingOnceMovedFrom)
{
    const Scene scene = load("builtin:cornell");
    Renderer renderer({.size = {32, 24}});
    const Renderer taken = std::move(renderer);
    EXPECT_NE(refusal([&] { renderer.render(scene, 1); }), "");   // NOLINT(bugprone-use-after-move): what is tested
    EXPECT_NE(refusal([&] { renderer.cancel(); }), "");
    EXPECT_NE(refusal([&] { renderer.device(); }), "");
    EXPECT_NE(refusal([&] { renderer.options(); }), "");
    renderer = Renderer({.size = {32, 24}});
    EXPECT_NO_THROW(renderer.render(scene, 1));
}

}   // namespace
}   // namespace gnomon
