// SPDX-License-Identifier: Apache-2.0
#include "trace/tile_tracer.h"

#include <algorithm>
#include <cmath>

#include "base/morton.h"
#include "base/stopwatch.h"
#include "ray/origin.h"
#include "scene/light_reach.h"

namespace gnomon::trace {

namespace {

constexpr int k_least_paths = 2;   // of a point that a reference is asked about: fewer have no spread

float largest_share(const glm::vec3& share)
{
    return std::max({share.x, share.y, share.z});
}

}   // namespace

TileTracer::TileTracer(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                       const TracedOptions& options, const Remembered& remembered,
                       shadow_culling::PrimaryHit* primary_hits, TraceLog* log)
    : state_(state),
      scene_(state.scene()),
      rays_(rays),
      view_(view),
      options_(options),
      culling_(remembered.certified),
      visible_(remembered.visible),
      map_(remembered.map),
      paper_(remembered.paper),
      primary_hits_(primary_hits),
      states_(remembered.states),
      log_(log)
{
    primary_.rays.purpose = ray::RayClass::primary;
    for (PathQueue* queue : {&reflected_, &next_reflected_}) queue->rays.purpose = ray::RayClass::reflection;
    for (PathQueue* queue : {&refracted_, &next_refracted_}) queue->rays.purpose = ray::RayClass::refraction;
    if (culling_) batch_ = culling_->make_batch();
    if (visible_) indirect_batch_ = visible_->make_batch();
    if (options_.reference) paths_ = std::make_unique<reference::ReferencePaths>(*options_.reference);
    if (map_) map_batch_ = std::make_unique<light_quadtree::MapLight::Batch>();
    if (states_) counters_.shadow.rays_wrong = 0;
}

void TileTracer::trace(const TileRect& tile, shading::FrameBuffers& out)
{
    const auto pixels = static_cast<std::size_t>(options_.tile) * options_.tile;
    color_.assign(pixels, glm::vec3(0));
    if (options_.layers) {
        direct_.assign(pixels, glm::vec3(0));
        indirect_.assign(pixels, glm::vec3(0));
        albedo_.assign(pixels, glm::vec3(0));
        normal_.assign(pixels, glm::vec3(0));
        depth_.assign(pixels, 0);
        shadow_.assign(pixels * scene_.lights.size(), 0);
    }
    if (options_.reference) {
        first_irradiance_.assign(pixels, glm::vec3(0));
        first_variance_.assign(pixels, glm::vec3(0));
        variance_.assign(pixels, glm::vec3(0));
        points_of_pixel_.assign(pixels, 0);
    }

    for (int sample = 0; sample < options_.samples; ++sample) {
        Stopwatch watch(times_);
        queue_primary(tile, sample);
        points_.clear();
        shadow_points_.clear();
        shading_normals_.clear();
        trace_queue(primary_);
        watch.end(FrameTimes::rays);
        if (paper_ && sample == 0) note_primary_hits(tile);
        shade_hits(primary_, true, sample);
        watch.end(FrameTimes::surfaces);
        light_points(true, tile, states_ && sample == 0, watch);
        bounce_light(true, tile);
        add_reference(tile, true);
        watch.end(FrameTimes::indirect);

        for (int depth = 0; depth < options_.max_depth; ++depth) {
            queue_continuations();
            if (reflected_.rays.empty() && refracted_.rays.empty()) break;
            counters_.reflection_rays += reflected_.rays.size();
            counters_.refraction_rays += refracted_.rays.size();
            points_.clear();
            shadow_points_.clear();
            shading_normals_.clear();
            for (const PathQueue* queue : {&reflected_, &refracted_}) {
                trace_queue(*queue);
                watch.end(FrameTimes::rays);
                shade_hits(*queue, false, sample);
                watch.end(FrameTimes::surfaces);
            }
            light_points(false, tile, false, watch);
            bounce_light(false, tile);
            add_reference(tile, false);
            watch.end(FrameTimes::indirect_mirrored);
        }
    }
    store(tile, out);
}

// Primary rays in Morton order: a packet covers a block of 4 x 2 or 4 x 4 pixels.
void TileTracer::queue_primary(const TileRect& tile, int sample)
{
    primary_.clear();
    const glm::vec2 offset = scene::sample_offset(sample, options_.samples);
    const auto count = static_cast<std::uint32_t>(options_.tile * options_.tile);
    for (std::uint32_t code = 0; code < count; ++code) {
        const int x = static_cast<int>(even_bits(code)), y = static_cast<int>(even_bits(code >> 1));
        if (x >= tile.width || y >= tile.height) continue;
        glm::vec3 origin, direction;
        float tnear, tfar;
        view_.ray(static_cast<float>(tile.x + x) + offset.x, static_cast<float>(tile.y + y) + offset.y, origin,
                  direction, tnear, tfar);
        const Path path{
            static_cast<std::uint32_t>(y * options_.tile + x), glm::vec3(1), {view_.pixel_width, view_.pixel_spread}};
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

// Brings hits on the same object together, each object's in queue order: neighbours in the shadow queues then start on
// the same surface, and materials and textures are met in runs.
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
            color_[path.pixel] += path.share * scene_.background.radiance(direction);
            continue;
        }
        Point& point = points_.emplace_back();
        shading::surface_at(scene_, rays_.geometry(hits_.object[i]), hits_.triangle[i], hits_.u[i], hits_.v[i],
                            hits_.t[i], direction, path.cone, point.surface);
        point.pixel = path.pixel;
        point.share = path.share;
        const shading::SurfacePoint& s = point.surface;

        point.next = shading::continue_from(s);

        // Add what needs no ray: emission, ambient light, blurred mirror images of the sky.
        glm::vec3 own = s.emissive * s.coverage;
        own += shading::ambient_light(s, scene_, !visible_ && !map_ && !options_.reference);
        if (point.next.unresolved_share != glm::vec3(0))
            own += point.next.unresolved_share * scene_.background.ambient(point.next.reflected);
        color_[path.pixel] += path.share * own;
        if (primary && options_.layers) {
            albedo_[path.pixel] += s.diffuse + s.specular;
            if (sample == 0) {
                normal_[path.pixel] = s.normal;
                depth_[path.pixel] = hits_.t[i] * glm::dot(direction, view_.forward);
            }
        }
        // An unlit surface faces no light.
        const bool lit = s.model != scene::ShadingModel::unlit;
        shadow_points_.push_back({s.position + s.offset * s.geometric_normal, lit ? s.geometric_normal : glm::vec3(0),
                                  hits_.object[i], hits_.triangle[i], hits_.u[i], hits_.v[i], s.winding_front});
        shading_normals_.push_back(s.normal);
    }
}

