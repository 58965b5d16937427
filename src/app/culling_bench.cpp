// SPDX-License-Identifier: Apache-2.0
#include "app/culling_bench.h"

#include <algorithm>
#include <chrono>
#include <ctime>

#include "app/paper_bench.h"
#include "base/tasks.h"
#include "ray/kdtree.h"
#include "ray/origin.h"
#include "render/view.h"
#include "shadow_culling/certified_culling.h"

namespace gnomon::app {

namespace {

constexpr int k_tile = 32;

double cpu_ms()
{
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

double wall_ms()
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The primary hits of one tile.
struct TilePoints {
    std::vector<shadow_culling::ShadowPoint> points;
    std::vector<std::uint8_t> off, paper, certified;        // [light][point]: 1 blocked or behind
    std::vector<std::uint8_t> paper_rays, certified_rays;   // alike: 1 a ray against everything, 2 against movers
    std::vector<std::uint8_t> asked;                        // alike: 1 where the light shines on the surface
};

void trace_primary(const render::View& view, const ray::RayScene& rays, int x0, int y0, TilePoints& tile,
                   PaperBench* paper)
{
    ray::RayQueue queue;
    std::vector<std::pair<int, int>> pixels;   // of the rays
    ray::Hits hits;
    for (int block = 0; block < k_tile * k_tile; ++block) {
        // 4 x 2 blocks, row by row: coherent packets.
        const int in_block = block % 8, b = block / 8;
        const int x = x0 + (b % (k_tile / 4)) * 4 + in_block % 4, y = y0 + (b / (k_tile / 4)) * 2 + in_block / 4;
        if (x >= view.size.width || y >= view.size.height) continue;
        glm::vec3 origin, direction;
        float tnear, tfar;
        view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
        queue.push(origin, tnear, direction, tfar);
        pixels.emplace_back(x, y);
    }
    tile.points.clear();
    if (queue.empty()) return;
    hits.resize(queue.size());
    rays.closest(queue, 0, queue.size(), hits, ray::Sides::front);
    for (std::size_t i = 0; i < queue.size(); ++i) {
        if (hits.object[i] == scene::none) continue;
        if (paper)
            paper->set_pixel(pixels[i].first, pixels[i].second, hits.object[i], hits.triangle[i], queue.origin(i),
                             queue.direction(i));
        glm::vec3 p[3];
        rays.geometry(hits.object[i]).corners(hits.triangle[i], p);
        const float u = hits.u[i], v = hits.v[i];
        const glm::vec3 position = std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2];
        const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float length = glm::length(cross);
        if (!(length > 0)) continue;
        const bool front = glm::dot(cross, queue.direction(i)) < 0;
        const glm::vec3 normal = (front ? cross : -cross) / length;
        tile.points.push_back(
            {position + ray::origin_lift(p) * normal, normal, hits.object[i], hits.triangle[i], u, v, front});
    }
}

// Walks the counting kd-tree with every ray that each method traced; by no means in their times.
void count_on_kdtree(const ray::CountingKdTree& tree, const scene::SceneState& state, float ray_end,
                     const std::vector<TilePoints>& tiles, Tasks& tasks, CullingFrame& record)
{
    const scene::Scene& scene = state.scene();
    struct Sums {
        ray::KdCounts off, paper, certified;
    };
    const auto add = [](ray::KdCounts& sum, const ray::KdCounts& part) {
        sum.nodes += part.nodes;
        sum.tests += part.tests;
    };
    std::vector<Sums> sums(tiles.size());
    tasks.for_each(tiles.size(), [&](std::size_t t, int) {
        const TilePoints& tile = tiles[t];
        for (std::size_t l = 0; l < scene.lights.size(); ++l) {
            const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
            const bool directional = scene.lights[l].type == scene::LightType::directional;
            for (std::size_t p = 0; p < tile.points.size(); ++p) {
                const auto& point = tile.points[p];
                const glm::vec3 d = directional ? -at.direction : at.position - point.origin;
                if (!tile.asked[l * tile.points.size() + p]) continue;
                const float end = directional ? k_infinity : ray_end;
                ray::KdCounts all, movers;
                tree.blocked(point.origin, 0, d, end, ray::Against::everything, all);
                const std::size_t at_point = l * tile.points.size() + p;
                const int paper = tile.paper_rays[at_point], certified = tile.certified_rays[at_point];
                if (paper == 2 || certified == 2)
                    tree.blocked(point.origin, 0, d, end, ray::Against::dynamic_only, movers);
                add(sums[t].off, all);
                if (paper) add(sums[t].paper, paper == 1 ? all : movers);
                if (certified) add(sums[t].certified, certified == 1 ? all : movers);
            }
        }
    });
    for (const Sums& s : sums) {
        record.off.nodes += s.off.nodes, record.off.tests += s.off.tests;
        record.paper.nodes += s.paper.nodes, record.paper.tests += s.paper.tests;
        record.certified.nodes += s.certified.nodes, record.certified.tests += s.certified.tests;
    }
}

// Percent of what every ray would have cost.
template <class Method>
CullingBenchResult::Saved saved(const std::vector<CullingFrame>& frames, Method CullingFrame::*method)
{
    CullingBenchResult::Saved result;
    const auto percent = [](std::uint64_t with, std::uint64_t without) {
        return without > 0 ? 100.0 - 100.0 * static_cast<double>(with) / static_cast<double>(without) : 0.0;
    };
    for (const CullingFrame& frame : frames) {
        const double nodes = percent((frame.*method).nodes, frame.off.nodes);
        const double tests = percent((frame.*method).tests, frame.off.tests);
        result.nodes_mean += nodes / static_cast<double>(frames.size());
        result.tests_mean += tests / static_cast<double>(frames.size());
        result.nodes_best = std::max(result.nodes_best, nodes);
        result.tests_best = std::max(result.tests_best, tests);
    }
    return result;
}

}   // namespace

CullingBenchResult bench_culling(const std::shared_ptr<const scene::Scene>& scene, const CullingBenchOptions& options,
                                 const std::function<void(const CullingFrame&)>& on_frame)
{
    using namespace shadow_culling;
    CullingBenchResult result;
    scene::SceneState state(scene, scene->timeline.time_of(options.frames.first));
    ray::RayScene rays(state);
    rays.keep_one_tree();
    Tasks tasks(options.threads);
    CertifiedOptions certified_options;
    certified_options.pixels_per_part = options.pixels_per_part;
    std::unique_ptr<CertifiedCulling> culling;
    if (options.certified) culling = std::make_unique<CertifiedCulling>(state, rays, certified_options);
    std::unique_ptr<PaperBench> paper;
    if (options.paper)
        paper = std::make_unique<PaperBench>(state, rays, tasks.threads(), options.paper_options,
                                             certified_options.ray_end);

    std::unique_ptr<ray::CountingKdTree> kdtree;
    if (options.counts) kdtree = std::make_unique<ray::CountingKdTree>(state, rays);

    const int lights = static_cast<int>(scene->lights.size());
    const int columns = (options.size.width + k_tile - 1) / k_tile, rows = (options.size.height + k_tile - 1) / k_tile;
    std::vector<TilePoints> tiles(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    std::vector<std::unique_ptr<CertifiedCulling::Batch>> batches;
    for (int t = 0; culling && t < tasks.threads(); ++t) batches.push_back(culling->make_batch());

    double off_sum = 0, certified_sum = 0;
    for (int frame = options.frames.first; frame <= options.frames.last; ++frame) {
        state.advance(scene->timeline.time_of(frame));
        rays.update(state);
        const render::View view = render::make_view(state, 0, options.size);
        if (paper) paper->clear_picture(options.size);
        tasks.for_each(tiles.size(), [&](std::size_t t, int) {
            const int at = static_cast<int>(t);
            trace_primary(view, rays, at % columns * k_tile, at / columns * k_tile, tiles[t], paper.get());
            tiles[t].off.assign(tiles[t].points.size() * static_cast<std::size_t>(lights), 1);
            if (paper) tiles[t].paper.assign(tiles[t].points.size() * static_cast<std::size_t>(lights), 1);
            tiles[t].certified.assign(tiles[t].points.size() * static_cast<std::size_t>(lights), 1);
            tiles[t].asked.assign(tiles[t].off.size(), 0);
            tiles[t].paper_rays.assign(options.counts ? tiles[t].off.size() : 0, 0);
            tiles[t].certified_rays.assign(options.counts ? tiles[t].off.size() : 0, 0);
        });
        CullingFrame record;
        record.frame = frame;

        // Off: every facing pair is a ray.
        std::vector<std::uint64_t> off_rays(static_cast<std::size_t>(tasks.threads()));
        std::vector<ray::RayQueue> queues(static_cast<std::size_t>(tasks.threads()));
        std::vector<std::vector<std::uint32_t>> whose(static_cast<std::size_t>(tasks.threads()));
        std::vector<std::vector<std::uint8_t>> answers(static_cast<std::size_t>(tasks.threads()));
        const auto for_facing = [&](const TilePoints& tile, int l, const auto& take) {
            const scene::Light& light = scene->lights[static_cast<std::size_t>(l)];
            const scene::LightState& at = state.light(static_cast<scene::LightId>(l));
            const bool directional = light.type == scene::LightType::directional;
            for (std::uint32_t p = 0; p < tile.points.size(); ++p) {
                const glm::vec3 d = directional ? -at.direction : at.position - tile.points[p].origin;
                if (!(glm::dot(d, tile.points[p].normal) > 0)) continue;
                // Outside a spot's cone nothing is asked.
                if (light.type == scene::LightType::spot &&
                    scene::illuminate(light, at, tile.points[p].origin).irradiance == glm::vec3(0))
                    continue;
                take(p, d, directional);
            }
        };
        const float end = certified_options.ray_end;
        double cpu = cpu_ms(), wall = wall_ms();
        tasks.for_each(tiles.size(), [&](std::size_t t, int w) {
            const auto worker = static_cast<std::size_t>(w);
            TilePoints& tile = tiles[t];
            for (int l = 0; l < lights; ++l) {
                queues[worker].clear();
                whose[worker].clear();
                for_facing(tile, l, [&](std::uint32_t p, const glm::vec3& d, bool directional) {
                    queues[worker].push(tile.points[p].origin, 0, d, directional ? k_infinity : end);
                    whose[worker].push_back(p);
                    tile.asked[static_cast<std::size_t>(l) * tile.points.size() + p] = 1;
                });
                const std::size_t count = queues[worker].size();
                off_rays[worker] += count;
                answers[worker].resize(count + ray::k_packet_pad);
                rays.blocked(queues[worker], 0, count, answers[worker].data(), ray::Against::one_tree);
                std::uint8_t* out = tile.off.data() + static_cast<std::size_t>(l) * tile.points.size();
                for (std::size_t i = 0; i < count; ++i) out[whose[worker][i]] = answers[worker][i];
            }
        });
        record.off.ms = cpu_ms() - cpu;
        record.off.wall_ms = wall_ms() - wall;
        for (const std::uint64_t n : off_rays) record.off.rays += n;

        if (paper) {
            // Paper: what Table 2 leaves to trace, the occlusion test, and the merge.
            cpu = cpu_ms(), wall = wall_ms();
            paper->begin_frame(state, rays);
            tasks.for_each(tiles.size(), [&](std::size_t t, int w) {
                paper->shadow(w, tiles[t].points, tiles[t].paper.data(),
                              options.counts ? tiles[t].paper_rays.data() : nullptr);
            });
            paper->end_frame();
            record.paper.ms = cpu_ms() - cpu;
            record.paper.wall_ms = wall_ms() - wall;
            const PaperCounters& p = paper->culling().counters();
            record.paper.rays = p.rays;
            record.paper.skipped = p.skipped;
            record.paper.dynamic_only = p.dynamic_only;
            record.paper.extra_tests_per_pixel = paper->extra_tests_per_pixel();
            for (const TilePoints& tile : tiles)
                for (std::size_t i = 0; i < tile.off.size(); ++i)
                    record.paper.wrong += tile.asked[i] && tile.off[i] != tile.paper[i];
            result.paper_extra_tests_per_pixel += record.paper.extra_tests_per_pixel;
            result.paper_wrong_mean += static_cast<double>(record.paper.wrong);
        }

        if (culling) {
            // Certified: look-ups, what rays are left, and the judging of what they saw.
            cpu = cpu_ms(), wall = wall_ms();
            culling->begin_frame(state, rays, {view.eye, view.pixel_spread, view.pixel_width});
            tasks.for_each(tiles.size(), [&](std::size_t t, int w) {
                const auto worker = static_cast<std::size_t>(w);
                TilePoints& tile = tiles[t];
                CertifiedCulling::Batch& batch = *batches[worker];
                culling->classify(batch, tile.points);
                for (int l = 0; l < lights; ++l) {
                    answers[worker].resize(tile.points.size() + 8);
                    culling->shadow(batch, l, answers[worker].data(),
                                    options.counts
                                        ? tile.certified_rays.data() + static_cast<std::size_t>(l) * tile.points.size()
                                        : nullptr);
                    std::copy_n(answers[worker].data(), tile.points.size(),
                                tile.certified.data() + static_cast<std::size_t>(l) * tile.points.size());
                }
            });
            const double before_judging = wall_ms();
            culling->end_frame(batches, tasks);
            record.certified.ms = cpu_ms() - cpu;
            record.certified.wall_ms = wall_ms() - wall;
            record.certified.judge_ms = wall_ms() - before_judging;
            const CullingCounters& c = culling->counters();
            record.certified.rays = record.off.rays;
            record.certified.dynamic_only = c.dynamic_only;
            record.certified.skipped = record.off.rays - c.traced - c.dynamic_only;
            record.certified.partial = c.partial;
            record.certified.certificates = c.certificates;
            record.certified.certified = c.certified;
            for (const TilePoints& tile : tiles)
                for (std::size_t i = 0; i < tile.off.size(); ++i)
                    record.certified.wrong += tile.asked[i] && tile.off[i] != tile.certified[i];
            result.wrong_total += record.certified.wrong;

            off_sum += record.off.ms;
            certified_sum += record.certified.ms;
            const double ratio = record.certified.wall_ms / record.off.wall_ms;
            if (result.frames.empty())
                result.first_frame_ratio = ratio;
            else
                result.worst_frame_ratio = std::max(result.worst_frame_ratio, ratio);
        }
        if (kdtree) {
            if (frame != options.frames.first) kdtree->update(state, rays);
            count_on_kdtree(*kdtree, state, end, tiles, tasks, record);
        }
        result.frames.push_back(record);
        if (on_frame) on_frame(record);
    }
    if (options.counts && options.paper) result.paper_saved = saved(result.frames, &CullingFrame::paper);
    if (options.counts && options.certified) result.certified_saved = saved(result.frames, &CullingFrame::certified);
    result.speedup_mean = certified_sum > 0 ? off_sum / certified_sum : 0;
    double off_late = 0, certified_late = 0;
    for (std::size_t f = result.frames.size() / 2; f < result.frames.size(); ++f) {
        off_late += result.frames[f].off.ms;
        certified_late += result.frames[f].certified.ms;
    }
    result.speedup_steady = certified_late > 0 ? off_late / certified_late : 0;
    if (!result.frames.empty()) {
        result.paper_extra_tests_per_pixel /= static_cast<double>(result.frames.size());
        result.paper_wrong_mean /= static_cast<double>(result.frames.size());
    }
    if (culling) {
        result.bytes = culling->bytes();
        result.visible_triangles = culling->visible_triangles();
    }
    return result;
}

}   // namespace gnomon::app
