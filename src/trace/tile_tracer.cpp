// SPDX-License-Identifier: Apache-2.0
#include "trace/tile_tracer.h"

#include <algorithm>

#include "base/interruption.h"
#include "base/morton.h"
#include "ray/origin.h"
#include "scene/light_reach.h"
#include "shading/glossy.h"

namespace gnomon::trace {

namespace {

float largest(const glm::vec3& v)
{
    return std::max({v.x, v.y, v.z});
}

}   // namespace

TileTracer::TileTracer(const FrameContext& frame, const TracedOptions& options, ShadowTester& shadows,
                       const SizedTechnique& sized, EnvironmentTechnique* environment, IndirectLight* indirect,
                       TraceLog* log)
    : state_(frame.state),
      scene_(frame.state.scene()),
      rays_(frame.rays),
      view_(frame.view),
      options_(options),
      indirect_light_(indirect),
      shadows_(shadows.make_worker()),
      indirect_(indirect ? indirect->make_worker() : nullptr),
      is_estimate_(indirect && indirect->is_estimate()),
      log_(log)
{
    if (sized.lights) sized_.emplace(*sized.lights, *sized.visibility, rays_);
    if (environment) environment_.emplace(*environment, rays_);
    sees_image_ = environment_ && environment_->has_image();
    thins_light_ = rays_.thins_light();
    primary_.rays.purpose = ray::RayClass::primary;
    for (PathQueue* queue : {&reflected_, &next_reflected_}) queue->rays.purpose = ray::RayClass::reflection;
    for (PathQueue* queue : {&refracted_, &next_refracted_}) queue->rays.purpose = ray::RayClass::refraction;
}

void TileTracer::trace(const Tile& tile, shading::FrameBuffers& out)
{
    begin_tile(tile);
    for (int sample = 0; sample < options_.samples; ++sample) {
        interruption_point();
        Stopwatch watch(times_);

        // Trace the pixels' rays, and shade what they hit.
        queue_primary(sample);
        clear_points();
        trace_queue(primary_);
        watch.end(FrameTimes::rays);
        if (sample == 0) shadows_->note_primary_hits({primary_.rays, hits_, primary_.paths, tile_});
        shade_hits(primary_, true, sample);
        watch.end(FrameTimes::surfaces);
        add_lights(batch(true, sample), watch);
        add_sized_lights(batch(true, sample), watch);
        add_environment(batch(true, sample), watch);
        add_indirect(batch(true, sample));
        watch.end(FrameTimes::indirect);

        // Do the same for mirrored and refracted rays, one depth after the other.
        for (int depth = 0; depth < options_.max_depth; ++depth) {
            interruption_point();
            queue_continuations();
            if (reflected_.rays.empty() && refracted_.rays.empty()) break;
            counters_.reflection_rays += reflected_.rays.size();
            counters_.refraction_rays += refracted_.rays.size();
            clear_points();
            for (const PathQueue* queue : {&reflected_, &refracted_}) {
                trace_queue(*queue);
                watch.end(FrameTimes::rays);
                shade_hits(*queue, false, sample);
                watch.end(FrameTimes::surfaces);
            }
            add_lights(batch(false, sample), watch);
            add_sized_lights(batch(false, sample), watch);
            add_environment(batch(false, sample), watch);
            add_indirect(batch(false, sample));
            watch.end(FrameTimes::indirect_mirrored);
        }
    }
    store(out);
}

void TileTracer::begin_tile(const Tile& tile)
{
    tile_ = tile;
    if (indirect_) indirect_->begin_tile(tile);
    const auto pixels = static_cast<std::size_t>(tile.side) * static_cast<std::size_t>(tile.side);
    color_.assign(pixels, glm::vec3(0));
    if (options_.layers) {
        for (auto* layer : {&direct_, &indirect_color_, &albedo_, &normal_}) layer->assign(pixels, glm::vec3(0));
        depth_.assign(pixels, 0);
        shadow_.assign(pixels * scene_.lights.size(), 0);
    }
    if (is_estimate_)
        for (auto* layer : {&first_irradiance_, &first_variance_, &variance_}) layer->assign(pixels, glm::vec3(0));
}

void TileTracer::clear_points()
{
    points_.clear();
    shadow_points_.clear();
    normals_.clear();
}

PointBatch TileTracer::batch(bool primary, int sample) const
{
    return {points_, shadow_points_, normals_, tile_, primary, sample == 0};
}

// Queues primary rays in Morton order, so that a packet covers a block of 4 x 2 or 4 x 4 pixels.
void TileTracer::queue_primary(int sample)
{
    primary_.clear();
    const glm::vec2 offset = scene::sample_offset(sample, options_.samples);
    const auto count = static_cast<std::uint32_t>(tile_.side * tile_.side);
    for (std::uint32_t code = 0; code < count; ++code) {
        const int x = static_cast<int>(even_bits(code)), y = static_cast<int>(even_bits(code >> 1));
        if (x >= tile_.width || y >= tile_.height) continue;
        glm::vec3 origin, direction;
        float tnear, tfar;
        view_.ray(static_cast<float>(tile_.x + x) + offset.x, static_cast<float>(tile_.y + y) + offset.y, origin,
                  direction, tnear, tfar);
        const Path path{
            static_cast<std::uint32_t>(y * tile_.side + x), glm::vec3(1), {view_.pixel_width, view_.pixel_spread}};
        primary_.push(path, origin, tnear, direction, tfar);
    }
    counters_.primary_rays += primary_.rays.size();
}

void TileTracer::trace_queue(const PathQueue& queue)
{
    if (queue.rays.empty()) return;
    hits_.resize(queue.rays.size());
    rays_.closest(queue.rays, 0, queue.rays.size(), hits_, ray::Sides::front);
    if (log_) log_->entries.push_back({queue.rays, false});
}

// Orders hits by object, and those of an object as in the queue. Neighbours in the shadow queues then start on the same
// surface, and materials and textures are used in runs.
void TileTracer::sort_hits(std::size_t count)
{
    order_.resize(count);
    bool sorted = true;
    for (std::size_t i = 0; i < count; ++i) {
        order_[i] = (static_cast<std::uint64_t>(hits_.object[i]) << 32) | i;
        sorted = sorted && (i == 0 || order_[i - 1] < order_[i]);
    }
    if (!sorted) std::sort(order_.begin(), order_.end());
}

void TileTracer::shade_hits(const PathQueue& queue, bool primary, int sample)
{
    const std::size_t count = queue.rays.size();
    sort_hits(count);
    for (const std::uint64_t key : order_) {
        const auto i = static_cast<std::uint32_t>(key);
        const Path& path = queue.paths[i];
        const glm::vec3 direction = queue.rays.direction(i);

        // Add the background where the ray left the scene.
        if (hits_.object[i] == scene::none) {
            if (!path.sees_no_light && path.background > 0)
                color_[path.pixel] += path.throughput * (path.background * scene_.background.radiance(direction));
            continue;
        }
        TilePoint& point = points_.emplace_back();
        shading::surface_at(scene_, rays_.geometry(hits_.object[i]), hits_.triangle[i], hits_.u[i], hits_.v[i],
                            hits_.t[i], direction, path.cone, point.surface);
        point.pixel = path.pixel;
        point.throughput = path.throughput;
        point.parts = path.parts;
        const shading::SurfacePoint& s = point.surface;
        if (s.layered) point.throughput *= shading::attenuation(s, hits_.t[i]);

        point.next = shading::continue_from(s);
        if (indirect_light_ && indirect_light_->reflects_lobes() && shading::has_glossy_lobe(s)) {
            point.glossy = true;
            point.next.unresolved_weight = glm::vec3(point.next.coat_unresolved);
        }

        // Add what needs no ray: emission, ambient light, blurred mirror images of the sky.
        glm::vec3 own(0);
        const bool unlit = s.model == scene::ShadingModel::unlit;
        if (!path.sees_no_light || unlit) own += s.emissive * (s.coverage * (unlit ? 1.0f : path.emission));
        own += shading::ambient_light(s, scene_, !indirect_light_,
                                      !(indirect_light_ && indirect_light_->has_further_bounces()));
        if (!sees_image_ && point.next.unresolved_weight != glm::vec3(0))
            own += point.next.unresolved_weight * scene_.background.ambient(point.next.reflected);
        color_[path.pixel] += point.throughput * own;
        if (primary && options_.layers) {
            albedo_[path.pixel] += s.diffuse + s.specular;
            if (sample == 0) {
                normal_[path.pixel] = s.normal;
                depth_[path.pixel] = hits_.t[i] * glm::dot(direction, view_.forward);
            }
        }
        // An unlit surface faces no light.
        shadow_points_.push_back({s.position + s.offset * s.geometric_normal, unlit ? glm::vec3(0) : s.geometric_normal,
                                  hits_.object[i], hits_.triangle[i], hits_.u[i], hits_.v[i], s.winding_front});
        normals_.push_back(s.normal);
    }
}

// Finds, light by light, the points that it reaches, and adds its light there.
void TileTracer::add_lights(const PointBatch& batch, Stopwatch& watch)
{
    const std::size_t lights = scene_.lights.size();
    shadows_->prepare(batch);
    watch.end(FrameTimes::shadows);
    for (std::size_t l = 0; l < lights; ++l) {
        const scene::Light& light = scene_.lights[l];
        const scene::LightState& at = state_.light(static_cast<scene::LightId>(l));
        if (!at.visible || light.color == glm::vec3(0)) continue;
        if (indirect_light_ && indirect_light_->replaces(light)) continue;
        if ((sized_ && light.of_surface) || (sees_image_ && light.of_environment)) continue;
        if (environment_ && environment_->has_sun(static_cast<scene::LightId>(l))) continue;
        interruption_point();
        lit_.clear();
        shadows_->find_lit(batch, static_cast<scene::LightId>(l), lit_);
        if (thins_light_) find_passing(light, at);
        watch.end(FrameTimes::shadows);
        for (std::size_t k = 0; k < lit_.size(); ++k) {
            const TilePoint& point = points_[lit_[k]];
            scene::LightSample sample = scene::illuminate(light, at, point.surface.position);
            if (thins_light_) sample.irradiance *= passes_[k];
            const auto reflect = light.of_environment ? shading::reflect_surroundings : shading::reflect_light;
            const glm::vec3 radiance = point.throughput * reflect(point.surface, sample.to_light, sample.irradiance);
            color_[point.pixel] += radiance;
            if (batch.primary && options_.layers) {
                direct_[point.pixel] += radiance;
                shadow_[point.pixel * lights + l] += thins_light_ ? luminance(passes_[k]) : 1;
            }
        }
        watch.end(FrameTimes::surfaces);
    }
}

void TileTracer::find_passing(const scene::Light& light, const scene::LightState& at)
{
    const scene::LightReach reach(light, at);
    const float end = reach.directional() ? k_infinity : ray::k_shadow_ray_end;
    passing_.clear();
    for (const std::uint32_t p : lit_) {
        const glm::vec3& origin = shadow_points_[p].origin;
        passing_.push(origin, 0, reach.from(origin), end);
    }
    passes_.resize(lit_.size());
    rays_.let_through(passing_, 0, passing_.size(), passes_.data());
}

// Adds the direct light of emissive surfaces.
void TileTracer::add_sized_lights(const PointBatch& batch, Stopwatch& watch)
{
    if (!sized_) return;
    sized_->light(batch, [&](const TilePoint& point, const glm::vec3& reflected) {
        const glm::vec3 radiance = point.throughput * reflected;
        color_[point.pixel] += radiance;
        if (batch.primary && options_.layers) direct_[point.pixel] += radiance;
    });
    watch.end(FrameTimes::shadows);
}

// Adds the direct light of the environment image and of suns.
void TileTracer::add_environment(const PointBatch& batch, Stopwatch& watch)
{
    if (!environment_) return;
    const int columns = (view_.size.width + options_.tile - 1) / options_.tile;
    const auto tile = static_cast<std::size_t>(tile_.y / options_.tile * columns + tile_.x / options_.tile);
    const std::size_t lights = scene_.lights.size();
    environment_->light_by_suns(batch, tile, state_,
                                [&](const TilePoint& point, const glm::vec3& reflected, scene::LightId l, float share) {
                                    const glm::vec3 radiance = point.throughput * reflected;
                                    color_[point.pixel] += radiance;
                                    if (!batch.primary || !options_.layers) return;
                                    direct_[point.pixel] += radiance;
                                    shadow_[point.pixel * lights + l] += share;
                                });
    if (sees_image_)
        environment_->light(batch, tile, [&](const TilePoint& point, const glm::vec3& reflected) {
            const glm::vec3 radiance = point.throughput * reflected;
            color_[point.pixel] += radiance;
            if (batch.primary && options_.layers) direct_[point.pixel] += radiance;
        });
    watch.end(FrameTimes::shadows);
}

// Adds light that arrives by bounces.
void TileTracer::add_indirect(const PointBatch& batch)
{
    if (!indirect_) return;
    interruption_point();
    indirect_->gather(batch, arrives_);
    for (std::size_t k = 0; k < arrives_.point.size(); ++k) {
        const TilePoint& point = points_[arrives_.point[k]];
        const auto reflected = [&](const glm::vec3& indirect, const glm::vec3& surroundings) {
            if (!point.glossy)
                return point.throughput * reflect_irradiance(point.surface, point.next, indirect, surroundings);
            // What the lobe does not reflect reaches the diffuse layer.
            const glm::vec3 below = glm::vec3(1) - shading::glossy_albedo(point.surface);
            const shading::Continuation none;
            return point.throughput * (reflect_irradiance(point.surface, point.next, indirect, glm::vec3(0)) +
                                       below * reflect_irradiance(point.surface, none, glm::vec3(0), surroundings));
        };
        const glm::vec3 surroundings = is_estimate_ ? arrives_.surroundings[k] : glm::vec3(0);
        color_[point.pixel] += reflected(arrives_.irradiance[k], surroundings);
        // An environment image counts as direct light, as do the lights that approximate it; the sky does not.
        const bool sky = scene_.background.kind == scene::Background::Kind::sky;
        if (batch.primary && options_.layers) {
            indirect_color_[point.pixel] += reflected(arrives_.irradiance[k], sky ? surroundings : glm::vec3(0));
            if (is_estimate_) direct_[point.pixel] += reflected(glm::vec3(0), sky ? glm::vec3(0) : surroundings);
        }
        if (!is_estimate_) continue;
        const glm::vec3 error = reflected(arrives_.error[k], glm::vec3(0));
        variance_[point.pixel] += error * error;
        if (!batch.primary) continue;
        first_irradiance_[point.pixel] += arrives_.irradiance[k];
        first_variance_[point.pixel] += arrives_.irradiance_error[k] * arrives_.irradiance_error[k];
    }
    if (!indirect_light_->reflects_lobes()) return;
    for (std::size_t k = 0; k < arrives_.lobe_point.size(); ++k) {
        const TilePoint& point = points_[arrives_.lobe_point[k]];
        color_[point.pixel] += point.throughput * arrives_.lobe_radiance[k];
        const glm::vec3 error = point.throughput * arrives_.lobe_error[k];
        variance_[point.pixel] += error * error;
    }
}

// Queues the mirrored and refracted rays from the points just shaded, each kind by itself.
void TileTracer::queue_continuations()
{
    next_reflected_.clear();
    next_refracted_.clear();
    for (const TilePoint& point : points_) {
        const shading::SurfacePoint& s = point.surface;
        const shading::Continuation& c = point.next;
        const glm::vec3 lift = s.offset * s.geometric_normal;
        const auto queue = [&](PathQueue& to, const glm::vec3& weight, const glm::vec3& origin,
                               const glm::vec3& direction, bool sees_no_light = false, float emission = 1,
                               float background = 1) {
            const glm::vec3 throughput = point.throughput * weight;
            if (largest(throughput) * point.parts < options_.min_throughput) return;
            to.push({point.pixel, throughput, s.cone, sees_no_light, emission, background, point.parts}, origin, 0,
                    direction, k_infinity);
        };
        if (s.layered) {
            queue_layered(point, lift);
        } else {
            queue(next_reflected_, c.reflected_weight, s.position + lift, c.reflected, point.glossy,
                  sized_ ? 1 - highlight_share(s) : 1, sees_image_ ? 1 - highlight_share(s) : 1);
            queue(next_refracted_, c.refracted_weight, s.position - lift, c.refracted);
        }
        queue(next_refracted_, c.straight_weight, s.position - lift, -s.to_viewer);
    }
    std::swap(reflected_, next_reflected_);
    std::swap(refracted_, next_refracted_);
}

// Queues the rays of a layered surface. Its coat always shows lights by the mirrored ray; rough transmission takes
// several rays.
void TileTracer::queue_layered(const TilePoint& point, const glm::vec3& lift)
{
    const shading::SurfacePoint& s = point.surface;
    const shading::Continuation& c = point.next;
    Path path{point.pixel, point.throughput * c.reflected_weight, s.cone};
    path.parts = point.parts;
    if (largest(path.throughput) * path.parts >= options_.min_throughput) {
        const float coat = std::clamp(c.coat_reflected / largest(c.reflected_weight), 0.0f, 1.0f);
        const auto shown = [&](bool by_lobe) {
            const float base = point.glossy ? 0 : by_lobe ? 1 - highlight_share(s) : 1;
            return coat + (1 - coat) * base;
        };
        path.emission = shown(sized_.has_value()), path.background = shown(sees_image_);
        next_reflected_.push(path, s.position + lift, 0, c.reflected, k_infinity);
    }
    shading::find_transmitted(s, c, point.parts > 1, transmitted_);
    for (const shading::TransmittedRay& ray : transmitted_) {
        Path through{point.pixel, point.throughput * c.refracted_weight * ray.part, s.cone};
        through.parts = ray.spread > 0 ? point.parts * static_cast<float>(transmitted_.size()) : point.parts;
        if (largest(through.throughput) * through.parts < options_.min_throughput) continue;
        through.cone.spread += ray.spread;
        next_refracted_.push(through, s.position - lift, 0, ray.direction, k_infinity);
    }
}

void TileTracer::store(shading::FrameBuffers& out) const
{
    const float weight = 1.0f / static_cast<float>(options_.samples);
    const std::size_t lights = scene_.lights.size();
    const auto put = [](ImageF& image, int x, int y, const glm::vec3& value) {
        float* to = image.pixel(x, y);
        to[0] = value.x, to[1] = value.y, to[2] = value.z;
    };
    for (int y = 0; y < tile_.height; ++y)
        for (int x = 0; x < tile_.width; ++x) {
            const auto from =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(tile_.side) + static_cast<std::size_t>(x);
            const int px = tile_.x + x, py = tile_.y + y;
            put(out.color, px, py, color_[from] * weight);
            if (is_estimate_) {
                put(out.variance, px, py, variance_[from] * (weight * weight));
                put(out.irradiance, px, py, first_irradiance_[from] * weight);
                put(out.irradiance_variance, px, py, first_variance_[from] * (weight * weight));
            }
            if (!options_.layers) continue;
            put(out.direct, px, py, direct_[from] * weight);
            put(out.indirect, px, py, indirect_color_[from] * weight);
            put(out.albedo, px, py, albedo_[from] * weight);
            put(out.normal, px, py, normal_[from]);
            out.depth.pixel(px, py)[0] = depth_[from];
            for (std::size_t l = 0; l < lights; ++l) out.shadow.pixel(px, py)[l] = shadow_[from * lights + l] * weight;
        }
}

}   // namespace gnomon::trace
