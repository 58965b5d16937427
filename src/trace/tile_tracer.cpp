// SPDX-License-Identifier: Apache-2.0
// LONG: all techniques add to one tile, and the queues between them are its own.
#include "trace/tile_tracer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "base/check.h"
#include "base/interruption.h"
#include "base/morton.h"
#include "base/random.h"
#include "ray/origin.h"
#include "scene/light_reach.h"
#include "shading/glossy.h"
#include "trace/hidden_surfaces.h"

namespace gnomon::trace {

namespace {

constexpr std::size_t k_lobe_rays_at_once = 16384;
constexpr std::uint32_t k_lobe_batches = 8;    // of random rays: their spread is the error
constexpr int k_blurred_lobe_rays = 2;         // a power of two
constexpr float k_least_lobe_rays = 1e-3f;     // as which a pixel's rays count beside its neighbours'
constexpr float k_most_lobe_spread = 0.5f;     // radians in which a ray of a lobe shows the mean of what is there
constexpr float k_least_lobe_length = 1e-6f;   // of a lobe's ray as neighbours take it, in metres
constexpr float k_least_cosine = 0.1f;         // of the view, for the pixel's footprint
constexpr float k_further_share = 0.25f;   // of a pixel, that a further sample makes, with those that take its light

// The mean radiance of a sky over the directions above a level surface, weighted by their cosines.
glm::vec3 open_sky_radiance(scene::Background sky)
{
    sky.sun_radiance = glm::vec3(0);
    constexpr int k_rings = 64;
    glm::vec3 sum(0);
    for (int i = 0; i < k_rings; ++i) {
        // Rings of equal weight; the sky is the same all round.
        const float y = std::sqrt((static_cast<float>(i) + 0.5f) / k_rings);
        sum += sky.radiance({std::sqrt(1 - y * y), y, 0});
    }
    return sum / static_cast<float>(k_rings);
}

// Whether a surface shows others.
bool mirrors(const shading::Continuation& next)
{
    return std::max({largest(next.reflected_weight), largest(next.refracted_weight), largest(next.straight_weight),
                     largest(next.lobe_weight)}) > k_least_mirrored;
}

int power_of_two_from(int x)
{
    int power = 1;
    while (power < x) power *= 2;
    return power;
}

glm::uvec2 random_flip(std::uint64_t seed, std::uint64_t stream)
{
    Random random(seed, stream);
    const std::uint32_t x = random.next();
    return {x, random.next()};
}

}   // namespace

TileTracer::TileTracer(const FrameContext& frame, const TracedOptions& options, ShadowTester& shadows,
                       const SizedTechnique& sized, EnvironmentTechnique* environment, IndirectLight* indirect,
                       LobeImage* lobes, shading::CentreSamples* centres, const BouncedPlaces* places, TraceLog* log)
    : state_(frame.state),
      scene_(frame.state.scene()),
      rays_(frame.rays),
      view_(frame.view),
      options_(options),
      indirect_light_(indirect),
      shadows_(shadows.make_worker()),
      indirect_(indirect ? indirect->make_worker() : nullptr),
      is_estimate_(indirect && indirect->is_estimate()),
      log_(log),
      horizon_(frame.rays),
      centres_(centres),
      places_(places),
      lobes_(lobes)
{
    if (options.max_depth > 0 && options.lobe_rays > 0) rays_of_lobe_ = rays_of_each(options.samples);
    if (options.random_lobes) rays_of_lobe_ = std::max(rays_of_lobe_, static_cast<int>(k_lobe_batches));
    if (sized.lights) sized_.emplace(*sized.lights, *sized.visibility, rays_);
    if (environment) environment_.emplace(*environment, rays_);
    sees_image_ = environment_ && environment_->has_image();
    thins_light_ = rays_.thins_light();
    hides_surfaces_ = trace::hides_surfaces(scene_);
    open_sky_ = glm::vec3(0);
    if (scene_.background.kind == scene::Background::Kind::sky) {
        // As the light of a sky is computed: by bounces, or unoccluded.
        open_sky_ = static_cast<float>(k_pi) *
                    (indirect ? open_sky_radiance(scene_.background) : scene_.background.ambient({0, 1, 0}));
    }
    // A random estimate has the light of the image among its surroundings.
    if (is_estimate_ && scene_.background.environment)
        open_image_ = scene_.background.environment->irradiance({0, 1, 0});
    primary_.rays.purpose = ray::RayClass::primary;
    for (PathQueue* queue : {&reflected_, &next_reflected_}) queue->rays.purpose = ray::RayClass::reflection;
    for (PathQueue* queue : {&refracted_, &next_refracted_}) queue->rays.purpose = ray::RayClass::refraction;
}

void TileTracer::trace(const Tile& tile, shading::FrameBuffers& out, image::SampleSums* sums, const Blur* left_out)
{
    Stopwatch whole(times_);
    begin_tile(tile);
    for (int y = tile.y; centres_ && y < tile.y + tile.height; ++y) centres_->clear(y, tile.x, tile.x + tile.width);
    spreads_lobes_ = sums && lobes_;
    whole.end(FrameTimes::surfaces);
    for (int sample = 0; sample < options_.samples; ++sample) {
        interruption_point();
        Stopwatch watch(times_);
        queue_primary(sample);
        shade_sample(sample, watch);
        if (sums) add_samples(sample, *sums, left_out);
    }
    whole.restart();
    spreads_lobes_ = false;
    store_lobes();
    store(out);
    whole.end(FrameTimes::surfaces);
}

// What a ray shows that leaves the scene.
// @param apart  without the mean over a lobe, which the filter adds
glm::vec3 TileTracer::seen_of_background(const PathEnd& end, const glm::vec3& direction, bool apart) const
{
    const glm::vec3 open = apart ? glm::vec3(0) : end.open;
    return end.background > 0 ? end.background * scene_.background.radiance(direction) + open : open;
}

// Traces the queued rays of pixels, and shades what they hit.
void TileTracer::shade_sample(int sample, Stopwatch& watch)
{
    shade_first_hits(sample, watch);
    shade_rest(sample, watch);
}

// Finds what the queued rays hit, with the light of lights without size.
void TileTracer::shade_first_hits(int sample, Stopwatch& watch)
{
    clear_points();
    trace_queue(primary_);
    watch.end(FrameTimes::rays);
    if (sample == 0) shadows_->note_primary_hits({primary_.rays, hits_, primary_.paths, tile_});
    shade_hits(primary_, true, sample, options_.max_depth == 0);
    watch.end(FrameTimes::surfaces);
    add_lights(batch(true, sample), watch);
    add_suns(batch(true, sample), watch);
}

// Adds the other light to the first hits, and what they mirror and let through.
void TileTracer::shade_rest(int sample, Stopwatch& watch)
{
    if (interpolates(sample)) {
        shade_lattice(sample, watch);
        return;
    }
    add_soft_light(true, sample, 0, points_.size(), watch);
    watch.end(FrameTimes::indirect);

    // Do the same for mirrored and refracted rays, one depth after the other, and for the rays of lobes.
    follow_hits(sample, watch);
}

// Follows the rays that continue from the first hits.
void TileTracer::follow_hits(int sample, Stopwatch& watch)
{
    const bool notes = refinement_ || (centres_ && sample == 0 && !blur_);
    const std::vector<glm::vec3> without = notes ? color_ : std::vector<glm::vec3>();
    keep_lobes(sample);
    bounce_ = 0;
    queue_continuations(true);
    follow_paths(sample, watch);
    trace_lobes(sample, watch);
    if (notes) note_mirrored(without);
}

// Keeps what samples mirror apart from their other light.
// @param without  their light without it
void TileTracer::note_mirrored(std::span<const glm::vec3> without)
{
    if (refinement_) {
        for (std::size_t i = 0; i < without.size(); ++i)
            if (met_[i].apart) met_[i].mirrored += color_[i] - without[i];
        return;
    }
    for (int y = 0; y < tile_.height; ++y)
        for (int x = 0; x < tile_.width; ++x) {
            const auto i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(tile_.side) + static_cast<std::size_t>(x);
            shading::CentreSample& centre = centres_->at(tile_.x + x, tile_.y + y);
            if (centre.apart) centre.mirrored = color_[i] - without[i];
        }
}

// Adds the light of what has a size, and bounced light, to the points [first, end): see light_some().
void TileTracer::add_soft_light(bool primary, int sample, std::size_t first, std::size_t end, Stopwatch& watch)
{
    const PointBatch all = batch(primary, sample);
    add_image(all, first, end, watch);
    PointBatch some = all;
    some.points = all.points.subspan(first, end - first);
    some.shadow_points = all.shadow_points.subspan(first, end - first);
    some.normals = all.normals.subspan(first, end - first);
    add_sized_lights(some, first, watch);
    add_indirect(some);
}

// Follows the queued rays to the last depth.
void TileTracer::follow_paths(int sample, Stopwatch& watch)
{
    for (int depth = 0; depth < options_.max_depth; ++depth) {
        interruption_point();
        bounce_ = depth;
        if (depth > 0) queue_continuations(false);
        if (reflected_.rays.empty() && refracted_.rays.empty()) break;
        counters_.reflection_rays += reflected_.rays.size();
        counters_.refraction_rays += refracted_.rays.size();
        clear_points();
        for (const PathQueue* queue : {&reflected_, &refracted_}) {
            trace_queue(*queue);
            watch.end(FrameTimes::rays);
            shade_hits(*queue, false, sample, depth + 1 == options_.max_depth);
            watch.end(FrameTimes::surfaces);
        }
        add_lights(batch(false, sample), watch);
        add_suns(batch(false, sample), watch);
        add_soft_light(false, sample, 0, points_.size(), watch);
        watch.end(FrameTimes::indirect_mirrored);
    }
}

void TileTracer::begin_tile(const Tile& tile)
{
    tile_ = tile;
    if (indirect_) indirect_->begin_tile(tile);
    lobe_light_.clear(), kept_pixels_.clear(), kept_rays_.clear();
    pixels_.clear();
    const auto pixels = static_cast<std::size_t>(tile.side) * static_cast<std::size_t>(tile.side);
    clear_sums(pixels);
    if (lobes_) lobe_samples_.assign(pixels, 0);
    if (options_.layers) normal_.assign(pixels, glm::vec3(0)), depth_.assign(pixels, 0);
    if (is_estimate_)
        for (auto* layer : {&first_irradiance_, &first_variance_, &variance_}) layer->assign(pixels, glm::vec3(0));
}

// Forgets what samples have brought.
// @param count  pixels of the tile, or further samples
void TileTracer::clear_sums(std::size_t count)
{
    color_.assign(count, glm::vec3(0));
    if (options_.backdrop_apart) backdrop_.assign(count, glm::vec3(0));
    if (!options_.layers) return;
    for (auto* layer : {&direct_, &indirect_color_, &albedo_}) layer->assign(count, glm::vec3(0));
    shadow_.assign(count * scene_.lights.size(), 0);
}

// Adds the samples of pixels to sums, and forgets them.
// @param left_out  optional: without its touched pixels
void TileTracer::add_samples(int sample, image::SampleSums& sums, const Blur* left_out)
{
    const glm::vec2 offset = scene::sample_offset(sample, options_.samples);
    const image::SampleWeights weights = image::sample_weights(options_.filter, offset);
    std::vector<float> values(static_cast<std::size_t>(sums.channels()));
    for (int y = 0; y < tile_.height; ++y)
        for (int x = 0; x < tile_.width; ++x) {
            if (left_out && left_out->touched(tile_.x + x, tile_.y + y)) continue;
            const int pixel = y * tile_.side + x;
            values_of(static_cast<std::size_t>(pixel), values.data());
            const float counts = sums.add(number_of(tile_), x, y, weights, 1, values.data());
            // The lobe's light follows once it is filtered.
            if (!spreads_lobes_ || lobe_weights_[static_cast<std::size_t>(pixel)] == glm::vec3(0)) continue;
            std::array<glm::vec3, 9>& spread = lobes_->spread(tile_.x + x, tile_.y + y);
            for (std::size_t i = 0; i < 9; ++i)
                spread[i] += (counts * weights.across[i % 3] * weights.down[i / 3]) *
                             lobe_weights_[static_cast<std::size_t>(pixel)];
        }
    clear_sums(color_.size());
}

// How many rays the lobe of each sample of a pixel has at most.
int TileTracer::rays_of_each(int samples) const
{
    return static_cast<int>(std::bit_floor(static_cast<unsigned>(std::max(options_.lobe_rays / samples, 1))));
}

std::size_t TileTracer::number_of(const Tile& tile) const
{
    const int columns = (view_.size.width + options_.tile - 1) / options_.tile;
    const int number = tile.y / options_.tile * columns + tile.x / options_.tile;
    return static_cast<std::size_t>(number);
}

// The channels of a sample, in the order of averaged_layers().
void TileTracer::values_of(std::size_t at, float* values) const
{
    const auto put = [&](const glm::vec3& v) {
        for (int c = 0; c < 3; ++c) *values++ = v[c];
    };
    put(color_[at]);
    if (options_.backdrop_apart) *values++ = 1 - std::clamp(luminance(backdrop_[at]), 0.0f, 1.0f);
    if (!options_.layers) return;
    put(direct_[at]), put(indirect_color_[at]), put(albedo_[at]);
    const std::size_t lights = scene_.lights.size();
    std::copy_n(shadow_.data() + at * lights, lights, values);
}

void TileTracer::clear_points()
{
    points_.clear();
    shadow_points_.clear();
    normals_.clear();
}

PointBatch TileTracer::batch(bool primary, int sample) const
{
    return {points_, shadow_points_, normals_, tile_, primary, sample == 0, pixels_, refinement_ ? k_further_share : 1};
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
        queue_camera_ray(static_cast<std::uint32_t>(y * tile_.side + x), glm::vec2(tile_.x + x, tile_.y + y) + offset);
    }
    counters_.primary_rays += primary_.rays.size();
}

