// SPDX-License-Identifier: Apache-2.0
// Latency of cancellation: the time from a request to stop until the call throws, by stage.
//
// Each iteration runs a stage, requests a stop at a random time within it, and measures the latency. The counters hold
// the median, the 99th percentile and the largest latency in milliseconds, and how many requests came in time.
//
// Stages: load (a file or a built-in scene), first (a renderer's first frame, which builds everything), second (which
// makes certificates) and later (a frame that is mostly traced). Scenes: two built-in ones and, if the environment
// variable GNOMON_SCENES names a folder of scenes, Sponza.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "gnomon/error.h"
#include "gnomon/renderer.h"

namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

// Runs work on this thread, and `stop` on another after a while. Returns the latency of the stop, if it was in time.
std::optional<double> latency_of(const std::function<void()>& work, const std::function<void()>& stop,
                                 Milliseconds after)
{
    std::atomic<Clock::rep> asked = 0;
    std::thread stopper([&] {
        std::this_thread::sleep_for(after);
        asked = Clock::now().time_since_epoch().count();
        stop();
    });
    std::optional<double> latency;
    try {
        work();
    } catch (const gnomon::InterruptedError&) {
        latency = Milliseconds(Clock::now().time_since_epoch() - Clock::duration(asked.load())).count();
    }
    stopper.join();
    return latency;
}

class Latencies {
 public:
    void add(std::optional<double> latency)
    {
        ++asked_;
        if (latency) values_.push_back(*latency);
    }
    void show(benchmark::State& state)
    {
        std::sort(values_.begin(), values_.end());
        const auto at = [&](double quantile) {
            return values_.empty() ? 0 : values_[static_cast<std::size_t>(quantile * (double(values_.size()) - 1))];
        };
        state.counters["median_ms"] = at(0.5);
        state.counters["p99_ms"] = at(0.99);
        state.counters["most_ms"] = at(1);
        state.counters["stopped"] = double(values_.size()) / double(asked_);
    }

 private:
    std::vector<double> values_;
    std::size_t asked_ = 0;
};

double milliseconds_of(const std::function<void()>& work)
{
    const Clock::time_point start = Clock::now();
    work();
    return Milliseconds(Clock::now() - start).count();
}

gnomon::RenderOptions options_of(const benchmark::State& state)
{
    gnomon::RenderOptions options;
    options.size = {640, 360};
    options.threads = static_cast<int>(state.range(0));
    return options;
}

std::mt19937 g_random{1};

Milliseconds within(double milliseconds)
{
    return Milliseconds(std::uniform_real_distribution<>(0, milliseconds)(g_random));
}

void load(benchmark::State& state, const std::string& what)
{
    const int threads = static_cast<int>(state.range(0));
    const double whole =
        milliseconds_of([&] { benchmark::DoNotOptimize(gnomon::load(what, {.progress = {}, .threads = threads})); });
    Latencies latencies;
    for ([[maybe_unused]] auto _ : state) {
        std::atomic<bool> stopped = false;
        const gnomon::Progress progress = [&](const gnomon::ProgressStep&) { return !stopped; };
        latencies.add(latency_of([&] { gnomon::load(what, {.progress = progress, .threads = threads}); },
                                 [&] { stopped = true; }, within(whole)));
    }
    latencies.show(state);
}

void first(benchmark::State& state, const std::string& what)
{
    const gnomon::Scene scene = gnomon::load(what);
    const double whole = milliseconds_of([&] { gnomon::Renderer(options_of(state)).render(scene, 1); });
    Latencies latencies;
    for ([[maybe_unused]] auto _ : state) {
        gnomon::Renderer renderer(options_of(state));
        latencies.add(latency_of([&] { renderer.render(scene, 1); }, [&] { renderer.cancel(); }, within(whole)));
    }
    latencies.show(state);
}

void second(benchmark::State& state, const std::string& what)
{
    const gnomon::Scene scene = gnomon::load(what).lasting(10);
    gnomon::Renderer renderer(options_of(state));
    renderer.render(scene, 1);
    const double whole = milliseconds_of([&] { renderer.render(scene, 2); });
    Latencies latencies;
    for ([[maybe_unused]] auto _ : state) {
        gnomon::Renderer fresh(options_of(state));
        fresh.render(scene, 1);
        latencies.add(latency_of([&] { fresh.render(scene, 2); }, [&] { fresh.cancel(); }, within(whole)));
    }
    latencies.show(state);
}

void later(benchmark::State& state, const std::string& what)
{
    const gnomon::Scene scene = gnomon::load(what).lasting(10);
    gnomon::RenderOptions options = options_of(state);
    options.samples = 16;
    gnomon::Renderer renderer(options);
    for (int frame = 1; frame <= 3; ++frame) renderer.render(scene, frame);
    const double whole = milliseconds_of([&] { renderer.render(scene, 4); });
    Latencies latencies;
    int frame = 4;
    for ([[maybe_unused]] auto _ : state) {
        frame = frame % scene.frame_count() + 1;
        latencies.add(latency_of([&] { renderer.render(scene, frame); }, [&] { renderer.cancel(); }, within(whole)));
    }
    latencies.show(state);
}

struct Stage {
    const char* name;
    void (*run)(benchmark::State&, const std::string&);
    int iterations;
};

[[maybe_unused]] const bool g_registered = [] {
    std::vector<std::pair<std::string, std::string>> scenes{{"kinetic", "builtin:kinetic"},
                                                            {"cornell", "builtin:cornell"}};
    if (const char* folder = std::getenv("GNOMON_SCENES")) {
        const auto sponza = std::filesystem::path(folder) / "sponza" / "sponza.obj";
        if (std::filesystem::exists(sponza)) scenes.emplace_back("sponza", sponza.string());
    }
    for (const Stage& stage : {Stage{"load", &load, 50}, Stage{"first", &first, 100}, Stage{"second", &second, 40},
                               Stage{"later", &later, 100}})
        for (const auto& [name, what] : scenes)
            for (const int threads : {1, 0})
                benchmark::RegisterBenchmark((std::string(stage.name) + "/" + name).c_str(), stage.run, what)
                    ->Arg(threads)
                    ->Iterations(stage.iterations)
                    ->Unit(benchmark::kMillisecond)
                    ->UseRealTime();
    return true;
}();

}   // namespace