// What the published culling's occlusion test looks at, once all of the image is there.
// DEVIATION(Nah 2009, 2.3): with several samples a pixel, the test sees the first of each; the paper has one.
void TileTracer::note_primary_hits(const TileRect& tile)
{
    for (std::size_t i = 0; i < primary_.rays.size(); ++i) {
        shadow_culling::PrimaryHit hit{shadow_culling::no_primitive, primary_.rays.origin(i),
                                       primary_.rays.direction(i)};
        if (hits_.object[i] != scene::none) hit.primitive = paper_->primitive(hits_.object[i], hits_.triangle[i]);
        primary_hits_[pixel_of_image(primary_.paths[i].pixel, tile)] = hit;
    }
}

// Per light: find the points it reaches, by rays or by memory, and add its light there.
void TileTracer::light_points(bool primary, const TileRect& tile, bool show_states, Stopwatch& watch)
{
    const std::size_t lights = scene_.lights.size();
    if (culling_) culling_->classify(*batch_, shadow_points_);
    watch.end(FrameTimes::shadows);
    for (std::size_t l = 0; l < lights; ++l) {
        const scene::Light& light = scene_.lights[l];
        const scene::LightState& at = state_.light(static_cast<scene::LightId>(l));
        if (show_states) mark_states(l, tile);
        if (!at.visible || light.color == glm::vec3(0)) continue;
        if (options_.reference && !options_.reference->uses(light)) continue;
        lit_.clear();
        if (culling_)
            find_lit_by_memory(l);
        else if (paper_)
            find_lit_by_paper(l);
        else
            find_lit_by_rays(l);
        watch.end(FrameTimes::shadows);
        if (states_) check_lit(l, primary, tile);
        for (const std::uint32_t p : lit_) {
            const Point& point = points_[p];
            const scene::LightSample sample = scene::illuminate(light, at, point.surface.position);
            const auto reflect = light.of_environment ? shading::reflect_surroundings : shading::reflect_light;
            const glm::vec3 radiance = point.share * reflect(point.surface, sample.to_light, sample.irradiance);
            color_[point.pixel] += radiance;
            if (primary && options_.layers) {
                direct_[point.pixel] += radiance;
                shadow_[point.pixel * lights + l] += 1;
            }
        }
        watch.end(FrameTimes::surfaces);
    }
}