// @param pixel  of the tile, or the number of a further sample
// @param at     in the image, in pixels
void TileTracer::queue_camera_ray(std::uint32_t pixel, const glm::vec2& at)
{
    glm::vec3 origin, direction;
    float tnear, tfar;
    view_.ray(at.x, at.y, origin, direction, tnear, tfar);
    Path path{pixel, glm::vec3(1), {view_.pixel_width, view_.pixel_spread}};
    path.straight = true;
    primary_.push(path, origin, tnear, direction, tfar);
}

void TileTracer::trace_queue(const PathQueue& queue)
{
    if (queue.rays.empty()) return;
    hits_.resize(queue.rays.size());
    rays_.closest(queue.rays, 0, queue.rays.size(), hits_, ray::Sides::front);
    if (hides_surfaces_)
        pass_hidden_surfaces(
            scene_, rays_, queue.rays, [&](std::size_t i) { return queue.paths[i].straight; }, hits_);
    if (log_) log_->entries.push_back({queue.rays, false});
}

// Orders hits by object, and those of an object as in the queue. Neighbours in the shadow queues then start on the same
// surface, and materials and textures are used in runs. Objects come in the order in which the queue first hits them,
// because paths of one pixel add up in this order, and objects' numbers depend on the history of a host's scene.
void TileTracer::sort_hits(std::size_t count)
{
    order_.resize(count);
    bool sorted = true;
    for (std::size_t i = 0; i < count; ++i) {
        const scene::ObjectId object = hits_.object[i];
        std::uint64_t rank = object;
        if (object != scene::none) {
            if (object >= first_hits_.size()) first_hits_.resize(object + 1, scene::none);
            if (first_hits_[object] == scene::none) first_hits_[object] = static_cast<std::uint32_t>(i);
            rank = first_hits_[object];
        }
        order_[i] = rank << 32 | i;
        sorted = sorted && (i == 0 || order_[i - 1] < order_[i]);
    }
    if (!sorted) std::sort(order_.begin(), order_.end());
    for (std::size_t i = 0; i < count; ++i)
        if (hits_.object[i] != scene::none) first_hits_[hits_.object[i]] = scene::none;
}

