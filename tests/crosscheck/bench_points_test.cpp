// SPDX-License-Identifier: Apache-2.0
// The points for which bench culling casts shadow rays come from exactly the rays of the traced frame.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "bench/core/bench_points.h"
#include "scene/builtin/builtin.h"
#include "trace/traced_frame.h"

namespace gnomon::bench {
namespace {

using RayValues = std::array<float, 8>;

void collect(const ray::RayQueue& rays, std::vector<RayValues>& out)
{
    for (std::size_t i = 0; i < rays.size(); ++i)
        out.push_back(
            {rays.ox[i], rays.oy[i], rays.oz[i], rays.tnear[i], rays.dx[i], rays.dy[i], rays.dz[i], rays.tfar[i]});
}

// The closest-hit rays of the traced frame, and those of the bench; each sorted.
struct BothRays {
    std::vector<RayValues> frame, bench;
    std::size_t points = 0;
    std::uint64_t reflected = 0, refracted = 0;
    FrameCounters counters;
};

BothRays trace_both(const std::string& name, int frame, int max_depth, Size size)
{
    const auto scene = std::make_shared<const scene::Scene>(scene::make_builtin(name));
    const scene::SceneState state(scene, scene->timeline.time_of(frame));
    const ray::RayScene rays(state);
    const scene::View view = scene::make_view(state, 0, size);
    BothRays both;

    trace::TracedOptions options;
    options.max_depth = max_depth;
    options.lobe_rays = 0;   // the benchmark follows mirrored rays alone
    shading::FrameBuffers buffers;
    trace::TraceLog log;
    Tasks one(1);
    both.counters = trace::trace_frame(state, rays, view, options, one, buffers, {}, &log);
    for (const trace::TraceLog::Entry& entry : log.entries)
        if (!entry.any_hit) collect(entry.rays, both.frame);

    PointTracer tracer;
    BenchPoints points;
    ray::RayQueue bench_rays;
    for (int y = 0; y < size.height; y += PointTracer::k_tile)
        for (int x = 0; x < size.width; x += PointTracer::k_tile) {
            tracer.trace(state, rays, view, x, y, max_depth, points, &bench_rays);
            EXPECT_EQ(points.pixels.size(), points.primary);
            EXPECT_EQ(points.diffuse.size(), points.primary);
            both.points += points.points.size();
            both.reflected += points.reflected_rays;
            both.refracted += points.refracted_rays;
        }
    collect(bench_rays, both.bench);
    std::sort(both.frame.begin(), both.frame.end());
    std::sort(both.bench.begin(), both.bench.end());
    return both;
}

TEST(BenchPoints, CastsTheSameRaysAsTheTracedFrame)
{
    const BothRays both = trace_both("kinetic", 30, 10, {200, 120});   // a pool, glass, a mirror; incomplete tiles
    EXPECT_EQ(both.reflected, both.counters.reflection_rays);
    EXPECT_EQ(both.refracted, both.counters.refraction_rays);
    EXPECT_GT(both.reflected, 100u);
    EXPECT_GT(both.refracted, 100u);
    EXPECT_EQ(both.bench.size(), both.frame.size());
    EXPECT_TRUE(both.bench == both.frame);
    EXPECT_LE(both.points, both.bench.size());
}

TEST(BenchPoints, DepthZeroGivesPrimaryHitsOnly)
{
    const BothRays both = trace_both("cornell", 1, 0, {70, 50});
    EXPECT_EQ(both.reflected + both.refracted, 0u);
    EXPECT_EQ(both.bench.size(), 70u * 50u);
    EXPECT_TRUE(both.bench == both.frame);
}

}   // namespace
}   // namespace gnomon::bench