// One queue of shadow rays from all points that face the light.
void TileTracer::queue_shadow_rays(std::size_t l)
{
    const scene::LightReach light(scene_.lights[l], state_.light(static_cast<scene::LightId>(l)));
    const float end = light.directional() ? k_infinity : ray::k_shadow_ray_end;
    shadow_rays_.clear();
    shadow_rays_.purpose = ray::RayClass::shadow;
    shadow_rays_.reserve(shadow_points_.size());
    shadow_point_.clear();
    for (std::uint32_t p = 0; p < shadow_points_.size(); ++p) {
        const shadow_culling::ShadowPoint& here = shadow_points_[p];
        const glm::vec3 to_light = light.from(here.origin);
        if (!light.faces(to_light, here.normal) || !light.faces(to_light, shading_normals_[p])) continue;
        if (light.dark_at(points_[p].surface.position)) continue;
        shadow_rays_.push(here.origin, 0, to_light, end);
        shadow_point_.push_back(p);
    }
}

void TileTracer::find_lit_by_rays(std::size_t l)
{
    queue_shadow_rays(l);
    const std::size_t count = shadow_rays_.size();
    if (count == 0) return;
    counters_.shadow.rays += count;
    occluded_.resize(count + ray::k_packet_pad);
    rays_.occluded(shadow_rays_, 0, count, occluded_.data());
    if (log_) log_->entries.push_back({shadow_rays_, true});
    for (std::size_t i = 0; i < count; ++i)
        if (!occluded_[i]) lit_.push_back(shadow_point_[i]);
}

// The same points, by certified shadow culling: most of them without a ray.
void TileTracer::find_lit_by_memory(std::size_t l)
{
    const scene::LightReach light(scene_.lights[l], state_.light(static_cast<scene::LightId>(l)));
    occluded_.resize(shadow_points_.size() + ray::k_packet_pad);
    culling_->shadow(*batch_, static_cast<int>(l), occluded_.data());
    for (std::uint32_t p = 0; p < shadow_points_.size(); ++p) {
        if (occluded_[p]) continue;
        if (!light.faces(light.from(shadow_points_[p].origin), shading_normals_[p])) continue;
        if (light.dark_at(points_[p].surface.position)) continue;
        lit_.push_back(p);
    }
}

// The same points as far as the published culling is right; fewer rays, guessed from what earlier frames met.
void TileTracer::find_lit_by_paper(std::size_t l)
{
    queue_shadow_rays(l);
    const std::size_t count = shadow_rays_.size();
    origins_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const shadow_culling::ShadowPoint& here = shadow_points_[shadow_point_[i]];
        origins_[i] = paper_->primitive(here.object, here.triangle);
    }
    occluded_.resize(count + ray::k_packet_pad);
    paper_tracer_.answer(*paper_, rays_, static_cast<int>(l), shadow_rays_, origins_, occluded_.data());
    for (std::size_t i = 0; i < count; ++i)
        if (!occluded_[i]) lit_.push_back(shadow_point_[i]);
}