// @param last_depth  no rays continue from the hits
void TileTracer::shade_hits(const PathQueue& queue, bool primary, int sample, bool last_depth)
{
    const std::size_t count = queue.rays.size();
    sort_hits(count);
    for (const std::uint64_t key : order_) {
        const auto i = static_cast<std::uint32_t>(key);
        const Path& path = queue.paths[i];
        const glm::vec3 direction = queue.rays.direction(i);

        // Add the background where the ray left the scene.
        if (hits_.object[i] == scene::none) {
            if (path.straight && options_.backdrop_apart)
                backdrop_[path.pixel] += path.throughput;
            else if (!path.end.no_light)
                add_color(path.pixel, path.lobe,
                          path.throughput * seen_of_background(path.end, direction, is_kept_lobe_ray(path)));
            continue;
        }
        TilePoint& point = points_.emplace_back();
        shading::surface_at(scene_, rays_.geometry(hits_.object[i]), hits_.triangle[i], hits_.u[i], hits_.v[i],
                            hits_.t[i], direction, path.cone, point.surface);
        point.pixel = path.pixel;
        point.throughput = path.throughput;
        point.distance = hits_.t[i];
        point.straight = path.straight;
        const glm::vec3 unlit_behind = point.surface.catches_shadows ? show_behind(point, direction) : glm::vec3(0);
        point.end = path.end, point.lobe = path.lobe;
        if (path.lobe.rays > 0) shading::widen_lobe(rays_.geometry(hits_.object[i]), hits_.triangle[i], point.surface);
        point.parts = path.parts, point.splits = path.splits;
        const shading::SurfacePoint& s = point.surface;
        if (is_kept_lobe_ray(path)) {
            // Note where the ray of a lobe ends.
            GNOMON_CHECK(path.lobe.light <= kept_rays_.size());
            LobeRay& ray = kept_rays_[path.lobe.light - 1];
            ray.nearness = 1 / std::max(hits_.t[i], k_least_lobe_length);
            ray.normal = s.geometric_normal;
        }
        if (primary && ((refinement_ && take_light(point, hits_.object[i], hits_.triangle[i])) ||
                        (blur_ && take_still_light(point, hits_.object[i], hits_.triangle[i])))) {
            points_.pop_back();
            continue;
        }
        const bool is_centre = primary && centres_ && sample == 0 && !shades_further();
        const glm::ivec2 centre = is_centre ? tile_.pixel_of_image(point.pixel) : glm::ivec2(0);
        if (is_centre) centres_->at(centre.x, centre.y) = centre_sample(s, hits_.object[i], hits_.triangle[i]);
        if (s.layered) point.throughput *= shading::attenuation(s, hits_.t[i]);

        point.next = shading::continue_from(s);
        // Layered surfaces have rays of their own (queue_layered()).
        if (rays_of_lobe_ > 0 && !s.layered) shading::reflect_by_lobe(s, point.next);
        // Where no rays follow, the lobe itself shows the image.
        const float lobe_share = largest(point.throughput * point.next.lobe_weight) * std::max(path.lobe.rays, 1.0f);
        if (sees_image_ && (last_depth || lobe_share * point.parts < options_.min_throughput))
            point.next.lobe_weight = glm::vec3(0);
        if (indirect_light_ && indirect_light_->reflects_lobes() && shading::has_glossy_lobe(s)) {
            point.glossy = true;
            point.next.unresolved_weight = glm::vec3(point.next.coat_unresolved);
        }
        if (indirect_light_ && indirect_light_->reflects_lobes() && s.layered && s.layers.coat > 0 &&
            shading::has_glossy_lobe(shading::coat_surface(s))) {
            point.coat_glossy = true;
            point.next.unresolved_weight -= point.next.coat_unresolved;
        }

        if (is_centre) centres_->at(centre.x, centre.y).mirrors = mirrors(point.next);
        Bounced bounced = Bounced::unknown;
        if (primary && refinement_) bounced = take_bounced(point);
        if (primary && blur_) bounced = take_still_bounced(point, hits_.object[i], hits_.triangle[i]);
        point.has_bounced = bounced == Bounced::taken;

        // Add what needs no ray: emission, ambient light, blurred mirror images of the sky.
        glm::vec3 own = unlit_behind;
        const bool unlit = s.model == scene::ShadingModel::unlit;
        if (!path.end.no_light || unlit) own += s.emissive * (s.coverage * (unlit ? 1.0f : path.end.emission));
        own += shading::ambient_light(s, scene_, !indirect_light_,
                                      !(indirect_light_ && indirect_light_->has_further_bounces()));
        if (!sees_image_ && point.next.unresolved_weight != glm::vec3(0))
            own += point.next.unresolved_weight * scene_.background.ambient(point.next.reflected);
        add_light(point, point.throughput * own);
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
        if (places_ && shades_further() && bounced == Bounced::unknown)
            point.has_bounced = point.has_irradiance = take_place(point, shadow_points_.back(), primary);
        normals_.push_back(s.normal);
    }
}

