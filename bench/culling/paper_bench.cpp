// SPDX-License-Identifier: Apache-2.0
#include "bench/culling/paper_bench.h"

#include "ray/origin.h"
#include "scene/light_reach.h"

namespace gnomon::bench {

using shadow_culling::PaperTracer;
using shadow_culling::ShadowPoint;

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

void PaperBench::begin_frame(const scene::SceneState& state, const ray::RayScene& rays)
{
    state_ = &state;
    rays_ = &rays;
    culling_.begin_frame(state, rays);
}

void PaperBench::shadow(int worker, std::span<const ShadowPoint> points, std::uint8_t* occluded, std::uint8_t* rays)
{
    Worker& w = workers_[static_cast<std::size_t>(worker)];
    const scene::Scene& scene = state_->scene();
    for (int l = 0; l < static_cast<int>(scene.lights.size()); ++l, occluded += points.size()) {
        const auto id = static_cast<scene::LightId>(l);
        const scene::LightReach light(scene.lights[id], state_->light(id));
        const float end = light.directional() ? k_infinity : ray::k_shadow_ray_end;

        // Queue a ray for every point that faces the light, within its cone.
        w.queue.clear();
        w.point.clear();
        w.origins.clear();
        for (std::uint32_t p = 0; p < points.size(); ++p) {
            const ShadowPoint& point = points[p];
            const glm::vec3 to_light = light.from(point.origin);
            if (!light.faces(to_light, point.normal) || light.dark_at(point.origin)) continue;
            w.queue.push(point.origin, 0, to_light, end);
            w.point.push_back(p);
            w.origins.push_back(culling_.primitive(point.object, point.triangle));
        }

        // Test the rays, and store the results by point.
        w.hit.resize(w.point.size());
        w.traced.resize(w.point.size());
        w.tracer.answer(culling_, *rays_, l, w.queue, w.origins, w.hit.data(), w.traced.data());
        for (std::size_t i = 0; i < w.point.size(); ++i) {
            occluded[w.point[i]] = w.hit[i];
            if (rays && w.traced[i]) rays[w.point[i]] = w.traced[i];
        }
        if (rays) rays += points.size();
    }
}

void PaperBench::end_frame()
{
    culling_.see_image(image_, static_cast<std::size_t>(width_));
    std::vector<PaperTracer::Notes> notes;
    for (Worker& worker : workers_) notes.push_back(worker.tracer.take_notes());
    culling_.end_frame(notes);
}

}   // namespace gnomon::bench
