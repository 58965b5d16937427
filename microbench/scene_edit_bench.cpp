// SPDX-License-Identifier: Apache-2.0
// Time of a frame for which a host added an object that may move, removed one, or did both.
//
// `kinetic` edits builtin:kinetic and renders 640 x 360 pixels; `boxes` edits a floor with N fixed boxes of 12
// triangles under a point light, and renders 8 x 8 pixels. Every edit is followed by a frame without one. Both have
// indirect light and certified shadow culling.
//
// Counters: medians in milliseconds of SceneBuilder's part (build_), of the edited frame's stage scene (scene_) and of
// the whole frame (frame_), by edit; of a frame without an edit (frame_none); frames that began anew after the first.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "gnomon/gnomon.h"

namespace {

using gnomon::Transform;

constexpr int k_rounds = 8;

double milliseconds_since(std::chrono::steady_clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

gnomon::MeshId add_box(gnomon::SceneBuilder& builder, float size)
{
    std::vector<gnomon::Vec3> corners;
    for (int c = 0; c < 8; ++c) corners.push_back({c & 1 ? size : 0, c & 2 ? size : 0, c & 4 ? size : 0});
    const std::vector<std::uint32_t> indices{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                             2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    gnomon::Mesh mesh;
    mesh.positions = corners;
    mesh.indices = indices;
    return builder.mesh(mesh);
}

gnomon::Scene boxes(int count)
{
    const int across = static_cast<int>(std::ceil(std::sqrt(count)));
    gnomon::SceneBuilder builder;
    const gnomon::MeshId mesh = add_box(builder, 0.5f);
    builder.instance(add_box(builder, static_cast<float>(across)), {}, Transform::translation(0, -across, 0));
    for (int i = 0; i < count; ++i) builder.instance(mesh, {}, Transform::translation(i % across, 0, i / across));
    builder.light({}, Transform::translation(0.5 * across, 0.5 * across + 2, 0.5 * across));
    gnomon::Camera camera;
    camera.transform = Transform::translation(0.5 * across, 0.3 * across + 1, 1.5 * across);
    builder.camera(camera);
    return builder.finish();
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values.empty() ? 0 : values[values.size() / 2];
}

void edit(benchmark::State& state, const gnomon::Scene& first, gnomon::Size size)
{
    gnomon::RenderOptions options;
    options.size = size;
    enum Edit { none, add, remove, both, k_edits };
    std::vector<double> build[k_edits], scene_ms[k_edits], frame_ms[k_edits];
    int anew = 0;
    for ([[maybe_unused]] auto _ : state) {
        gnomon::Renderer renderer(options);
        gnomon::SceneBuilder builder(first);
        const gnomon::MeshId mesh = add_box(builder, 0.2f);
        std::deque<gnomon::InstanceId> added;
        int count = 0;
        const auto add_one = [&] {
            ++count;
            added.push_back(builder.instance(mesh, {},
                                             Transform::translation(0.3 * (count % 7), 0.6, 0.2 * (count % 5)),
                                             {.mobility = gnomon::Mobility::may_move}));
        };
        const auto remove_one = [&] {
            builder.remove(gnomon::NodeId(added.front()));
            added.pop_front();
        };
        add_one();
        add_one();
        gnomon::Scene scene = builder.finish();
        renderer.render(scene, 1);
        renderer.render(scene, 1);
        for (int round = 0; round < k_rounds; ++round)
            for (const Edit kind : {add, none, both, none, remove, none}) {
                const auto start = std::chrono::steady_clock::now();
                if (kind == remove || kind == both) remove_one();
                if (kind == add || kind == both) add_one();
                if (kind != none) scene = builder.finish();
                build[kind].push_back(milliseconds_since(start));
                const gnomon::Frame image = renderer.render(scene, 1);
                scene_ms[kind].push_back(image.times.ms[gnomon::FrameTimes::scene]);
                frame_ms[kind].push_back(image.milliseconds);
                anew += image.counters.update.began_anew;
            }
    }
    const char* const names[] = {"none", "add", "remove", "both"};
    for (const Edit kind : {none, add, remove, both}) {
        if (kind != none) state.counters[std::string("build_") + names[kind]] = median(build[kind]);
        state.counters[std::string("scene_") + names[kind]] = median(scene_ms[kind]);
        state.counters[std::string("frame_") + names[kind]] = median(frame_ms[kind]);
    }
    state.counters["anew"] = anew;
}

void kinetic(benchmark::State& state)
{
    edit(state, gnomon::load("builtin:kinetic"), {640, 360});
}

void among_boxes(benchmark::State& state)
{
    edit(state, boxes(static_cast<int>(state.range(0))), {8, 8});
}

BENCHMARK(kinetic)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(among_boxes)->Arg(100)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond)->Iterations(1);

}   // namespace

BENCHMARK_MAIN();