// Irradiance of a level surface that faces up, if nothing of the scene hid a light from it.
glm::vec3 TileTracer::open_irradiance(const shading::SurfacePoint& s) const
{
    glm::vec3 sum = open_sky_;
    sum += sees_image_ ? environment_->open_irradiance(s.normal) : open_image_;
    for (std::size_t l = 0; l < scene_.lights.size(); ++l) {
        const scene::Light& light = scene_.lights[l];
        const scene::LightState& at = state_.light(static_cast<scene::LightId>(l));
        // Emissive surfaces are objects, whose light brightens the ground.
        if (!at.visible || light.of_surface || (sees_image_ && light.of_environment)) continue;
        if (indirect_light_ && indirect_light_->replaces(light)) continue;
        const scene::LightSample sample = scene::illuminate(light, at, s.position);
        sum += sample.irradiance * std::max(0.0f, glm::dot(s.normal, sample.to_light));
    }
    return sum;
}

// Lets a surface that catches shadows show what lies behind it.
// @return  its radiance where it needs no light for that
glm::vec3 TileTracer::show_behind(TilePoint& point, const glm::vec3& direction) const
{
    const bool apart = point.straight && options_.backdrop_apart;
    // Before a background of one colour, it is an ordinary diffuse surface.
    if (!apart && scene_.background.kind == scene::Background::Kind::color) return glm::vec3(0);
    point.behind = apart;
    const glm::vec3 open = open_irradiance(point.surface);
    const glm::vec3 behind = apart ? glm::vec3(1) : scene_.background.radiance(direction);
    const bool lit = std::min({open.x, open.y, open.z}) > 0;
    shading::show_behind(point.surface, lit ? behind : glm::vec3(0), lit ? open : glm::vec3(1));
    return lit ? glm::vec3(0) : behind;
}

// Finds, light by light, the points that it reaches, and adds its light there.
void TileTracer::add_lights(const PointBatch& batch, Stopwatch& watch)
{
    const std::size_t lights = scene_.lights.size();
    shadows_->prepare(batch);
    horizon_.prepare(batch);
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
        horizon_.add_lit(light, at, lit_);
        if (thins_light_) find_passing(light, at);
        watch.end(FrameTimes::shadows);
        for (std::size_t k = 0; k < lit_.size(); ++k) {
            const TilePoint& point = points_[lit_[k]];
            scene::LightSample sample = scene::illuminate(light, at, point.surface.position);
            if (thins_light_) sample.irradiance *= passes_[k];
            const auto reflect = light.of_environment ? shading::reflect_surroundings : shading::reflect_light;
            const glm::vec3 radiance = point.throughput * reflect(point.surface, sample.to_light, sample.irradiance);
            add_light(point, radiance);
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
        const glm::vec3* smooth = horizon_.lit_origin(p);
        const glm::vec3& origin = smooth ? *smooth : shadow_points_[p].origin;
        passing_.push(origin, 0, reach.from(origin), end);
    }
    passes_.resize(lit_.size());
    rays_.let_through(passing_, 0, passing_.size(), passes_.data());
}

