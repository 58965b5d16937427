// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/paper_bench.h"

#include <algorithm>

#include "base/check.h"
#include "ray/origin.h"
#include "scene/light_reach.h"

namespace gnomon::bench {

using shadow_culling::PaperTracer;
using shadow_culling::PrimitiveId;
using shadow_culling::ShadowDecision;
using shadow_culling::ShadowPoint;
using shadow_culling::StaticPart;

PaperBench::PaperBench(const scene::SceneState& state, const ray::RayScene& rays, int threads,
                       const shadow_culling::PaperOptions& options)
    : state_(&state), rays_(&rays), culling_(state, rays, options), workers_(static_cast<std::size_t>(threads))
{
}

void PaperBench::clear_image(Size size)
{
    width_ = size.width;
    image_.assign(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), {});
}

void PaperBench::run(const scene::SceneState& state, const ray::RayScene& rays, std::span<const Batch> batches,
                     Tasks& tasks)
{
    state_ = &state;
    rays_ = &rays;
    culling_.begin_frame(state, rays);
    if (culling_.options().writes_at_once) {
        run_in_scanline_order(batches, tasks);
        return;
    }
    tasks.for_each(batches.size(), [&](std::size_t b, int worker) { shadow(worker, batches[b]); });
    culling_.see_image(image_, static_cast<std::size_t>(width_));
    std::vector<PaperTracer::Notes> notes;
    for (Worker& worker : workers_) notes.push_back(worker.tracer.take_notes());
    culling_.end_frame(notes);
}

// Calls take(point, to_light, end of the ray) for every point that faces the light, within its cone.
template <class Take>
void PaperBench::queue_facing(std::span<const ShadowPoint> points, scene::LightId id, Take&& take) const
{
    const scene::LightReach light(state_->scene().lights[id], state_->light(id));
    const float end = light.directional() ? k_infinity : ray::k_shadow_ray_end;
    for (std::uint32_t p = 0; p < points.size(); ++p) {
        const glm::vec3 to_light = light.from(points[p].origin);
        if (light.faces(to_light, points[p].normal) && !light.dark_at(points[p].origin)) take(p, to_light, end);
    }
}

void PaperBench::shadow(int worker, const Batch& batch)
{
    Worker& w = workers_[static_cast<std::size_t>(worker)];
    const std::span<const ShadowPoint> points = batch.points->points;
    for (scene::LightId l = 0; l < state_->scene().lights.size(); ++l) {
        w.queue.clear();
        w.point.clear();
        w.origins.clear();
        queue_facing(points, l, [&](std::uint32_t p, const glm::vec3& to_light, float end) {
            const ShadowPoint& from = points[p];
            w.queue.push(from.origin, 0, to_light, end);
            w.point.push_back(p);
            w.origins.push_back(culling_.primitive(from.object, from.triangle, from.u, from.v));
        });

        // Test the rays, and store the results by point.
        w.hit.resize(w.point.size());
        w.traced.resize(w.point.size());
        w.tracer.answer(culling_, *rays_, static_cast<int>(l), w.queue, w.origins, w.hit.data(), w.traced.data());
        for (std::size_t i = 0; i < w.point.size(); ++i) {
            const std::size_t at = l * points.size() + w.point[i];
            batch.occluded[at] = w.hit[i];
            if (batch.rays && w.traced[i]) batch.rays[at] = w.traced[i];
        }
    }
}

// What the rays of one batch find, by [light][point].
struct PaperBench::Found {
    static constexpr std::uint8_t k_asked = 1, k_by_static = 2, k_by_dynamic = 4;
    std::vector<std::uint8_t> bits;
    std::vector<PrimitiveId> origin;   // by point
};

