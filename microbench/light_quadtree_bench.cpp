// SPDX-License-Identifier: Apache-2.0
// The light quad-tree in the built-in box: the gather at every pixel of 512 x 512, on two threads; the light map
// updated and rebuilt; clusters and samples against the sum over all texels of the map (nrmse_brute).

#include <benchmark/benchmark.h>

#include "light_quadtree/map_light.h"
#include "scene/builtin/builtin.h"
#include "trace/indirect_grid.h"

namespace {

using namespace gnomon;
using namespace light_quadtree;

constexpr int k_size = 512;

struct World {
    std::shared_ptr<const scene::Scene> scene = std::make_shared<const scene::Scene>(scene::make_builtin("cornell"));
    scene::SceneState state{scene, scene->timeline.start};
    ray::RayScene rays{state};
    Tasks tasks{2};

    void go(int frame)
    {
        state.advance(scene->timeline.time_of(frame));
        rays.update(state);
    }
    // The surfaces that the camera sees at every `step`-th pixel.
    Receivers seen(int step)
    {
        const scene::View view = scene::make_view(state, 0, {k_size, k_size});
        const trace::IndirectGrid grid = trace::cast_indirect_grid(*scene, rays, view, step, tasks);
        const int side = k_size / step;
        Receivers receivers;
        receivers.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const MapReceiver& r =
                    grid.receivers[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.columns) +
                                   static_cast<std::size_t>(x)];
                receivers.set(
                    static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x),
                    r.position, r.normal);
            }
        return receivers;
    }
};

void gather_everywhere(const MapLight& light, Receivers& receivers, Tasks& tasks)
{
    constexpr std::size_t k_part = 4096;
    const std::size_t padded = receivers.x.size();
    tasks.for_each((padded + k_part - 1) / k_part, [&](std::size_t part, int) {
        MapLight::Batch batch;
        light.gather_all(receivers, part * k_part, std::min(padded, (part + 1) * k_part), batch);
    });
}

const Receivers& brute()
{
    static const Receivers truth = [] {
        World world;
        MapLightOptions options;
        options.method = MapMethod::brute;
        const MapLight light(world.state, world.rays, options, world.tasks);
        Receivers receivers = world.seen(8);
        gather_everywhere(light, receivers, world.tasks);
        return receivers;
    }();
    return truth;
}

void measure(benchmark::State& bench, const MapLightOptions& options)
{
    World world;
    const MapLight light(world.state, world.rays, options, world.tasks);
    Receivers some = world.seen(8), all = world.seen(1);
    gather_everywhere(light, some, world.tasks);
    for (auto _ : bench) gather_everywhere(light, all, world.tasks);
    bench.counters["lights"] = static_cast<double>(light.counters().lights);
    bench.counters["nrmse_brute"] = nrmse(some, brute());
}

// Arguments: limit level, then thresholds of depth and normals in hundredths.
void clusters(benchmark::State& bench)
{
    MapLightOptions options;
    options.levels.limit = static_cast<int>(bench.range(0));
    options.map.validity = {static_cast<float>(bench.range(1)) / 100, static_cast<float>(bench.range(2)) / 100};
    measure(bench, options);
}
BENCHMARK(clusters)
    ->ArgsProduct({{6, 5, 4}, {5}, {90}})
    ->Args({5, 25, 60})
    ->Args({5, 45, 30})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The same sums at 64 x 64 receivers, on one thread: as published, with one pass per level over all its nodes at every
// receiver; from the compacted cut, scalar; and with SIMD. Argument: limit level.
void sparse_as_printed(benchmark::State& bench)
{
    World world;
    const LightMap map(world.state, world.rays, {}, world.tasks);
    const Receivers receivers = world.seen(8);
    const CutLevels levels{7, static_cast<int>(bench.range(0))};
    std::uint64_t nodes = 0;
    for (auto _ : bench) {
        nodes = 0;
        for (std::size_t i = 0; i < receivers.size(); ++i)
            benchmark::DoNotOptimize(gather_as_printed(map, levels, {receivers.x[i], receivers.y[i], receivers.z[i]},
                                                       {receivers.nx[i], receivers.ny[i], receivers.nz[i]}, &nodes));
    }
    bench.counters["nodes_a_receiver"] = static_cast<double>(nodes) / static_cast<double>(receivers.size());
}
BENCHMARK(sparse_as_printed)->DenseRange(4, 6)->Unit(benchmark::kMillisecond);

void sparse_scalar(benchmark::State& bench)
{
    World world;
    const LightMap map(world.state, world.rays, {}, world.tasks);
    const Receivers receivers = world.seen(8);
    Clusters clusters;
    find_clusters(map, {7, static_cast<int>(bench.range(0))}, clusters);
    for (auto _ : bench)
        for (std::size_t i = 0; i < receivers.size(); ++i)
            benchmark::DoNotOptimize(gather_one(clusters, {receivers.x[i], receivers.y[i], receivers.z[i]},
                                                {receivers.nx[i], receivers.ny[i], receivers.nz[i]}));
}
BENCHMARK(sparse_scalar)->DenseRange(4, 6)->Unit(benchmark::kMillisecond);

void sparse_simd(benchmark::State& bench)
{
    World world;
    const LightMap map(world.state, world.rays, {}, world.tasks);
    Receivers receivers = world.seen(8);
    Clusters clusters;
    find_clusters(map, {7, static_cast<int>(bench.range(0))}, clusters);
    for (auto _ : bench) gather(clusters, receivers);
}
BENCHMARK(sparse_simd)->DenseRange(4, 6)->Unit(benchmark::kMillisecond);

void find_cut(benchmark::State& bench)
{
    World world;
    const LightMap map(world.state, world.rays, {}, world.tasks);
    Clusters clusters;
    for (auto _ : bench) find_clusters(map, {7, static_cast<int>(bench.range(0))}, clusters);
}
BENCHMARK(find_cut)->DenseRange(4, 6)->Unit(benchmark::kMicrosecond);

// Arguments: samples, then the disk's radius in hundredths of the map's side.
void samples(benchmark::State& bench)
{
    MapLightOptions options;
    options.method = MapMethod::rsm;
    options.rsm = {static_cast<int>(bench.range(0)), static_cast<float>(bench.range(1)) / 100};
    measure(bench, options);
}
BENCHMARK(samples)
    ->ArgsProduct({{256, 1024, 2040, 4096}, {30, 60, 100}})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void map_rebuilt(benchmark::State& bench)
{
    World world;
    for (auto _ : bench) benchmark::DoNotOptimize(LightMap(world.state, world.rays, {}, world.tasks).version());
}
BENCHMARK(map_rebuilt)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

// Updates the map while the ball moves; the time to update scene and BVHs is excluded. Argument 1: whole tiles are cast
// against everything, as without a stored static layer.
void map_updated(benchmark::State& bench)
{
    World world;
    LightMapOptions options;
    options.against_everything = bench.range(0) != 0;
    LightMap map(world.state, world.rays, options, world.tasks);
    int frame = 1;
    std::uint64_t nodes = 0;
    for (auto _ : bench) {
        bench.PauseTiming();
        frame = frame % world.scene->timeline.frames + 1;
        world.go(frame);
        bench.ResumeTiming();
        map.update(world.state, world.rays, world.tasks);
        nodes += map.work().dirty_nodes;
    }
    bench.counters["dirty_nodes"] = benchmark::Counter(static_cast<double>(nodes), benchmark::Counter::kAvgIterations);
}
BENCHMARK(map_updated)->Arg(0)->Arg(1)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}   // namespace