// Adds the direct light of emissive surfaces, after that of the image: beside it, dim ones need few rays.
// @param first  of the points, among those of the image
void TileTracer::add_sized_lights(const PointBatch& batch, std::size_t first, Stopwatch& watch)
{
    if (!sized_) return;
    const std::span<const float> image =
        sees_image_ ? environment_->reflected().subspan(first, batch.points.size()) : std::span<const float>();
    sized_->light(batch, image, [&](const TilePoint& point, const glm::vec3& reflected, const glm::vec3& by_lobe) {
        const glm::vec3 radiance = point.throughput * reflected;
        add_light(point, radiance);
        if (batch.primary) add_highlight(point, by_lobe);
        if (batch.primary && options_.layers) direct_[point.pixel] += radiance;
    });
    watch.end(FrameTimes::shadows);
}

// Adds the direct light of suns.
void TileTracer::add_suns(const PointBatch& batch, Stopwatch& watch)
{
    if (!environment_) return;
    const std::size_t lights = scene_.lights.size();
    environment_->light_by_suns(batch, number_of(tile_), state_,
                                [&](const TilePoint& point, const glm::vec3& reflected, scene::LightId l, float share) {
                                    const glm::vec3 radiance = point.throughput * reflected;
                                    add_light(point, radiance);
                                    if (!batch.primary || !options_.layers) return;
                                    direct_[point.pixel] += radiance;
                                    shadow_[point.pixel * lights + l] += share;
                                });
    watch.end(FrameTimes::shadows);
}

// Adds the direct light of the environment image to the points [first, end).
void TileTracer::add_image(const PointBatch& batch, std::size_t first, std::size_t end, Stopwatch& watch)
{
    if (!environment_ || !sees_image_) return;
    environment_->light_some(batch, number_of(tile_), first, end,
                             [&](const TilePoint& point, const glm::vec3& reflected, const glm::vec3& by_lobe) {
                                 const glm::vec3 radiance = point.throughput * reflected;
                                 add_light(point, radiance);
                                 if (batch.primary) add_highlight(point, by_lobe);
                                 if (batch.primary && options_.layers) direct_[point.pixel] += radiance;
                             });
    for (std::size_t p = first; p < end; ++p) {
        const EnvironmentLighting::ByLobe& lobe = environment_->by_lobes()[p];
        points_[p].image_by_lobe = lobe.share, points_[p].open = lobe.open;
        points_[p].hidden = environment_->hidden()[p];
    }
    watch.end(FrameTimes::shadows);
}

// What a point sends to the viewer of light that arrives by bounces.
glm::vec3 TileTracer::reflect_bounced(const TilePoint& point, const glm::vec3& indirect,
                                      const glm::vec3& surroundings) const
{
    const shading::Continuation none;
    if (!point.glossy) {
        const glm::vec3 radiance = reflect_irradiance(point.surface, point.next, indirect, surroundings);
        if (!stands_for_lobe(point)) return point.throughput * radiance;
        return point.throughput *
               glm::mix(radiance, below_lobe(point) * reflect_irradiance(point.surface, none, indirect, surroundings),
                        image_share(point.surface));
    }
    // What the lobe does not reflect reaches the diffuse layer.
    const glm::vec3 below = glm::vec3(1) - shading::glossy_albedo(point.surface);
    return point.throughput * (reflect_irradiance(point.surface, point.next, indirect, glm::vec3(0)) +
                               below * reflect_irradiance(point.surface, none, glm::vec3(0), surroundings));
}

// Adds light that arrives by bounces.
void TileTracer::add_indirect(const PointBatch& batch)
{
    if (!indirect_) return;
    interruption_point();
    indirect_->gather(batch, arrives_);
    add_gathered(batch);
}

// Adds the light that was gathered for a batch.
void TileTracer::add_gathered(const PointBatch& batch)
{
    const bool notes = batch.primary && batch.first_sample && centres_ && !shades_further();
    for (std::size_t k = 0; k < arrives_.point.size(); ++k) {
        const TilePoint& point = batch.points[arrives_.point[k]];
        const auto reflected = [&](const glm::vec3& indirect, const glm::vec3& surroundings) {
            return reflect_bounced(point, indirect, surroundings);
        };
        const glm::vec3 surroundings = is_estimate_ ? arrives_.surroundings[k] : glm::vec3(0);
        const glm::vec3 radiance = reflected(arrives_.irradiance[k], surroundings);
        add_light(point, radiance);
        if (places_) note_place(point, batch.shadow_points[arrives_.point[k]], batch.primary, arrives_.irradiance[k]);
        if (notes) {
            const glm::ivec2 at = tile_.pixel_of_image(point.pixel);
            centres_->at(at.x, at.y).bounced = radiance;
        }
        // An environment image counts as direct light, as do the lights that approximate it; the sky does not.
        const bool sky = scene_.background.kind == scene::Background::Kind::sky;
        if (batch.primary && options_.layers) {
            indirect_color_[point.pixel] += reflected(arrives_.irradiance[k], sky ? surroundings : glm::vec3(0));
            if (is_estimate_) direct_[point.pixel] += reflected(glm::vec3(0), sky ? glm::vec3(0) : surroundings);
        }
        // The spread of a lobe's rays has the errors of what they meet.
        if (!is_estimate_ || point.lobe.light != 0) continue;
        const glm::vec3 error = reflected(arrives_.error[k], glm::vec3(0));
        variance_[point.pixel] += error * error;
        if (!batch.primary) continue;
        first_irradiance_[point.pixel] += arrives_.irradiance[k];
        first_variance_[point.pixel] += arrives_.irradiance_error[k] * arrives_.irradiance_error[k];
    }
    for (std::size_t p = 0; places_ && shades_further() && p < batch.points.size(); ++p) {
        const TilePoint& point = batch.points[p];
        if (!point.has_irradiance) continue;
        const glm::vec3 radiance = reflect_bounced(point, point.irradiance, glm::vec3(0));
        add_light(point, radiance);
        if (batch.primary && options_.layers) indirect_color_[point.pixel] += radiance;
    }
    if (!indirect_light_->reflects_lobes()) return;
    for (std::size_t k = 0; k < arrives_.lobe_point.size(); ++k) {
        const TilePoint& point = batch.points[arrives_.lobe_point[k]];
        add_color(point.pixel, point.lobe, point.throughput * arrives_.lobe_radiance[k]);
        if (point.lobe.light != 0) continue;
        const glm::vec3 error = point.throughput * arrives_.lobe_error[k];
        variance_[point.pixel] += error * error;
    }
}

