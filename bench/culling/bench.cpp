// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/bench.h"

#include <algorithm>

#include "base/clocks.h"
#include "bench/culling/counts.h"
#include "bench/culling/images.h"
#include "bench/culling/paper_bench.h"
#include "bench/culling/summary.h"
#include "gnomon/error.h"
#include "ray/origin.h"
#include "scene/light_reach.h"
#include "shadow_culling/certified/certified_culling.h"

namespace gnomon::bench {

namespace {

using shadow_culling::CertifiedCulling;
using shadow_culling::CertifiedOptions;

// The number of a method's results that differ from tracing every ray.
template <class Results>
std::uint64_t wrong_of(const std::vector<CullingTile>& tiles, Results&& results_of)
{
    std::uint64_t wrong = 0;
    for (const CullingTile& tile : tiles) {
        const std::vector<std::uint8_t>& results = results_of(tile);
        for (std::size_t i = 0; i < tile.off.size(); ++i) wrong += tile.facing[i] && tile.off[i] != results[i];
    }
    return wrong;
}

// One run over the frames. Every method starts with empty caches of its own.
class Run {
 public:
    Run(const std::shared_ptr<const scene::Scene>& scene, const CullingBenchOptions& options)
        : options_(options),
          scene_(*scene),
          state_(scene, time_of(options, scene->timeline, options.frames.first)),
          rays_(state_),
          tasks_(options.threads),
          tracers_(static_cast<std::size_t>(tasks_.threads())),
          workers_(static_cast<std::size_t>(tasks_.threads()))
    {
        rays_.keep_one_tree();
        CertifiedOptions certified_options;
        certified_options.pixels_per_part = options.pixels_per_part;
        certified_options.certificates.left_out = options.left_out;
        if (options.certified) {
            culling_ = std::make_unique<CertifiedCulling>(state_, rays_, certified_options);
            for (int t = 0; t < tasks_.threads(); ++t) batches_.push_back(culling_->make_batch());
        }
        if (options.paper)
            paper_ = std::make_unique<PaperBench>(state_, rays_, tasks_.threads(), options.paper_options);
        for (const PaperReading& reading : options.readings) {
            readings_.push_back(std::make_unique<PaperBench>(state_, rays_, tasks_.threads(), reading.options));
            const std::size_t primitives = readings_.back()->culling().triangles().size();
            occluders_.push_back(reading.caches_occluders && options.counts
                                     ? std::make_unique<OccluderCache>(primitives, scene->lights.size())
                                     : nullptr);
            caches_.push_back({occluders_.back().get(), &readings_.back()->culling()});
        }
        if (options.counts) {
            ray::KdOptions tree;
            tree.layout = options.layout;
            tree.mobility_by_frame = true;
            kdtree_ = std::make_unique<ray::CountingKdTree>(state_, rays_, tree);
        }
        columns_ = (options.size.width + PointTracer::k_tile - 1) / PointTracer::k_tile;
        const int rows = (options.size.height + PointTracer::k_tile - 1) / PointTracer::k_tile;
        tiles_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
    }

    CullingFrame measure(int frame)
    {
        // The methods also see the frames between this one and the one before.
        CullingFrame record;
        record.frame = frame;
        record.time = time_of(options_, scene_.timeline, frame);
        record.readings.resize(readings_.size());
        for (int b = 1; frame > options_.frames.first && b < options_.between; ++b) {
            advance(frame - 1 + static_cast<double>(b) / options_.between);
            CullingFrame unmeasured = record;
            follow_papers(unmeasured);
            if (culling_) follow_certified(unmeasured);
        }
        // Run all methods on the same points, then count their rays' work on the kd-tree.
        advance(frame);
        trace_every_ray(record);
        follow_papers(record);
        if (culling_) follow_certified(record);
        if (kdtree_) {
            kdtree_->build(state_, rays_);
            count_on_kdtree(*kdtree_, state_, rays_, options_, tiles_, caches_, counting_tasks_, record);
        }
        return record;
    }

    /// Images of the latest frame.
    WrongImages images(const CullingFrame& record) const { return wrong_images(state_, options_.size, tiles_, record); }

    /// Fills in the memory used.
    void sizes(CullingBenchResult& result) const
    {
        if (paper_) result.paper_bytes = paper_->culling().bytes();
        result.readings.resize(readings_.size());
        for (std::size_t r = 0; r < readings_.size(); ++r) result.readings[r].bytes = readings_[r]->culling().bytes();
        if (kdtree_) {
            const ray::KdStatistics tree = kdtree_->statistics();
            for (const ray::KdTreeStatistics* part : {&tree.still, &tree.resting, &tree.moving})
                result.tree_nodes += part->nodes, result.tree_group_splits += part->group_splits;
        }
        if (!culling_) return;
        result.bytes = culling_->bytes();
        result.mask_bytes = culling_->mask_bytes();
        result.most_evidence_bytes = culling_->most_evidence_bytes();
        result.visible_triangles = culling_->visible_triangles();
        const auto pairs = static_cast<double>(result.visible_triangles * scene_.lights.size());
        if (pairs > 0) result.bytes_per_triangle_light = static_cast<double>(result.bytes) / pairs;
    }

