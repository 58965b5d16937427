// SPDX-License-Identifier: Apache-2.0
#include "trace/traced_frame.h"

#include <atomic>
#include <memory>
#include <mutex>

#include "base/check.h"
#include "base/stopwatch.h"
#include "trace/indirect_grid.h"
#include "trace/state_map.h"
#include "trace/tile_tracer.h"

namespace gnomon::trace {

namespace {

void add(FrameCounters& sum, const FrameCounters& part)
{
    sum.shadow.rays += part.shadow.rays;
    sum.shadow.rays_skipped += part.shadow.rays_skipped;
    sum.shadow.rays_dynamic_only += part.shadow.rays_dynamic_only;
    if (part.shadow.rays_wrong) sum.shadow.rays_wrong = sum.shadow.rays_wrong.value_or(0) + *part.shadow.rays_wrong;
    sum.primary_rays += part.primary_rays;
    sum.reflection_rays += part.reflection_rays;
    sum.refraction_rays += part.refraction_rays;
}

void resize(ImageF& image, Size size, int channels)
{
    if (image.width != size.width || image.height != size.height || image.channels != channels)
        image = ImageF(size.width, size.height, channels);
}

}   // namespace

FrameCounters trace_frame(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                          const TracedOptions& options, Tasks& tasks, shading::FrameBuffers& out,
                          const Remembered& remembered, TraceLog* log, const Progress& progress)
{
    shadow_culling::CertifiedCulling* const culling = remembered.certified;
    shadow_culling::PaperCulling* const paper = remembered.paper;
    GNOMON_CHECK(!culling || !paper);
    out.times = {};
    Stopwatch watch(out.times);
    GNOMON_CHECK(!log || (tasks.threads() == 1 && !culling && !paper && !remembered.states));
    if (culling) culling->begin_frame(state, rays, {view.eye, view.pixel_spread, view.pixel_width});
    if (paper) paper->begin_frame(state, rays);
    GNOMON_CHECK(!remembered.visible || !remembered.map);
    if (remembered.visible) remembered.visible->update(state, rays, tasks);
    if (remembered.map) {
        remembered.map->begin_frame(state, rays, tasks);
        if (const int step = remembered.map->grid_step(view.size.width, view.size.height); step > 0) {
            const IndirectGrid grid = cast_indirect_grid(state.scene(), rays, view, step, tasks);
            remembered.map->set_grid(grid.receivers, grid.columns, step, tasks);
        }
    }
    watch.end(FrameTimes::light_maps);
    GNOMON_CHECK(options.tile > 0 && (options.tile & (options.tile - 1)) == 0);
    const Size size = view.size;
    resize(out.color, size, 3);
    if (options.reference)
        for (ImageF* image : {&out.variance, &out.irradiance, &out.irradiance_variance}) resize(*image, size, 3);
    if (options.layers) {
        for (ImageF* image : {&out.direct, &out.indirect, &out.albedo, &out.normal}) resize(*image, size, 3);
        resize(out.depth, size, 1);
        resize(out.shadow, size, static_cast<int>(state.scene().lights.size()));
    }

    if (remembered.states) remembered.states->start(size);
    std::vector<shadow_culling::PrimaryHit> primary_hits;   // for the published culling's occlusion test
    if (paper) primary_hits.resize(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));