// Light of a lobe's rays is kept apart from that of others.
void TileTracer::add_color(std::uint32_t pixel, const LobePath& lobe, const glm::vec3& radiance)
{
    if (lobe.light == 0)
        color_[pixel] += radiance;
    else
        lobe_light_[lobe.light - 1] += radiance;
}

// What a surface without layers reflects of what its one reflected ray meets. The part of it that stands for the lobe
// shows what hides the image from the lobe: both together are what the lobe reflects.
TileTracer::MirroredRay TileTracer::mirrored_ray(const TilePoint& point) const
{
    const shading::SurfacePoint& s = point.surface;
    const float by_lobe = image_share(s);
    const glm::vec3 smooth = (1 - by_lobe) * point.next.reflected_weight;
    glm::vec3 weight = (1 - point.image_by_lobe) * point.next.reflected_weight;
    if (stands_for_lobe(point))
        weight = smooth + (by_lobe - point.image_by_lobe) * s.coverage * (1 - shading::lobe_share(s)) *
                              shading::traced_part(s.roughness) * shading::glossy_albedo(s);
    const float all = largest(weight);
    return {weight, all > 0 ? std::min(largest(smooth) / all, 1.0f) : 0};
}

// What reaches the diffuse layer below a lobe, of bounced light. The part of the lobe for which no ray is traced shows
// that light, too, as far as the lobe does not see the image.
glm::vec3 TileTracer::below_lobe(const TilePoint& point) const
{
    const shading::SurfacePoint& s = point.surface;
    const float without_ray = (1 - shading::traced_part(s.roughness)) * (1 - shading::lobe_share(s));
    const float lobe_hidden = 1 - point.image_by_lobe / image_share(s);
    const float part = lobe_hidden < point.hidden ? lobe_hidden / point.hidden : 1;
    return glm::vec3(1) - (1 - without_ray * part) * shading::glossy_albedo(s);
}

// Whether the lobe of a surface and its reflected ray share what it reflects.
bool TileTracer::stands_for_lobe(const TilePoint& point) const
{
    const shading::SurfacePoint& s = point.surface;
    return sees_image_ && !s.layered && s.transmitted == glm::vec3(0) && image_share(s) > 0;
}

// Splits a path at a point, see split_path().
PathSplits TileTracer::split(const TilePoint& point, glm::vec3& reflected, glm::vec3& refracted) const
{
    const float parts = std::max(point.lobe.rays, 1.0f) * point.parts;
    return split_path(point.throughput * parts, options_.min_throughput, point.splits, reflected, refracted);
}

// Whether a path of a blurred sample is followed: one that brings little of the light of a sample is followed by some
// of its pixel's samples only, with as much more weight.
bool TileTracer::goes_on(Path& path) const
{
    if (!blur_ || !blur_->shares()) return true;
    const float whole = blur_->options().whole_path;
    const float brings = largest(path.throughput) * std::max(path.lobe.rays, 1.0f) * path.parts;
    if (brings >= whole) return true;
    const FurtherSample& sample = samples_[path.pixel];
    const glm::ivec2 at = tile_.pixel_of_image(sample.pixel);
    if (blur_path_place(at, sample.number, bounce_) * whole >= brings) return false;
    path.throughput *= whole / brings;
    return true;
}

// Queues the mirrored and refracted rays from the points just shaded, each kind by itself.
// @param primary  they are primary hits, the lobes of which are traced later
void TileTracer::queue_continuations(bool primary)
{
    next_reflected_.clear();
    next_refracted_.clear();
    for (const TilePoint& point : points_) {
        const shading::SurfacePoint& s = point.surface;
        const shading::Continuation& c = point.next;
        const glm::vec3 lift = s.offset * s.geometric_normal;
        const auto queue = [&](PathQueue& to, const glm::vec3& weight, const glm::vec3& origin,
                               const glm::vec3& direction, const PathEnd& end, std::uint8_t splits,
                               bool straight = false) {
            const glm::vec3 throughput = point.throughput * weight;
            if (largest(throughput) * std::max(point.lobe.rays, 1.0f) * point.parts < options_.min_throughput) return;
            Path path{point.pixel, throughput, s.cone, end, point.lobe, point.parts, straight, splits};
            if (goes_on(path)) to.push(path, origin, 0, direction, k_infinity);
        };
        if (s.layered) {
            queue_layered(point, lift);
        } else {
            const MirroredRay ray = mirrored_ray(point);
            glm::vec3 reflected = ray.weight, refracted = c.refracted_weight;
            const PathSplits splits = split(point, reflected, refracted);
            queue(next_reflected_, reflected, s.position + lift, c.reflected,
                  {point.glossy, sized_ ? ray.own : 1, sees_image_ ? ray.own : 1}, splits.reflected);
            queue(next_refracted_, refracted, s.position - lift, c.refracted, {}, splits.refracted);
        }
        // A ray that goes straight on shows what it would have shown.
        queue(next_refracted_, c.straight_weight, s.position - lift, -s.to_viewer, point.end, point.splits,
              point.straight);
        if (!primary && c.lobe_weight != glm::vec3(0)) queue_nested_lobe(point);
    }
    std::swap(reflected_, next_reflected_);
    std::swap(refracted_, next_refracted_);
}