// Adds light that comes by one bounce, wherever a surface scatters light.
void TileTracer::bounce_light(bool primary, const TileRect& tile)
{
    if (!visible_ && !map_) return;
    indirect_points_.clear();
    map_receivers_.clear();
    indirect_point_.clear();
    for (std::uint32_t p = 0; p < points_.size(); ++p) {
        const shading::SurfacePoint& s = points_[p].surface;
        if (s.model == scene::ShadingModel::unlit || s.diffuse == glm::vec3(0)) continue;
        const shadow_culling::ShadowPoint& here = shadow_points_[p];
        const int pixel = static_cast<int>(points_[p].pixel);
        if (visible_) {
            // Chrome and glass show everything small and from places of their own, so that its points would be many
            // and new in every frame; and what brings less of a pixel may be coarser.
            const float wider =
                primary ? 1.0f : options_.mirrored_spacing / std::sqrt(std::min(largest_share(points_[p].share), 1.0f));
            const float width = s.cone.width * wider;
            indirect_points_.push_back({s.position, s.geometric_normal, s.normal, here.object, here.triangle, here.u,
                                        here.v, width, s.to_viewer});
            if (primary) {
                indirect_points_.back().x = static_cast<std::int16_t>(pixel % options_.tile);
                indirect_points_.back().y = static_cast<std::int16_t>(pixel / options_.tile);
            }
        } else if (primary)
            map_receivers_.push_back(
                {s.position, s.normal, s.cone.width, {tile.x + pixel % options_.tile, tile.y + pixel / options_.tile}});
        else
            map_receivers_.push_back({s.position, s.normal, s.cone.width});
        indirect_point_.push_back(p);
    }
    irradiance_.resize(indirect_point_.size());
    if (visible_)
        visible_->shade(*indirect_batch_, indirect_points_, irradiance_.data());
    else
        map_->shade(*map_batch_, map_receivers_, irradiance_.data());
    for (std::size_t k = 0; k < indirect_point_.size(); ++k) {
        const Point& point = points_[indirect_point_[k]];
        const glm::vec3 radiance =
            point.share * reflect_irradiance(point.surface, point.next, irradiance_[k], glm::vec3(0));
        color_[point.pixel] += radiance;
        if (primary && options_.layers) indirect_[point.pixel] += radiance;
    }
}

// Asks the reference for what the points just shaded get beside the lamps' own light.
void TileTracer::add_reference(const TileRect& tile, bool primary)
{
    if (!options_.reference) return;
    requests_.clear();
    request_point_.clear();
    for (std::uint32_t p = 0; p < points_.size(); ++p) {
        const Point& point = points_[p];
        if (point.surface.diffuse * point.surface.coverage == glm::vec3(0)) continue;
        const auto x = static_cast<std::uint64_t>(tile.x) + point.pixel % static_cast<std::uint32_t>(options_.tile);
        const auto y = static_cast<std::uint64_t>(tile.y) + point.pixel / static_cast<std::uint32_t>(options_.tile);
        const std::uint64_t place = y * static_cast<std::uint64_t>(view_.size.width) + x;
        const std::uint64_t key = reference::mix(place, points_of_pixel_[point.pixel]++);
        requests_.push_back({reference::irradiance_point(point.surface, key), samples_of(point.share)});
        request_point_.push_back(p);
    }
    estimates_.resize(requests_.size());
    paths_->estimate(requests_, estimates_.data());
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const Point& point = points_[request_point_[r]];
        const reference::IrradianceEstimate& light = estimates_[r];
        const auto reflected = [&](const glm::vec3& indirect, const glm::vec3& surroundings) {
            return point.share * reflect_irradiance(point.surface, point.next, indirect, surroundings);
        };
        color_[point.pixel] += reflected(light.indirect, light.surroundings);
        const glm::vec3 error = reflected(light.error, glm::vec3(0));
        variance_[point.pixel] += error * error;
        if (!primary) continue;
        first_irradiance_[point.pixel] += light.indirect;
        first_variance_[point.pixel] += light.indirect_error * light.indirect_error;
        if (!options_.layers) continue;
        // An image of the surroundings is direct light, as are the lights that stand for it; the sky is not.
        const bool sky = scene_.background.kind == scene::Background::Kind::sky;
        indirect_[point.pixel] += reflected(light.indirect, sky ? light.surroundings : glm::vec3(0));
        direct_[point.pixel] += reflected(glm::vec3(0), sky ? glm::vec3(0) : light.surroundings);
    }
}

