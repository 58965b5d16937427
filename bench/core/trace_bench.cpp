// SPDX-License-Identifier: Apache-2.0
#include "bench/core/trace_bench.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include "base/check.h"
#include "frame/frame_engine.h"

namespace gnomon::bench {

namespace {

double milliseconds_of(const std::function<void()>& work)
{
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

}   // namespace

TraceBenchResult bench_trace(const std::shared_ptr<const scene::Scene>& scene, const TraceBenchOptions& options)
{
    const scene::Timeline& timeline = scene->timeline;
    const double time = timeline.time_of(options.frame);
    RenderOptions render;
    render.max_depth = options.max_depth;
    render.shadow_culling = ShadowCulling::off;
    render.indirect = Indirect::off;
    render.arithmetic = options.arithmetic;
    render.keep_image = false;   // the same frame is timed again and again
    frame::FrameEngine engine({.threads = options.threads});
    engine.advance(scene, time, render);

    TraceBenchResult result;
    result.build_ms = engine.rays().statistics().build_ms;
    result.bytes = engine.rays().statistics().bytes;
    const scene::View view = engine.make_view(options.camera, options.size);
    Tasks one(1);
    const auto frame_ms = [&](const frame::RenderRequest& request) {
        engine.advance(scene, time, render);
        return milliseconds_of([&] { engine.render(view, request); });
    };

    // Record the frame's rays once.
    trace::TraceLog log;
    frame_ms({.tasks = &one, .log = &log});
    result.rays = log.rays();

    // Time the frame and the bare loop in turn, so that a drift of the machine's speed affects both.
    std::vector<double> frame, single, bare, ratios;
    std::uint64_t sink = 0;
    for (int i = 0; i < options.repeats; ++i) {
        single.push_back(frame_ms({.tasks = &one}));
        bare.push_back(milliseconds_of([&] { sink += log.replay(engine.rays()); }));
        frame.push_back(frame_ms({}));
        ratios.push_back(single.back() / bare.back());
    }
    GNOMON_CHECK(sink != 1);   // keeps the replay from being optimised away
    result.frame_ms = median(frame);
    result.one_thread_ms = median(single);
    result.bare_ms = median(bare);
    result.ratio = median(ratios);

    // Step through a few frames to time the update.
    if (timeline.frames > 1) {
        std::vector<double> updates;
        for (int i = 0; i < 2 * options.repeats; ++i) {
            const int next = (options.frame + i) % timeline.frames + 1;
            updates.push_back(milliseconds_of([&] { engine.advance(scene, timeline.time_of(next), render); }));
        }
        result.update_ms = median(updates);
    }
    return result;
}

}   // namespace gnomon::bench
