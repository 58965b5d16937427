// SPDX-License-Identifier: Apache-2.0
// Rays per second, single and in packets; building; updating ten dynamic objects among a hundred thousand objects.
// GNOMON_BENCH_SCENE names the scene (default: the built-in courtyard).

#include <benchmark/benchmark.h>

#include <cstdlib>

#include "io/load.h"
#include "ray/ray_scene.h"
#include "scene/builtin/builtin.h"

namespace {

using namespace gnomon;

constexpr int k_size = 512;

std::shared_ptr<const scene::Scene> the_scene()
{
    static const auto scene = [] {
        const char* path = std::getenv("GNOMON_BENCH_SCENE");
        scene::Scene loaded = path ? io::load_scene(path) : scene::make_kinetic();
        scene::add_default_light(loaded);
        scene::add_default_camera(loaded);
        return std::make_shared<const scene::Scene>(std::move(loaded));
    }();
    return scene;
}

struct Setting {
    scene::SceneState state{the_scene(), the_scene()->timeline.start};
    ray::RayScene rays{state};
    ray::RayQueue primary, shadow;

    // One ray per pixel in tiles of four by four, and from its hit one ray to the first light.
    Setting()
    {
        const scene::Camera& camera = the_scene()->cameras.front();
        const glm::dmat4 world = state.world(camera.node);
        const double half = std::tan(camera.vertical_fov / 2);
        for (int tile = 0; tile < k_size * k_size / 16; ++tile)
            for (int i = 0; i < 16; ++i) {
                const int column = tile % (k_size / 4) * 4 + i % 4, row = tile / (k_size / 4) * 4 + i / 4;
                const double x = column + 0.5, y = row + 0.5;
                const glm::dvec3 local((2 * x / k_size - 1) * half, (1 - 2 * y / k_size) * half, -1);
                primary.push(glm::vec3(world[3]), 0, glm::vec3(glm::dmat3(world) * local), k_infinity);
            }
        ray::Hits hits;
        hits.resize(primary.size());
        rays.closest(primary, 0, primary.size(), hits, ray::Sides::front);
        for (std::size_t i = 0; i < primary.size(); ++i) {
            if (hits.object[i] == scene::none) continue;
            const glm::vec3 point = primary.origin(i) + 0.9999f * hits.t[i] * primary.direction(i);
            const scene::LightState& light = state.light(0);
            if (the_scene()->lights[0].type == scene::LightType::directional)
                shadow.push(point, 0, -light.direction, k_infinity);
            else
                shadow.push(point, 0, light.position - point, 0.999f);
        }
    }
};

Setting& setting()
{
    static Setting one;
    return one;
}

void rate(benchmark::State& bench, std::size_t rays)
{
    bench.counters["rays/s"] =
        benchmark::Counter(static_cast<double>(rays), benchmark::Counter::kIsIterationInvariantRate);
}

void primary_packets(benchmark::State& bench)
{
    Setting& s = setting();
    ray::Hits hits;
    hits.resize(s.primary.size());
    for (auto _ : bench) s.rays.closest(s.primary, 0, s.primary.size(), hits, ray::Sides::front);
    rate(bench, s.primary.size());
}

void primary_singly(benchmark::State& bench)
{
    Setting& s = setting();
    for (auto _ : bench)
        for (std::size_t i = 0; i < s.primary.size(); ++i)
            benchmark::DoNotOptimize(
                s.rays.closest_single(s.primary.origin(i), 0, s.primary.direction(i), k_infinity, ray::Sides::front));
    rate(bench, s.primary.size());
}

void shadow_packets(benchmark::State& bench)
{
    Setting& s = setting();
    std::vector<std::uint8_t> occluded(s.shadow.size());
    const auto against = static_cast<ray::Against>(bench.range(0));
    for (auto _ : bench) s.rays.occluded(s.shadow, 0, s.shadow.size(), occluded.data(), against);
    rate(bench, s.shadow.size());
}

void shadow_singly(benchmark::State& bench)
{
    Setting& s = setting();
    for (auto _ : bench)
        for (std::size_t i = 0; i < s.shadow.size(); ++i)
            benchmark::DoNotOptimize(
                s.rays.occluded_single(s.shadow.origin(i), 0, s.shadow.direction(i), s.shadow.tfar[i]));
    rate(bench, s.shadow.size());
}

void build(benchmark::State& bench)
{
    const scene::SceneState state(the_scene(), the_scene()->timeline.start);
    for (auto _ : bench) {
        const ray::RayScene rays(state);
        bench.counters["MB"] = static_cast<double>(rays.statistics().bytes) / 1e6;
    }
}

void follow_ten_among_100k(benchmark::State& bench)
{
    scene::SpheresOptions options;
    options.objects = 100000, options.dynamic_objects = 10, options.vertices = 14;
    const auto scene = std::make_shared<const scene::Scene>(scene::make_spheres(options));
    scene::SceneState state(scene, 0);
    ray::RayScene rays(state);
    int frame = 1;
    for (auto _ : bench) {
        state.advance(frame++ % 240 / 24.0);
        rays.update(state);
    }
    bench.counters["touched"] = static_cast<double>(rays.statistics().touched);
}

BENCHMARK(primary_packets)->Unit(benchmark::kMillisecond);
BENCHMARK(primary_singly)->Unit(benchmark::kMillisecond);
BENCHMARK(shadow_packets)->ArgName("against")->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK(shadow_singly)->Unit(benchmark::kMillisecond);
BENCHMARK(build)->Unit(benchmark::kMillisecond);
BENCHMARK(follow_ten_among_100k)->Unit(benchmark::kMicrosecond);

}   // namespace