// What is seen in a mirror gets fewer paths, in proportion to its share, so that it adds as little to the noise.
int TileTracer::samples_of(const glm::vec3& share) const
{
    const int all = std::max(1, options_.reference->options().samples / options_.samples);
    const float wanted = static_cast<float>(all) * largest_share(share);
    if (wanted >= static_cast<float>(all)) return all;
    int samples = std::min(all, k_least_paths);
    while (static_cast<float>(samples) < wanted) samples *= 2;
    return std::min(samples, all);
}

// Queues the rays that go on from the points just shaded, each kind by itself.
void TileTracer::queue_continuations()
{
    next_reflected_.clear();
    next_refracted_.clear();
    for (const Point& point : points_) {
        const shading::SurfacePoint& s = point.surface;
        const shading::Continuation& c = point.next;
        const glm::vec3 lift = s.offset * s.geometric_normal;
        const auto queue = [&](PathQueue& to, const glm::vec3& share, const glm::vec3& origin,
                               const glm::vec3& direction) {
            const glm::vec3 total = point.share * share;
            if (largest_share(total) < options_.min_throughput) return;
            to.push({point.pixel, total, s.cone}, origin, 0, direction, k_infinity);
        };
        queue(next_reflected_, c.reflected_share, s.position + lift, c.reflected);
        queue(next_refracted_, c.refracted_share, s.position - lift, c.refracted);
        queue(next_refracted_, c.straight_share, s.position - lift, -s.to_viewer);
    }
    std::swap(reflected_, next_reflected_);
    std::swap(refracted_, next_refracted_);
}

std::size_t TileTracer::pixel_of_image(std::uint32_t pixel, const TileRect& tile) const
{
    const int x = tile.x + static_cast<int>(pixel) % options_.tile,
              y = tile.y + static_cast<int>(pixel) / options_.tile;
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.size.width) + static_cast<std::size_t>(x);
}

void TileTracer::store(const TileRect& tile, shading::FrameBuffers& out) const
{
    const float weight = 1.0f / static_cast<float>(options_.samples);
    const std::size_t lights = scene_.lights.size();
    const auto put = [](ImageF& image, int x, int y, const glm::vec3& value) {
        float* to = image.pixel(x, y);
        to[0] = value.x, to[1] = value.y, to[2] = value.z;
    };
    for (int y = 0; y < tile.height; ++y)
        for (int x = 0; x < tile.width; ++x) {
            const auto from =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(options_.tile) + static_cast<std::size_t>(x);
            const int px = tile.x + x, py = tile.y + y;
            put(out.color, px, py, color_[from] * weight);
            if (options_.reference) {
                put(out.variance, px, py, variance_[from] * (weight * weight));
                put(out.irradiance, px, py, first_irradiance_[from] * weight);
                put(out.irradiance_variance, px, py, first_variance_[from] * (weight * weight));
            }
            if (!options_.layers) continue;
            put(out.direct, px, py, direct_[from] * weight);
            put(out.indirect, px, py, indirect_[from] * weight);
            put(out.albedo, px, py, albedo_[from] * weight);
            put(out.normal, px, py, normal_[from]);
            out.depth.pixel(px, py)[0] = depth_[from];
            for (std::size_t l = 0; l < lights; ++l) out.shadow.pixel(px, py)[l] = shadow_[from * lights + l] * weight;
        }
}

}   // namespace gnomon::trace