// Queues rays of a point's lobe.
// @param first  of the pattern
// @param share  of the lobe's light that these rays bring
// @param found  optional: takes as how many rays they count
// @param kept   optional: its rays are kept for the filter
void TileTracer::queue_lobe(const TilePoint& point, std::uint32_t first, const glm::uvec2& flip, std::size_t rays,
                            const LobePath& path, float share, float* found, LobePixel* kept)
{
    const shading::SurfacePoint& s = point.surface;
    lobe_rays_.resize(rays);
    float counts = 0;
    // A ray that stands for a whole lobe is one of several: alone, it would show what the lobe's rays meet without
    // regard to how much of that each of them reflects.
    std::size_t count = rays == 1 && !found && !options_.random_lobes
                            ? shading::choose_lobe_ray(s, first, lobe_rays_.front())
                            : shading::lobe_rays(s, first, flip, options_.random_lobes, lobe_rays_, &counts);
    counts = std::max(counts, k_least_lobe_rays);
    if (count == 0 && !options_.random_lobes) lobe_rays_[count++] = {point.next.reflected, glm::vec3(1)};
    if (found) *found = counts;
    if (kept) kept->rays += counts;
    const float divided = std::max(path.rays, 1.0f);
    for (std::size_t k = 0; k < count; ++k) {
        const glm::vec3 throughput = point.throughput * point.next.lobe_weight * lobe_rays_[k].weight * share;
        if (largest(throughput) * divided * point.parts < options_.min_throughput) continue;
        // Each ray shows what lies in its part of the lobe, which is wide where rays are few.
        shading::RayCone cone = s.cone;
        const float density = divided * lobe_rays_[k].density;
        cone.spread += options_.random_lobes || !(density > 0)
                           ? 4 * shading::lobe_width(s.roughness) / std::sqrt(divided)
                           : std::min(2 / std::sqrt(static_cast<float>(k_pi) * density), k_most_lobe_spread);
        LobePath lobe = path;
        if (kept) {
            LobeRay& ray = kept_rays_.emplace_back();
            ray.direction = lobe_rays_[k].direction, ray.weight = throughput, ray.counts = counts;
            kept_pixels_.push_back(point.pixel);
            lobe_light_.emplace_back(0);
            lobe.light = static_cast<std::uint32_t>(kept_rays_.size());
        }
        if (rays > 1) lobe.number = first + static_cast<std::uint32_t>(k);
        const PathEnd end{point.glossy, sized_ ? 1 - highlight_share(s) : 1, sees_image_ ? 1 - image_share(s) : 1,
                          point.open};
        next_reflected_.push({point.pixel, throughput, cone, end, lobe, point.parts},
                             s.position + s.offset * s.geometric_normal, 0, lobe_rays_[k].direction, k_infinity);
    }
}

// Queues the lobe of a point seen in a mirror, through glass, or by a ray of another lobe. A path is divided once, by a
// lobe or by a rough surface that lets it through.
void TileTracer::queue_nested_lobe(const TilePoint& point)
{
    const glm::ivec2 at = pixel_of_image(point.pixel);
    const bool divided = point.lobe.rays > 0 || point.parts > 1;
    const auto rays = static_cast<std::size_t>(divided ? 1 : rays_of_lobe_);
    LobePath path = point.lobe;
    if (path.rays == 0) path.rays = static_cast<float>(rays);
    std::uint32_t first = point.lobe.number;
    glm::uvec2 flip(0);
    if (options_.random_lobes) {
        const auto pixel = static_cast<std::uint64_t>(at.y) << 32 | static_cast<std::uint64_t>(at.x);
        flip = random_flip(options_.lobe_seed + pixel, first + (static_cast<std::uint64_t>(points_.size()) << 32));
    } else if (divided) {
        // Another order of the numbers of the first lobe.
        first = (first * 5 + 3) % 1024;
    }
    queue_lobe(point, first, flip, rays, path, 1, nullptr, nullptr);
}

// Keeps the primary hits that have a lobe.
void TileTracer::keep_lobes(int sample)
{
    lobe_points_.clear();
    if (spreads_lobes_) lobe_weights_.assign(color_.size(), glm::vec3(0));
    for (const TilePoint& point : points_) {
        if (point.next.lobe_weight == glm::vec3(0)) continue;
        const shadow_culling::ShadowPoint& at = shadow_points_[static_cast<std::size_t>(&point - points_.data())];
        if ((refinement_ && take_lobe(point, at)) || (blur_ && take_still_lobe(point, at))) continue;
        lobe_points_.push_back(point);
        if (!keeps_lobe_rays()) continue;
        const glm::ivec2 shown = pixel_of_image(point.pixel);
        LobePixel& pixel = lobes_->at(shown.x, shown.y);
        const glm::vec3 weight = point.throughput * point.next.lobe_weight;
        pixel.weight += weight, pixel.open += weight * point.open;
        if (spreads_lobes_) lobe_weights_[point.pixel] += weight;
        if (sample != 0) continue;
        const shading::SurfacePoint& s = point.surface;
        pixel.position = s.position, pixel.axis = point.next.reflected, pixel.rays = 0;
        pixel.set_lobe(s.normal, s.to_viewer, shading::lobe_width(s.roughness),
                       shading::glossy_density(s, point.next.reflected));
        pixel.footprint = s.cone.width / std::max(glm::dot(s.geometric_normal, s.to_viewer), k_least_cosine);
    }
    // Rays that are kept have sums of their own.
    if (!lobe_points_.empty() && lobe_light_.empty() && !keeps_lobe_rays())
        lobe_light_.assign(color_.size() * (options_.random_lobes ? k_lobe_batches : 1), glm::vec3(0));
}

// How many rays a primary hit's lobe has: few where the filter adds those of many neighbours.
std::uint32_t TileTracer::number_of_lobe_rays(const glm::ivec2& pixel, std::uint32_t most)
{
    if (!keeps_lobe_rays() || options_.random_lobes) return most;
    LobeFilterOptions options;
    if (sees_image_) options.least_by_turn = 0;   // rays show means of the image
    const float wanted =
        std::as_const(*lobes_).rays_wanted(pixel.x, pixel.y, tile_.x, tile_.y, tile_.width, tile_.height, options) /
        static_cast<float>(std::min(options_.samples, options_.lobe_rays));
    std::uint32_t rays = 1;
    while (rays < most && static_cast<float>(rays) * 1.4142f < wanted) rays *= 2;
    return rays;
}

