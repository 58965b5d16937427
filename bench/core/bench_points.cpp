// SPDX-License-Identifier: Apache-2.0
#include "bench/core/bench_points.h"

#include <algorithm>

#include "trace/traced_frame.h"

namespace gnomon::bench {

void PointTracer::trace(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view, int x0,
                        int y0, int max_depth, BenchPoints& out, ray::RayQueue* rays_log)
{
    out.points.clear();
    out.pixels.clear();
    out.diffuse.clear();
    out.pixel.clear();
    out.reflected_rays = out.refracted_rays = 0;
    const auto log = [&] {
        for (std::size_t i = 0; rays_log && i < queue_.size(); ++i)
            rays_log->push(queue_.origin(i), queue_.tnear[i], queue_.direction(i), queue_.tfar[i]);
    };
    queue_primary(view, x0, y0);
    log();
    follow(state, rays, true, out);
    out.primary = out.points.size();
    for (int depth = 0; depth < max_depth; ++depth) {
        queue_continuations();
        if (queue_.empty()) break;
        out.reflected_rays += reflected_;
        out.refracted_rays += refracted_;
        log();
        follow(state, rays, false, out);
    }
}

// Queues the primary rays in blocks of 4 x 2 pixels, so that packets are coherent.
void PointTracer::queue_primary(const scene::View& view, int x0, int y0)
{
    queue_.clear();
    paths_.clear();
    pixels_.clear();
    for (int i = 0; i < k_tile * k_tile; ++i) {
        const int in_block = i % 8, block = i / 8;
        const int x = x0 + (block % (k_tile / 4)) * 4 + in_block % 4;
        const int y = y0 + (block / (k_tile / 4)) * 2 + in_block / 4;
        if (x >= view.size.width || y >= view.size.height) continue;
        glm::vec3 origin, direction;
        float tnear, tfar;
        view.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, origin, direction, tnear, tfar);
        queue_.push(origin, tnear, direction, tfar);
        paths_.push_back(
            {glm::vec3(1), {view.pixel_width, view.pixel_spread}, static_cast<std::uint32_t>(y * view.size.width + x)});
        pixels_.emplace_back(x, y);
    }
}

// Traces the queued rays and computes the surface points that they hit.
void PointTracer::follow(const scene::SceneState& state, const ray::RayScene& rays, bool primary, BenchPoints& out)
{
    shaded_.clear();
    if (queue_.empty()) return;
    hits_.resize(queue_.size());
    rays.closest(queue_, 0, queue_.size(), hits_, ray::Sides::front);
    for (std::size_t i = 0; i < queue_.size(); ++i) {
        if (hits_.object[i] == scene::none) continue;
        Continued& here = shaded_.emplace_back();
        here.throughput = paths_[i].throughput;
        here.pixel = paths_[i].pixel, here.splits = paths_[i].splits;
        shading::SurfacePoint& s = here.surface;
        shading::surface_at(state.scene(), rays.geometry(hits_.object[i]), hits_.triangle[i], hits_.u[i], hits_.v[i],
                            hits_.t[i], queue_.direction(i), paths_[i].cone, s);
        // Give an unlit surface no normal, so that it faces no light.
        const bool lit = s.model != scene::ShadingModel::unlit;
        out.points.push_back({s.position + s.offset * s.geometric_normal, lit ? s.geometric_normal : glm::vec3(0),
                              hits_.object[i], hits_.triangle[i], hits_.u[i], hits_.v[i], s.winding_front});
        out.pixel.push_back(here.pixel);
        if (!primary) continue;
        out.pixels.push_back({pixels_[i].first, pixels_[i].second, hits_.object[i], hits_.triangle[i], hits_.u[i],
                              hits_.v[i], queue_.origin(i), queue_.direction(i)});
        out.diffuse.push_back(s.diffuse + s.specular);
    }
}

// Queues the rays that continue from the latest points, reflected rays first.
void PointTracer::queue_continuations()
{
    const float min_throughput = trace::TracedOptions{}.min_throughput;
    queue_.clear();
    paths_.clear();
    const auto push = [&](const Continued& from, const glm::vec3& weight, float side, const glm::vec3& direction,
                          std::uint8_t splits) {
        const shading::SurfacePoint& s = from.surface;
        const glm::vec3 total = from.throughput * weight;
        if (std::max({total.x, total.y, total.z}) < min_throughput) return;
        queue_.push(s.position + side * (s.offset * s.geometric_normal), 0, direction, k_infinity);
        paths_.push_back({total, s.cone, from.pixel, splits});
    };
    std::vector<shading::Continuation> next;
    next.reserve(shaded_.size());
    for (Continued& point : shaded_) {
        shading::Continuation& c = next.emplace_back(shading::continue_from(point.surface));
        point.next =
            trace::split_path(point.throughput, min_throughput, point.splits, c.reflected_weight, c.refracted_weight);
    }
    for (std::size_t i = 0; i < shaded_.size(); ++i)
        push(shaded_[i], next[i].reflected_weight, 1, next[i].reflected, shaded_[i].next.reflected);
    reflected_ = queue_.size();
    for (std::size_t i = 0; i < shaded_.size(); ++i) {
        push(shaded_[i], next[i].refracted_weight, -1, next[i].refracted, shaded_[i].next.refracted);
        push(shaded_[i], next[i].straight_weight, -1, -shaded_[i].surface.to_viewer, shaded_[i].splits);
    }
    refracted_ = queue_.size() - reflected_;
}

}   // namespace gnomon::bench
