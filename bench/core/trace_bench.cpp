// SPDX-License-Identifier: Apache-2.0
#include "bench/core/trace_bench.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include "base/check.h"
#include "trace/traced_frame.h"

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
    scene::SceneState state(scene, time);
    const ray::RayScene rays_of_scene(state);

    TraceBenchResult result;
    result.build_ms = rays_of_scene.statistics().build_ms;
    const scene::View view = scene::make_view(state, options.camera, options.size);
    trace::TracedOptions traced;
    traced.max_depth = options.max_depth;
    shading::FrameBuffers buffers;

    // Record the rays of the frame once.
    Tasks one(1), many(options.threads);
    trace::TraceLog log;
    trace::trace_frame(state, rays_of_scene, view, traced, one, buffers, nullptr, &log);
    result.rays = log.rays();

    // Time the frame and the bare loop alternately, so that changes in the machine's speed affect both.
    std::vector<double> frame, single, bare, ratios;
    std::uint64_t sink = 0;
    for (int i = 0; i < options.repeats; ++i) {
        single.push_back(
            milliseconds_of([&] { trace::trace_frame(state, rays_of_scene, view, traced, one, buffers); }));
        bare.push_back(milliseconds_of([&] { sink += log.replay(rays_of_scene); }));
        frame.push_back(
            milliseconds_of([&] { trace::trace_frame(state, rays_of_scene, view, traced, many, buffers); }));
        ratios.push_back(single.back() / bare.back());
    }
    GNOMON_CHECK(sink != 1);   // keeps the replay from being optimised away
    result.frame_ms = median(frame);
    result.one_thread_ms = median(single);
    result.bare_ms = median(bare);
    result.ratio = median(ratios);

    // Time the update on a few steps to the next frame.
    if (timeline.frames > 1) {
        ray::RayScene moving(state);
        std::vector<double> updates;
        for (int i = 0; i < 2 * options.repeats; ++i) {
            const int next = (options.frame + i) % timeline.frames + 1;
            updates.push_back(milliseconds_of([&] {
                state.advance(timeline.time_of(next));
                moving.update(state);
            }));
        }
        result.update_ms = median(updates);
    }
    result.bytes = rays_of_scene.statistics().bytes;
    return result;
}

}   // namespace gnomon::bench
