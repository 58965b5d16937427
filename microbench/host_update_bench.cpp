// SPDX-License-Identifier: Apache-2.0
// Time and memory of a frame's update where a host moves 10 of N objects.
//
// The scene is a floor under a point light and N boxes of 12 triangles. Each of 1,000 frames (GNOMON_BENCH_FRAMES)
// hands over ten transforms and renders an image of 8 x 8 pixels. The cost of an update must follow what moves, not N.
//
// Variants: `ten` declares ten boxes as ones that may move, and the others as fixed; `all` declares all of them so, and
// ten other ones move in each frame. Indirect light: `visible` and `off`; shadow culling is certified.
//
// Counters: the median and the 95th percentile in milliseconds of the stages scene (scene_), light maps (maps_) and of
// the whole frame (frame_); visited nodes and placed instances of the last frame; resident memory in MB after frame 10
// and after the last one.
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "gnomon/renderer.h"
#include "gnomon/scene_builder.h"

namespace {

constexpr int k_moved = 10;

double resident_megabytes()
{
    std::ifstream file("/proc/self/statm");
    double total = 0, resident = 0;
    file >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
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

// The boxes stand on a square grid of unit cells.
struct World {
    gnomon::Scene scene;
    std::vector<gnomon::NodeId> boxes;   // those that may move
    int across = 0;                      // cells per side
};

World make_world(int count, bool all_may_move)
{
    using gnomon::Transform;
    std::vector<gnomon::NodeId> boxes;
    const int across = static_cast<int>(std::ceil(std::sqrt(count)));
    gnomon::SceneBuilder builder;
    const gnomon::MeshId mesh = add_box(builder, 0.5f);
    const gnomon::MeshId floor = add_box(builder, static_cast<float>(across));
    builder.instance(floor, {}, Transform::translation(0, -across, 0));
    for (int i = 0; i < count; ++i) {
        const bool moves = all_may_move || i % (count / k_moved) == 0;
        const gnomon::InstanceId instance =
            builder.instance(mesh, {}, Transform::translation(i % across, 0, i / across),
                             {.mobility = moves ? gnomon::Mobility::may_move : gnomon::Mobility::fixed});
        if (moves) boxes.push_back(instance);
    }
    builder.light({}, Transform::translation(0.5 * across, 0.5 * across + 2, 0.5 * across));
    gnomon::Camera camera;
    camera.transform = Transform::translation(0.5 * across, 0.3 * across + 1, 1.5 * across);
    builder.camera(camera);
    return {builder.finish(), std::move(boxes), across};
}

struct Quantiles {
    std::vector<double> values;
    double at(double quantile)
    {
        std::sort(values.begin(), values.end());
        return values[static_cast<std::size_t>(quantile * static_cast<double>(values.size() - 1))];
    }
};

void update(benchmark::State& state, bool all_may_move, gnomon::Indirect indirect)
{
    const int count = static_cast<int>(state.range(0));
    const char* const asked = std::getenv("GNOMON_BENCH_FRAMES");
    const int frames = std::max(asked ? std::atoi(asked) : 1000, 20);
    const World world = make_world(count, all_may_move);
    gnomon::RenderOptions options;
    options.size = {8, 8};
    options.threads = 1;
    options.indirect = indirect;
    Quantiles scene, maps, whole;
    gnomon::FrameCounters::Update work;
    double early = 0, late = 0;
    for ([[maybe_unused]] auto _ : state) {
        gnomon::Renderer renderer(options);
        for (int frame = 1; frame <= frames; ++frame) {
            gnomon::FrameInput input;
            for (int k = 0; k < k_moved; ++k) {
                // Ten that lie far apart; of all, other ones in each frame.
                const std::size_t stride = world.boxes.size() / k_moved;
                const std::size_t i = static_cast<std::size_t>(k) * stride + static_cast<std::size_t>(frame) % stride;
                const int cell = all_may_move ? static_cast<int>(i) : static_cast<int>(i) * (count / k_moved);
                input.transforms.push_back(
                    {world.boxes[i], gnomon::Transform::translation(cell % world.across + 0.2 * std::sin(frame),
                                                                    0.5 + 0.4 * std::cos(frame), cell / world.across)});
            }
            const gnomon::Frame image = renderer.render(world.scene, input);
            if (frame == 10) early = resident_megabytes();
            work = image.counters.update;
            if (frame <= 10) continue;   // the caches fill
            scene.values.push_back(image.times.ms[gnomon::FrameTimes::scene]);
            maps.values.push_back(image.times.ms[gnomon::FrameTimes::light_maps]);
            whole.values.push_back(image.milliseconds);
        }
        late = resident_megabytes();
    }
    state.counters["scene_50"] = scene.at(0.5), state.counters["scene_95"] = scene.at(0.95);
    state.counters["maps_50"] = maps.at(0.5), state.counters["maps_95"] = maps.at(0.95);
    state.counters["frame_50"] = whole.at(0.5), state.counters["frame_95"] = whole.at(0.95);
    state.counters["nodes"] = static_cast<double>(work.nodes);
    state.counters["instances"] = static_cast<double>(work.instances);
    state.counters["mb_10"] = early, state.counters["mb_end"] = late;
}

[[maybe_unused]] const bool g_registered = [] {
    for (const bool all : {false, true})
        for (const gnomon::Indirect indirect : {gnomon::Indirect::off, gnomon::Indirect::visible})
            benchmark::RegisterBenchmark(
                (std::string(all ? "all/" : "ten/") + (indirect == gnomon::Indirect::off ? "off" : "visible")).c_str(),
                update, all, indirect)
                ->Arg(100)
                ->Arg(1000)
                ->Arg(10000)
                ->Arg(100000)
                ->Iterations(1)
                ->Unit(benchmark::kMillisecond);
    return true;
}();

}   // namespace