 private:
    struct Worker {
        ray::RayQueue queue;
        std::vector<std::uint32_t> whose;   // index of the point, by ray
        std::vector<std::uint8_t> answers;
        std::uint64_t rays = 0;
    };

    // Moves the scene to a frame and finds its shading points.
    void advance(double frame)
    {
        state_.advance(time_of(options_, scene_.timeline, frame));
        rays_.update(state_);
        if (kdtree_) kdtree_->follow(state_);
        view_ = scene::make_view(state_, options_.camera, options_.size);
        find_points();
    }

    // Traces the paths of all tiles and resets the results of all methods.
    void find_points()
    {
        if (paper_) paper_->clear_image(options_.size);
        for (const auto& reading : readings_) reading->clear_image(options_.size);
        tasks_.for_each(tiles_.size(), [&](std::size_t t, int w) {
            CullingTile& tile = tiles_[t];
            const int at = static_cast<int>(t);
            tracers_[static_cast<std::size_t>(w)].trace(state_, rays_, view_, at % columns_ * PointTracer::k_tile,
                                                        at / columns_ * PointTracer::k_tile, options_.max_depth, tile);
            for (const SeenPixel& p : tile.pixels) {
                if (paper_) paper_->set_pixel(p);
                for (const auto& reading : readings_) reading->set_pixel(p);
            }
            const std::size_t pairs = tile.points.size() * scene_.lights.size();
            tile.facing.assign(pairs, 0);
            tile.off.assign(pairs, 1);
            tile.paper.assign(paper_ ? pairs : 0, 1);
            tile.certified.assign(culling_ ? pairs : 0, 1);
            tile.paper_rays.assign(options_.counts ? pairs : 0, 0);
            tile.certified_rays.assign(options_.counts ? pairs : 0, 0);
            tile.readings.resize(readings_.size());
            for (ReadingTile& reading : tile.readings) {
                reading.occluded.assign(pairs, 1);
                reading.rays.assign(options_.counts ? pairs : 0, 0);
            }
        });
    }

    // Queues a shadow ray for each point of a tile that faces a light.
    void queue_facing(CullingTile& tile, std::size_t l, Worker& worker) const
    {
        const auto id = static_cast<scene::LightId>(l);
        const scene::LightReach light(scene_.lights[id], state_.light(id));
        const float end = light.directional() ? k_infinity : ray::k_shadow_ray_end;
        worker.queue.clear();
        worker.whose.clear();
        for (std::uint32_t p = 0; p < tile.points.size(); ++p) {
            const glm::vec3 to_light = light.from(tile.points[p].origin);
            if (!scene::LightReach::faces(to_light, tile.points[p].normal) || light.dark_at(tile.points[p].origin))
                continue;
            worker.queue.push(tile.points[p].origin, 0, to_light, end);
            worker.whose.push_back(p);
            tile.facing[l * tile.points.size() + p] = 1;
        }
    }

    // Off: traces a ray for every facing pair.
    void trace_every_ray(CullingFrame& record)
    {
        const double cpu = cpu_ms(), wall = wall_ms();
        tasks_.for_each(tiles_.size(), [&](std::size_t t, int w) {
            Worker& worker = workers_[static_cast<std::size_t>(w)];
            CullingTile& tile = tiles_[t];
            for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
                queue_facing(tile, l, worker);
                const std::size_t count = worker.queue.size();
                worker.rays += count;
                worker.answers.resize(count + ray::k_packet_pad);
                rays_.occluded(worker.queue, 0, count, worker.answers.data(), ray::Against::one_tree);
                std::uint8_t* out = tile.off.data() + l * tile.points.size();
                for (std::size_t i = 0; i < count; ++i) out[worker.whose[i]] = worker.answers[i];
            }
        });
        record.off.ms = cpu_ms() - cpu;
        record.off.wall_ms = wall_ms() - wall;
        for (Worker& worker : workers_) {
            record.off.rays += worker.rays;
            worker.rays = 0;
        }
    }

    // Paper: traces the rays that Table 2 requires, runs the occlusion test, and merges the results.
    void follow_papers(CullingFrame& record)
    {
        if (paper_) {
            follow_paper(
                *paper_, record.paper, [](auto& tile) -> auto& { return tile.paper; },
                [](CullingTile & tile) -> auto& { return tile.paper_rays; });
        }
        for (std::size_t r = 0; r < readings_.size(); ++r)
            follow_paper(
                *readings_[r], record.readings[r], [r](auto& tile) -> auto& { return tile.readings[r].occluded; },
                [r](CullingTile & tile) -> auto& { return tile.readings[r].rays; });
    }

