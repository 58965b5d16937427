// SPDX-License-Identifier: Apache-2.0
#include "app/paper_bench.h"

namespace gnomon::app {

using shadow_culling::PaperCulling;
using shadow_culling::ShadowDecision;
using shadow_culling::ShadowPoint;
using shadow_culling::StaticPart;

PaperBench::PaperBench(const scene::SceneState& state, const ray::RayScene& rays, int threads,
                       const shadow_culling::PaperOptions& options, float ray_end)
    : state_(&state),
      rays_(&rays),
      culling_(state, rays, options),
      ray_end_(ray_end),
      notes_(static_cast<std::size_t>(threads)),
      workers_(static_cast<std::size_t>(threads))
{
}

void PaperBench::clear_picture(Size size)
{
    width_ = size.width;
    picture_.assign(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), {});
}

void PaperBench::begin_frame(const scene::SceneState& state, const ray::RayScene& rays)
{
    state_ = &state;
    rays_ = &rays;
    culling_.begin_frame(state, rays);
}

void PaperBench::shadow(int worker, std::span<const ShadowPoint> points, std::uint8_t* blocked, std::uint8_t* rays)
{
    Worker& w = workers_[static_cast<std::size_t>(worker)];
    PaperCulling::Notes& notes = notes_[static_cast<std::size_t>(worker)];
    const scene::Scene& scene = state_->scene();
    for (int l = 0; l < static_cast<int>(scene.lights.size()); ++l, blocked += points.size()) {
        const scene::LightState& at = state_->light(static_cast<scene::LightId>(l));
        const bool directional = scene.lights[static_cast<std::size_t>(l)].type == scene::LightType::directional;
        w.full.clear(), w.moving.clear();
        w.full_point.clear(), w.moving_point.clear();

        // Sort the points by what Table 2 says of their rays.
        for (std::uint32_t p = 0; p < points.size(); ++p) {
            const ShadowPoint& point = points[p];
            const glm::vec3 d = directional ? -at.direction : at.position - point.origin;
            if (!(glm::dot(d, point.normal) > 0)) continue;
            const float end = directional ? k_infinity : ray_end_;
            switch (culling_.decide(culling_.primitive(point.object, point.triangle), l, notes)) {
                case ShadowDecision::in_shadow:
                    blocked[p] = 1;
                    break;
                case ShadowDecision::dynamic_only:
                    w.moving.push(point.origin, 0, d, end);
                    w.moving_point.push_back(p);
                    break;
                case ShadowDecision::full_traversal:
                    w.full.push(point.origin, 0, d, end);
                    w.full_point.push_back(p);
                    break;
            }
        }
        if (rays) {
            for (const std::uint32_t p : w.full_point) rays[p] = 1;
            for (const std::uint32_t p : w.moving_point) rays[p] = 2;
            rays += points.size();
        }
        trace_full(w, notes, l, points, blocked);
        w.hit.resize(w.moving.size() + ray::k_packet_pad);
        rays_->blocked(w.moving, 0, w.moving.size(), w.hit.data(), ray::Against::dynamic_only);
        for (std::size_t i = 0; i < w.moving.size(); ++i) blocked[w.moving_point[i]] = w.hit[i];
    }
}

// Static objects first: only so is it known what they did to a ray that something dynamic blocks, too.
void PaperBench::trace_full(Worker& w, PaperCulling::Notes& notes, int light, std::span<const ShadowPoint> points,
                            std::uint8_t* blocked)
{
    w.hit.resize(w.full.size() + ray::k_packet_pad);
    rays_->blocked(w.full, 0, w.full.size(), w.hit.data(), ray::Against::static_only);
    // What the static objects let pass meets the dynamic ones; those rays move to the front of the queue.
    ray::RayQueue& rays = w.full;
    std::size_t passed = 0;
    for (std::size_t i = 0, count = rays.size(); i < count; ++i) {
        const std::uint32_t p = w.full_point[i];
        if (w.hit[i]) {
            blocked[p] = 1;
            culling_.note(culling_.primitive(points[p].object, points[p].triangle), light, StaticPart::blocked, false,
                          notes);
            continue;
        }
        for (auto* a : {&rays.ox, &rays.oy, &rays.oz, &rays.tnear, &rays.dx, &rays.dy, &rays.dz, &rays.tfar})
            (*a)[passed] = (*a)[i];
        w.full_point[passed++] = p;
    }
    rays_->blocked(rays, 0, passed, w.hit.data(), ray::Against::dynamic_only);
    for (std::size_t i = 0; i < passed; ++i) {
        const std::uint32_t p = w.full_point[i];
        blocked[p] = w.hit[i];
        culling_.note(culling_.primitive(points[p].object, points[p].triangle), light, StaticPart::free, w.hit[i] != 0,
                      notes);
    }
}

void PaperBench::end_frame()
{
    culling_.see_picture(picture_, static_cast<std::size_t>(width_));
    culling_.end_frame(notes_);
}

}   // namespace gnomon::app