void PaperBench::run_in_scanline_order(std::span<const Batch> batches, Tasks& tasks)
{
    GNOMON_CHECK(culling_.options().mobility == shadow_culling::PaperMobility::by_clip);
    const std::size_t lights = state_->scene().lights.size();

    // Trace every ray against static objects and against dynamic ones.
    std::vector<Found> found(batches.size());
    tasks.for_each(batches.size(), [&](std::size_t b, int worker) {
        Worker& w = workers_[static_cast<std::size_t>(worker)];
        const std::span<const ShadowPoint> points = batches[b].points->points;
        Found& f = found[b];
        f.bits.assign(points.size() * lights, 0);
        for (const ShadowPoint& p : points) f.origin.push_back(culling_.primitive(p.object, p.triangle, p.u, p.v));
        for (scene::LightId l = 0; l < lights; ++l) {
            w.queue.clear();
            w.point.clear();
            queue_facing(points, l, [&](std::uint32_t p, const glm::vec3& to_light, float end) {
                w.queue.push(points[p].origin, 0, to_light, end);
                w.point.push_back(p);
            });
            w.hit.resize(w.point.size() + ray::k_packet_pad);
            w.traced.resize(w.point.size() + ray::k_packet_pad);
            rays_->occluded(w.queue, 0, w.point.size(), w.hit.data(), ray::Against::static_only);
            rays_->occluded(w.queue, 0, w.point.size(), w.traced.data(), ray::Against::dynamic_only);
            for (std::size_t i = 0; i < w.point.size(); ++i)
                f.bits[l * points.size() + w.point[i]] = static_cast<std::uint8_t>(
                    Found::k_asked | (w.hit[i] ? Found::k_by_static : 0) | (w.traced[i] ? Found::k_by_dynamic : 0));
        }
    });

    // Sort the points by pixel. Within one, they stay in the order of depth.
    struct Place {
        std::uint32_t pixel, batch, point;
    };
    std::vector<Place> places;
    for (std::uint32_t b = 0; b < batches.size(); ++b)
        for (std::uint32_t p = 0; p < batches[b].points->points.size(); ++p)
            places.push_back({batches[b].points->pixel[p], b, p});
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.pixel < b.pixel; });

    // Per pixel: the occlusion test, and for each of its points and each light the shadow test and the shadow mode.
    PaperTracer::Notes notes;
    const auto width = static_cast<std::size_t>(width_);
    std::size_t next = 0;
    for (std::size_t pixel = 0; pixel < image_.size(); ++pixel) {
        const std::size_t x = pixel % width;
        const bool edge = x == 0 || x + 1 == width || pixel < width || pixel + width >= image_.size();
        culling_.see_pixel(image_[pixel], edge ? shadow_culling::no_primitive : image_[pixel - 1].primitive,
                           edge ? shadow_culling::no_primitive : image_[pixel - width].primitive, edge);
        for (; next < places.size() && places[next].pixel == pixel; ++next) {
            const Batch& batch = batches[places[next].batch];
            const Found& f = found[places[next].batch];
            const std::size_t point = places[next].point, points = f.origin.size();
            for (std::size_t l = 0; l < lights; ++l) {
                const std::size_t at = l * points + point;
                const std::uint8_t bits = f.bits[at];
                if (!(bits & Found::k_asked)) continue;
                const bool by_static = bits & Found::k_by_static, by_dynamic = bits & Found::k_by_dynamic;
                const int light = static_cast<int>(l);
                switch (culling_.decide(f.origin[point], light, notes)) {
                    case ShadowDecision::full_traversal:
                        batch.occluded[at] = by_static || by_dynamic;
                        if (batch.rays) batch.rays[at] = 1;
                        culling_.note(f.origin[point], light, by_static ? StaticPart::occluded : StaticPart::free,
                                      by_dynamic, notes);
                        break;
                    case ShadowDecision::dynamic_only:
                        batch.occluded[at] = by_dynamic;
                        if (batch.rays) batch.rays[at] = 2;
                        break;
                    case ShadowDecision::in_shadow:
                        batch.occluded[at] = 1;
                        break;
                    case ShadowDecision::lit:
                        batch.occluded[at] = 0;
                        break;
                }
            }
        }
    }
    culling_.end_frame({&notes, 1});
}

}   // namespace gnomon::bench