    template <class Results, class Rays>
    void follow_paper(PaperBench& paper, CullingFrame::Paper& record, Results&& results_of, Rays&& rays_of)
    {
        std::vector<PaperBench::Batch> batches;
        for (CullingTile& tile : tiles_)
            batches.push_back({&tile, results_of(tile).data(), options_.counts ? rays_of(tile).data() : nullptr});
        const double cpu = cpu_ms(), wall = wall_ms();
        paper.run(state_, rays_, batches, tasks_);
        record.ms = cpu_ms() - cpu;
        record.wall_ms = wall_ms() - wall;
        const shadow_culling::PaperCounters& p = paper.culling().counters();
        record.rays = p.rays;
        record.skipped = p.skipped;
        record.dynamic_only = p.dynamic_only;
        record.full = p.full;
        record.extra_tests = p.extra_tests;
        record.extra_tests_per_pixel = paper.extra_tests_per_pixel();
        record.wrong = wrong_of(tiles_, results_of);
    }

    // Certified: looks up certificates, traces the remaining rays, and proves new certificates from them.
    void follow_certified(CullingFrame& record)
    {
        const double cpu = cpu_ms(), wall = wall_ms();
        culling_->begin_frame(state_, rays_, {view_.eye, view_.pixel_spread, view_.pixel_width});
        tasks_.for_each(tiles_.size(), [&](std::size_t t, int w) {
            std::vector<std::uint8_t>& answers = workers_[static_cast<std::size_t>(w)].answers;
            CullingTile& tile = tiles_[t];
            CertifiedCulling::Batch& batch = *batches_[static_cast<std::size_t>(w)];
            culling_->classify(batch, tile.points);
            answers.resize(tile.points.size() + ray::k_packet_pad);
            for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
                const std::size_t at = l * tile.points.size();
                culling_->shadow(batch, static_cast<int>(l), answers.data(),
                                 options_.counts ? tile.certified_rays.data() + at : nullptr);
                std::copy_n(answers.data(), tile.points.size(), tile.certified.data() + at);
            }
        });
        const double before_judging = wall_ms();
        culling_->end_frame(batches_, tasks_);
        record.certified.ms = cpu_ms() - cpu;
        record.certified.wall_ms = wall_ms() - wall;
        record.certified.judge_ms = wall_ms() - before_judging;
        const shadow_culling::CullingCounters& c = culling_->counters();
        record.certified.rays = record.off.rays;
        record.certified.dynamic_only = c.dynamic_only;
        record.certified.skipped = record.off.rays - c.traced - c.dynamic_only;
        record.certified.traced = c.traced;
        record.certified.partial = c.partial;
        record.certified.certificates = c.certificates;
        record.certified.certified = c.certified;
        record.certified.wrong = wrong_of(
            tiles_, [](const CullingTile& tile) -> auto& { return tile.certified; });
    }

    const CullingBenchOptions& options_;
    const scene::Scene& scene_;
    scene::SceneState state_;
    ray::RayScene rays_;
    Tasks tasks_;
    Tasks counting_tasks_{0};   // all threads: counts are not timed, and do not depend on threads
    std::unique_ptr<CertifiedCulling> culling_;
    std::vector<std::unique_ptr<CertifiedCulling::Batch>> batches_;   // by worker
    std::unique_ptr<PaperBench> paper_;
    std::vector<std::unique_ptr<PaperBench>> readings_;
    std::vector<std::unique_ptr<OccluderCache>> occluders_;   // by reading; null: none
    std::vector<ReadingCache> caches_;
    std::unique_ptr<ray::CountingKdTree> kdtree_;
    scene::View view_;
    int columns_ = 0;
    std::vector<CullingTile> tiles_;
    std::vector<PointTracer> tracers_;   // by worker
    std::vector<Worker> workers_;
};

}   // namespace

double time_of(const CullingBenchOptions& options, const scene::Timeline& timeline, double frame)
{
    if (options.step > 0) return options.start.value_or(timeline.start) + (frame - 1) * options.step;
    return timeline.time_of(static_cast<int>(frame));
}

int steps_in(const scene::Timeline& timeline, const CullingBenchOptions& options)
{
    const double span = timeline.end - options.start.value_or(timeline.start);
    return 1 + static_cast<int>(std::clamp(span / options.step + 1e-6, 0.0, 1e6));
}

CullingBenchResult bench_culling(const std::shared_ptr<const scene::Scene>& scene, const CullingBenchOptions& options,
                                 const Progress& progress, const std::function<void(const CullingFrame&)>& on_frame)
{
    CullingBenchResult result;
    // Measure every run; the first also gives images and memory sizes.
    std::vector<std::vector<CullingFrame>> runs(static_cast<std::size_t>(options.repeat));
    const double steps = static_cast<double>(options.repeat) * options.frames.count();
    double done = 0;
    for (std::size_t r = 0; r < runs.size(); ++r) {
        Run run(scene, options);
        for (int frame = options.frames.first; frame <= options.frames.last; ++frame, ++done) {
            if (progress && !progress({"measuring", done / steps})) throw InterruptedError("interrupted");
            const CullingFrame& record = runs[r].emplace_back(run.measure(frame));
            if (r > 0) continue;
            if (options.images && options.paper && (!result.images || record.paper.wrong > result.images->wrong))
                result.images = run.images(record);
            if (on_frame) on_frame(record);
        }
        if (r == 0) run.sizes(result);
    }
    result.frames = medians_of(runs);
    summarise(options, result);
    return result;
}

}   // namespace gnomon::bench