// Traces the rays of the kept points, and what follows from them, some points at a time.
void TileTracer::trace_lobes(int sample, Stopwatch& watch)
{
    // Many samples of time and lens have few rays each. They have patterns of their own.
    const auto most = static_cast<std::uint32_t>(
        blur_ ? std::max(rays_of_each(static_cast<int>(blur_->most_samples())), k_blurred_lobe_rays) : rays_of_lobe_);
    // Of many samples, the first of a pixel that show a lobe have rays, whose mean serves the others: memory has a
    // bound. The first ones are as well distributed over the pixel as all are.
    const int casting =
        blur_ ? static_cast<int>(blur_->most_samples()) : std::min(options_.samples, options_.lobe_rays);
    const auto samples = static_cast<std::uint32_t>(power_of_two_from(casting));
    const bool keeps = keeps_lobe_rays();
    for (std::size_t begin = 0; begin < lobe_points_.size();) {
        next_reflected_.clear(), next_refracted_.clear();
        for (; begin < lobe_points_.size() && next_reflected_.rays.size() < k_lobe_rays_at_once; ++begin) {
            const TilePoint& point = lobe_points_[begin];
            const int number = keeps   ? lobe_samples_[point.pixel]
                               : blur_ ? static_cast<int>(samples_[point.pixel].number)
                                       : sample;
            if (keeps && number == casting) continue;
            if (keeps) ++lobe_samples_[point.pixel];
            const glm::ivec2 at = pixel_of_image(point.pixel);
            const std::uint32_t rays = number_of_lobe_rays(at, most);
            LobePath path{point.pixel + 1, 0, static_cast<float>(rays)};
            if (!options_.random_lobes) {
                const std::uint32_t block =
                    shading::lobe_block(at.x, at.y) * samples + static_cast<std::uint32_t>(number);
                float counts = 0;
                queue_lobe(point, block * rays, glm::uvec2(0), rays, path, 1, &counts,
                           keeps ? &lobes_->at(at.x, at.y) : nullptr);
                if (blur_) note_blurred_lobe(point, counts / static_cast<float>(rays));
                continue;
            }
            const auto pixel = static_cast<std::uint64_t>(at.y) << 32 | static_cast<std::uint64_t>(at.x);
            for (std::uint32_t batch = 1; batch <= k_lobe_batches; ++batch) {
                queue_lobe(point, 0,
                           random_flip(options_.lobe_seed + pixel,
                                       static_cast<std::uint64_t>(sample) * k_lobe_batches + batch),
                           rays / k_lobe_batches, path, 1.0f / k_lobe_batches, nullptr, nullptr);
                path.light += static_cast<std::uint32_t>(color_.size());
            }
        }
        std::swap(reflected_, next_reflected_);
        std::swap(refracted_, next_refracted_);
        follow_paths(sample, watch);
    }
}

// Hands the light of lobes over: to be filtered, or with its error.
void TileTracer::store_lobes()
{
    if (lobe_light_.empty()) return;
    if (lobes_) {
        for (std::size_t i = 0; i < kept_rays_.size(); ++i) kept_rays_[i].light = lobe_light_[i];
        lobes_->set_rays(tile_.x, tile_.y, kept_pixels_, kept_rays_);
        return;
    }
    for (int y = 0; y < tile_.height; ++y)
        for (int x = 0; x < tile_.width; ++x) {
            const auto from =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(tile_.side) + static_cast<std::size_t>(x);
            glm::vec3 sum(0), square(0);
            const std::size_t batches = lobe_light_.size() / color_.size();
            for (std::size_t b = 0; b < batches; ++b) {
                const glm::vec3& light = lobe_light_[b * color_.size() + from];
                sum += light, square += light * light;
            }
            color_[from] += sum;
            if (!is_estimate_ || batches < 2) continue;
            const auto n = static_cast<float>(batches);
            variance_[from] += glm::max(square - sum * sum / n, glm::vec3(0)) * (n / (n - 1));
        }
}

// Queues the rays of a layered surface. Base and coat share the mirrored ray, and each leaves out of it what its lobe
// reflects instead; rough transmission takes several rays.
void TileTracer::queue_layered(const TilePoint& point, const glm::vec3& lift)
{
    const shading::SurfacePoint& s = point.surface;
    const shading::Continuation& c = point.next;
    glm::vec3 reflected = c.reflected_weight, refracted = c.refracted_weight;
    const PathSplits splits = split(point, reflected, refracted);
    Path path{point.pixel, point.throughput * reflected, s.cone};
    path.lobe = point.lobe, path.parts = point.parts, path.splits = splits.reflected;
    if (largest(path.throughput) * path.parts >= options_.min_throughput) {
        const float coat = std::clamp(c.coat_reflected / largest(reflected), 0.0f, 1.0f);
        const auto shown = [&](bool by_lobe, bool by_coat) {
            const float base = point.glossy ? 0 : by_lobe ? 1 - highlight_share(s) : 1;
            const float of_coat = point.coat_glossy ? 0 : by_coat ? 1 - coat_highlight_share(s) : 1;
            return coat * of_coat + (1 - coat) * base;
        };
        // What the base's lobe shows of the image is not hidden by what the ray meets.
        const float left = 1 - (1 - coat) * point.image_by_lobe;
        const auto of_rest = [&](float part) { return left > 0 ? std::min(part / left, 1.0f) : 0; };
        path.throughput *= left;
        path.end.emission = of_rest(shown(sized_.has_value(), sized_.has_value()));
        path.end.background = of_rest(shown(sees_image_, false));
        if (goes_on(path)) next_reflected_.push(path, s.position + lift, 0, c.reflected, k_infinity);
    }
    shading::find_transmitted(s, c, point.parts > 1, transmitted_);
    for (std::uint32_t number = 0; number < transmitted_.size(); ++number) {
        const shading::TransmittedRay& ray = transmitted_[number];
        Path through{point.pixel, point.throughput * refracted * ray.part, s.cone};
        through.lobe = point.lobe, through.splits = splits.refracted, through.parts = point.parts;
        // The parts of a path are many, and each of them goes on along the brighter of two rays.
        if (ray.spread > 0) {
            through.parts *= static_cast<float>(transmitted_.size());
            through.splits = k_most_splits;
            if (point.lobe.rays == 0) through.lobe.number = number;
        }
        if (largest(through.throughput) * through.parts < options_.min_throughput) continue;
        through.cone.spread += ray.spread;
        if (goes_on(through)) next_refracted_.push(through, s.position - lift, 0, ray.direction, k_infinity);
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
            if (options_.backdrop_apart)
                out.alpha.pixel(px, py)[0] = 1 - std::clamp(luminance(backdrop_[from] * weight), 0.0f, 1.0f);
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