    const int columns = (size.width + options.tile - 1) / options.tile;
    const int rows = (size.height + options.tile - 1) / options.tile;
    const auto tiles = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);

    std::vector<std::unique_ptr<TileTracer>> workers(static_cast<std::size_t>(tasks.threads()));
    std::atomic<std::size_t> done = 0;
    std::atomic<bool> stopped = false;
    std::mutex progress_mutex;
    tasks.for_each(tiles, [&](std::size_t index, int worker) {
        if (stopped) return;
        auto& tracer = workers[static_cast<std::size_t>(worker)];
        if (!tracer)
            tracer = std::make_unique<TileTracer>(state, rays, view, options, remembered, primary_hits.data(), log);
        TileRect tile;
        tile.x = static_cast<int>(index) % columns * options.tile;
        tile.y = static_cast<int>(index) / columns * options.tile;
        tile.width = std::min(options.tile, size.width - tile.x);
        tile.height = std::min(options.tile, size.height - tile.y);
        tracer->trace(tile, out);
        const std::size_t finished = ++done;
        if (progress) {
            const std::lock_guard lock(progress_mutex);
            if (!progress({"tracing", static_cast<double>(finished) / static_cast<double>(tiles)})) stopped = true;
        }
    });
    if (stopped) throw InterruptedError("interrupted");

    FrameCounters counters;
    for (const auto& worker : workers) {
        if (!worker) continue;
        add(counters, worker->counters());
        counters.indirect.rays += worker->reference_counters().rays;
        for (std::size_t stage = 0; stage < FrameTimes::k_stages; ++stage)
            out.times.ms[stage] += worker->times().ms[stage] / tasks.threads();
    }
    watch.restart();   // the tiles told their own
    if (culling) {
        std::vector<std::unique_ptr<shadow_culling::CertifiedCulling::Batch>> batches;
        for (const auto& worker : workers)
            if (worker) batches.push_back(worker->take_batch());
        culling->note_news(batches);
        if (!remembered.judge_later) culling->judge(tasks);
        const shadow_culling::CullingCounters& culled = culling->counters();
        counters.shadow.rays = culled.skipped + culled.dynamic_only + culled.traced;
        counters.shadow.rays_skipped = culled.skipped;
        counters.shadow.rays_dynamic_only = culled.dynamic_only;
    }
    watch.end(FrameTimes::proofs);
    if (remembered.visible) {
        std::vector<std::unique_ptr<irradiance_cache::IrradianceCache::Batch>> batches;
        for (const auto& worker : workers)
            if (worker) batches.push_back(worker->take_indirect_batch());
        remembered.visible->end_frame(batches);
        const irradiance_cache::CacheCounters& c = remembered.visible->counters();
        counters.indirect.rays = c.rays;
        counters.indirect.clusters = c.nodes;
    }
    if (remembered.map) {
        std::vector<std::unique_ptr<light_quadtree::MapLight::Batch>> batches;
        for (const auto& worker : workers)
            if (worker) batches.push_back(worker->take_map_batch());
        remembered.map->end_frame(batches);
        counters.indirect.rays = remembered.map->map().work().cast;
        counters.indirect.clusters = remembered.map->counters().lights;
    }
    watch.end(FrameTimes::indirect);
    if (paper) {
        std::vector<shadow_culling::PaperCulling::Notes> notes;
        for (const auto& worker : workers)
            if (worker) notes.push_back(worker->take_notes());
        paper->see_image(primary_hits, static_cast<std::size_t>(size.width));
        paper->end_frame(notes);
        counters.shadow.rays = paper->counters().rays;
        counters.shadow.rays_skipped = paper->counters().skipped;
        counters.shadow.rays_dynamic_only = paper->counters().dynamic_only;
    }
    return counters;
}

std::uint64_t TraceLog::rays() const
{
    std::uint64_t sum = 0;
    for (const Entry& entry : entries) sum += entry.rays.size();
    return sum;
}

std::uint64_t TraceLog::replay(const ray::RayScene& scene) const
{
    std::uint64_t result = 0;
    ray::Hits hits;
    std::vector<std::uint8_t> occluded;
    for (const Entry& entry : entries) {
        const std::size_t count = entry.rays.size();
        if (entry.any_hit) {
            occluded.resize(count + ray::k_packet_pad);
            scene.occluded(entry.rays, 0, count, occluded.data());
            result += occluded[count / 2];
        } else {
            hits.resize(count);
            scene.closest(entry.rays, 0, count, hits, ray::Sides::front);
            result += hits.triangle[count / 2];
        }
    }
    return result;
}

}   // namespace gnomon::trace
