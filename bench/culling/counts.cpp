// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/counts.h"

#include "ray/origin.h"
#include "ray/triangle_test.h"
#include "scene/light_reach.h"

namespace gnomon::bench {

namespace {

void add(ray::KdCounts& sum, const ray::KdCounts& part)
{
    sum.nodes += part.nodes;
    sum.tests += part.tests;
}

// What the rays of one point and light cost on the tree.
struct PairWork {
    ray::KdCounts all, clip_dynamic, dynamic;
    ray::Hit occluder;   // of the ray against everything, if it is opaque
};

// One tile's work by [light][point], for the pairs that face the light.
void trace_pairs(const ray::CountingKdTree& tree, const scene::SceneState& state, const CullingBenchOptions& options,
                 const CullingTile& tile, std::vector<PairWork>& work)
{
    using shadow_culling::PaperMobility;
    const scene::Scene& scene = state.scene();
    work.assign(tile.facing.size(), {});
    for (std::size_t l = 0; l < scene.lights.size(); ++l) {
        const auto id = static_cast<scene::LightId>(l);
        const scene::LightReach light(scene.lights[l], state.light(id));
        const float end = light.directional() ? k_infinity : ray::k_shadow_ray_end;
        for (std::size_t p = 0; p < tile.points.size(); ++p) {
            const std::size_t at = l * tile.points.size() + p;
            if (!tile.facing[at]) continue;
            const glm::vec3 origin = tile.points[p].origin, to_light = light.from(origin);
            PairWork& w = work[at];
            tree.occluded(origin, 0, to_light, end, ray::Against::everything, w.all, &w.occluder);

            bool asks_clip = tile.certified_rays[at] == 2, asks_dynamic = false;
            const auto ask = [&](std::uint8_t code, const shadow_culling::PaperOptions& reading) {
                if (code == 2) (reading.mobility == PaperMobility::by_clip ? asks_clip : asks_dynamic) = true;
            };
            ask(tile.paper_rays[at], options.paper_options);
            for (std::size_t r = 0; r < tile.readings.size(); ++r)
                ask(tile.readings[r].rays[at], options.readings[r].options);
            if (asks_clip) tree.occluded(origin, 0, to_light, end, ray::Against::dynamic_only, w.clip_dynamic);
            if (asks_dynamic) tree.occluded_by_dynamic(origin, 0, to_light, end, w.dynamic);
        }
    }
}

// Asks the last occluder first. Where it does not occlude, the ray is traced, and what it found is remembered.
class CachedRays {
 public:
    CachedRays(const ray::CountingKdTree& tree, const scene::SceneState& state, const ray::RayScene& rays,
               const ReadingCache& cache)
        : tree_(tree), state_(state), rays_(rays), cache_(cache)
    {
    }
    void trace(const shadow_culling::ShadowPoint& from, std::size_t l, const PairWork& work, ray::KdCounts& sum,
               CullingFrame::Paper& record)
    {
        const std::size_t primitive = cache_.culling->primitive(from.object, from.triangle, from.u, from.v);
        scene::ObjectId& object = cache_.occluders->object(primitive, l);
        std::uint32_t& triangle = cache_.occluders->triangle(primitive, l);
        if (object != scene::none) {
            ++sum.tests;
            ++record.cache_tests;
            if (occludes(object, triangle, from.origin, l)) {
                ++record.cache_hits;
                return;
            }
        }
        add(sum, work.all);
        if (work.occluder.object == scene::none || tree_.is_dynamic(work.occluder.object)) return;
        object = work.occluder.object, triangle = work.occluder.triangle;
    }

 private:
    bool occludes(scene::ObjectId object, std::uint32_t triangle, const glm::vec3& origin, std::size_t l) const
    {
        if (tree_.is_dynamic(object) || !state_.object_visible(object)) return false;
        const scene::LightReach light(state_.scene().lights[l], state_.light(static_cast<scene::LightId>(l)));
        glm::vec3 corners[3];
        rays_.geometry(object).corners(triangle, corners);
        ray::TriangleHit hit;
        return ray::meets(origin, light.from(origin), 0, light.directional() ? k_infinity : ray::k_shadow_ray_end,
                          corners, hit);
    }

    const ray::CountingKdTree& tree_;
    const scene::SceneState& state_;
    const ray::RayScene& rays_;
    const ReadingCache& cache_;
};

}   // namespace

void count_on_kdtree(const ray::CountingKdTree& tree, const scene::SceneState& state, const ray::RayScene& rays,
                     const CullingBenchOptions& options, const std::vector<CullingTile>& tiles,
                     std::span<const ReadingCache> caches, Tasks& tasks, CullingFrame& record)
{
    using shadow_culling::PaperMobility;

    // Trace the rays of each tile.
    std::vector<std::vector<PairWork>> work(tiles.size());
    tasks.for_each(tiles.size(), [&](std::size_t t, int) { trace_pairs(tree, state, options, tiles[t], work[t]); });

    // Sum what each method traced.
    ray::KdCounts off, paper, certified;
    std::vector<ray::KdCounts> readings(record.readings.size());
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        const CullingTile& tile = tiles[t];
        const auto of = [&](std::size_t at, std::uint8_t code, PaperMobility mobility) {
            const PairWork& w = work[t][at];
            return code == 0                            ? ray::KdCounts{}
                   : code == 1                          ? w.all
                   : mobility == PaperMobility::by_clip ? w.clip_dynamic
                                                        : w.dynamic;
        };
        for (std::size_t at = 0; at < tile.facing.size(); ++at) {
            if (!tile.facing[at]) continue;
            add(off, work[t][at].all);
            add(paper, of(at, tile.paper_rays[at], options.paper_options.mobility));
            add(certified, of(at, tile.certified_rays[at], PaperMobility::by_clip));
            for (std::size_t r = 0; r < readings.size(); ++r)
                if (!caches[r].occluders || tile.readings[r].rays[at] != 1)
                    add(readings[r], of(at, tile.readings[r].rays[at], options.readings[r].options.mobility));
        }
    }
    for (std::size_t r = 0; r < readings.size(); ++r) {
        if (!caches[r].occluders) continue;
        CachedRays cached(tree, state, rays, caches[r]);
        for (std::size_t t = 0; t < tiles.size(); ++t)
            for (std::size_t at = 0; at < tiles[t].facing.size(); ++at)
                if (tiles[t].facing[at] && tiles[t].readings[r].rays[at] == 1) {
                    const std::size_t points = tiles[t].points.size();
                    cached.trace(tiles[t].points[at % points], at / points, work[t][at], readings[r],
                                 record.readings[r]);
                }
    }

    record.off.nodes = off.nodes, record.off.tests = off.tests;
    record.paper.nodes = paper.nodes, record.paper.tests = paper.tests;
    record.certified.nodes = certified.nodes, record.certified.tests = certified.tests;
    for (std::size_t r = 0; r < readings.size(); ++r)
        record.readings[r].nodes = readings[r].nodes, record.readings[r].tests = readings[r].tests;
}

}   // namespace gnomon::bench
