// SPDX-License-Identifier: Apache-2.0
// Traces the paths of the reference, many at a time: all rays of one bounce wait in a queue and are traced together.
#include <algorithm>

#include "base/check.h"
#include "base/interruption.h"
#include "ray/light_through.h"
#include "ray/origin.h"
#include "reference/reference.h"
#include "shading/glossy.h"

namespace gnomon::reference {

namespace {

// Batches of a point's samples. Their spread gives the error with 15 degrees of freedom. Of fewer samples there are
// fewer batches, so that each is large enough to profit from stratified sampling.
constexpr int k_batches = 16, k_fewer_batches = 8;
constexpr int k_good_batch = 64, k_least_batch = 8;   // samples; for fewer, every sample is a batch of its own
constexpr std::size_t k_paths_at_once = 2048;

// Paths of low throughput end at random from this bounce on; the weight of those that continue compensates.
constexpr int k_first_roulette = 2;
constexpr float k_full_throughput = 0.5f;   // that of paths which none of this ends
constexpr float k_least_survival = 0.1f;

// A ray passes at most this many surfaces that do not block light; then it is lost.
constexpr int k_most_passes = 64;
constexpr float k_least_cosine = 1e-2f;   // least cosine taken for a ray that passes them

// What a path decides at each of its surfaces; the number of a decision is unique along the path.
enum Decision : std::uint32_t { environment, emitter, place_on_emitter, light, sun, direction, survival, decisions };

std::uint32_t decision_at(int bounce, Decision what)
{
    return static_cast<std::uint32_t>(bounce) * decisions + what;
}

constexpr std::uint32_t k_passing = 1u << 30;   // decisions of a path at surfaces that thin light
constexpr std::uint32_t k_finer = 1u << 28;     // further digits of other decisions

constexpr auto k_float_pi = static_cast<float>(k_pi);

// A density per unit of area as one per unit of solid angle, seen along a ray of unit direction that meets the surface
// at this distance. Infinite for a surface that is seen edge-on.
float solid_density(float per_area, float distance, const glm::vec3& direction, const shading::SurfacePoint& s)
{
    if (!(per_area > 0)) return 0;
    const float cosine = std::abs(glm::dot(direction, s.geometric_normal));
    return cosine > 0 ? per_area * distance * distance / cosine : k_infinity;
}

int batches_of(int samples)
{
    if (samples >= k_batches * k_good_batch) return k_batches;
    return samples >= k_fewer_batches * k_least_batch ? k_fewer_batches : samples;
}

}   // namespace

// Accumulates mean and standard error of one point's samples, batch by batch.
class ReferencePaths::Sum {
 public:
    explicit Sum(int samples) : samples_(samples), batches_(batches_of(samples)) {}

    int batch_size(int batch) const { return samples_ / batches_ + (batch < samples_ % batches_ ? 1 : 0); }
    int batches() const { return batches_; }
    bool complete() const { return batch_ == batches_; }

    void add(const Path& path)
    {
        part_[0] += glm::dvec3(path.indirect);
        part_[1] += glm::dvec3(path.surroundings);
        if (++in_batch_ < batch_size(batch_)) return;
        // Weight a batch by its number of samples.
        const double weight = static_cast<double>(in_batch_) / samples_;
        const double mean_of = 1.0 / in_batch_;
        const glm::dvec3 mean[3] = {mean_of * part_[0], mean_of * part_[1], mean_of * (part_[0] + part_[1])};
        for (int i = 0; i < 3; ++i) {
            sum_[i] += weight * mean[i];
            weighted_[i] += weight * weight * mean[i];
            square_[i] += weight * weight * mean[i] * mean[i];
        }
        weight2_ += weight * weight;
        part_[0] = part_[1] = glm::dvec3(0);
        in_batch_ = 0;
        ++batch_;
    }

    IrradianceEstimate estimate() const
    {
        IrradianceEstimate result;
        result.indirect = glm::vec3(sum_[0]);
        result.surroundings = glm::vec3(sum_[1]);
        result.indirect_error = error(0);
        result.error = error(2);
        return result;
    }

 private:
    glm::vec3 error(int i) const
    {
        if (batches_ < 2) return glm::vec3(0);
        const glm::dvec3 spread = square_[i] - 2.0 * sum_[i] * weighted_[i] + weight2_ * sum_[i] * sum_[i];
        return glm::vec3(glm::sqrt(glm::max(spread, glm::dvec3(0)) * (batches_ / (batches_ - 1.0))));
    }

    int samples_, batches_;
    int batch_ = 0, in_batch_ = 0;
    glm::dvec3 part_[2]{glm::dvec3(0), glm::dvec3(0)};   // of the present batch: indirect, surroundings
    // Over batches: of indirect, surroundings, both.
    glm::dvec3 sum_[3]{}, weighted_[3]{}, square_[3]{};
    double weight2_ = 0;
};

void ReferencePaths::estimate(std::span<const Request> requests, IrradianceEstimate* out)
{
    // Start as many paths as fit, trace them, and add them up in the order they were started.
    std::vector<Sum> sums;
    sums.reserve(requests.size());
    for (const Request& request : requests) sums.emplace_back(request.samples);
    std::size_t reading = 0;
    paths_.clear();
    const auto flush = [&] {
        interruption_point();
        run_paths();
        for (const Path& path : paths_) {
            sums[reading].add(path);
            if (sums[reading].complete()) ++reading;
        }
        paths_.clear();
    };
    for (std::size_t r = 0; r < requests.size(); ++r) {
        GNOMON_CHECK(requests[r].samples >= 1);
        for (int b = 0; b < sums[r].batches(); ++b) {
            int sample = 0;
            for (const auto& [u, v] : pattern_.points(sums[r].batch_size(b))) {
                push_first(requests[r], b, u, v, sample++);
                if (paths_.size() == k_paths_at_once) flush();
            }
        }
    }
    flush();
    for (std::size_t r = 0; r < requests.size(); ++r) out[r] = sums[r].estimate();
}

void ReferencePaths::push_first(const Request& request, int batch, std::uint32_t u, std::uint32_t v, int sample)
{
    const IrradiancePoint& point = request.point;
    const std::uint64_t stream = mix(light_.options_.seed, point.key);
    const std::uint64_t flip = mix(stream, static_cast<std::uint64_t>(batch));
    Path& path = paths_.emplace_back(Path{PathNumbers(flip, static_cast<std::uint32_t>(sample)), point.position,
                                          point.position + point.offset * point.geometric_normal,
                                          point.geometric_normal, point.normal, point.smooth_normal,
                                          point.smooth_origin, glm::vec3(1), glm::vec3(0), glm::vec3(0), glm::vec3(0)});
    if (path.smooth_normal == glm::vec3(0))
        path.smooth_normal = path.geometric_normal, path.smooth_origin = path.origin;
    const float a = unit_fraction(u ^ static_cast<std::uint32_t>(flip));
    const float b = unit_fraction(v ^ static_cast<std::uint32_t>(flip >> 32));
    path.glossy = request.glossy;
    if (!path.glossy) {
        path.direction = cosine_direction(point.normal, a, b);
        return;
    }
    // Weigh the path so that pi times its weight times a radiance is what the lobe reflects of it.
    path.direction = shading::sample_glossy(*path.glossy, a, b);
    const float density = shading::glossy_density(*path.glossy, path.direction);
    path.weight =
        density > 0 ? shading::reflect_glossy(*path.glossy, path.direction) / (k_float_pi * density) : glm::vec3(0);
}

// The density per steradian with which the path's next direction is chosen.
float ReferencePaths::own_density(const Path& path, const glm::vec3& direction)
{
    if (path.glossy) return shading::glossy_density(*path.glossy, direction);
    return std::max(glm::dot(direction, path.normal), 0.0f) / k_float_pi;
}

// What radiance 1 from a direction adds per steradian to the estimate.
glm::vec3 ReferencePaths::response(const Path& path, const glm::vec3& direction)
{
    if (path.glossy) return shading::reflect_glossy(*path.glossy, direction);
    return path.weight * std::max(glm::dot(direction, path.normal), 0.0f);
}

void ReferencePaths::run_paths()
{
    counters_.paths += paths_.size();
    standing_.resize(paths_.size());
    for (std::uint32_t i = 0; i < paths_.size(); ++i) standing_[i] = i;
    find_lit_places();
    for (int bounce = 0;; ++bounce) {
        ask_environment(bounce);
        ask_emitters(bounce);
        connect(bounce);
        if (!trace_on(bounce)) return;
        ask_lights(bounce);
        choose_directions(bounce);
        if (bounce + 1 < k_first_roulette) continue;
        std::erase_if(standing_, [&](std::uint32_t i) {
            Path& path = paths_[i];
            const float most = std::max({path.weight.x, path.weight.y, path.weight.z});
            const float chance = std::clamp(most / k_full_throughput, k_least_survival, 1.0f);
            if (chance < 1 && path.numbers.one(decision_at(bounce, survival)) >= chance) return true;
            path.weight /= chance;
            return false;
        });
    }
}

// Samples the bright parts of the environment image from the surface of each path.
void ReferencePaths::ask_environment(int bounce)
{
    if (!light_.environment_) return;
    shadow_rays_.clear(), shadow_path_.clear(), shadow_gain_.clear();
    for (const std::uint32_t i : standing_) {
        Path& path = paths_[i];
        const glm::vec2 at = path.numbers.pair(decision_at(bounce, environment));
        float density;
        const glm::vec3 direction = light_.environment_->sample(at.x, at.y, density);
        const float cosine = glm::dot(direction, path.normal);
        if (cosine <= 0 || !path.is_above(direction) || !(density > 0)) continue;
        shadow_rays_.push(path.origin_to(direction), 0, direction, k_infinity);
        shadow_path_.push_back(i);
        shadow_gain_.push_back(response(path, direction) * light_.background_.radiance(direction) /
                               (density + own_density(path, direction)));
    }
    trace_shadows(bounce == 0);
}

// Samples a point of an emissive surface from the surface of each path.
void ReferencePaths::ask_emitters(int bounce)
{
    if (!light_.emitters_) return;
    rays_.clear(), ray_path_.clear(), emitter_points_.clear();
    for (const std::uint32_t i : standing_) {
        Path& path = paths_[i];
        const glm::vec2 at = path.numbers.pair(decision_at(bounce, place_on_emitter));
        // A number for as many choices as the tree has levels.
        const double choice = static_cast<double>(path.numbers.one(decision_at(bounce, emitter))) +
                              0x1p-24 * static_cast<double>(path.numbers.one(k_finer + decision_at(bounce, emitter)));
        const EmitterPoint point = light_.emitters_->sample_for(path.position, path.normal, choice, at.x, at.y);
        if (!(point.density > 0)) continue;
        const glm::vec3& origin = path.origin_to(point.position - path.position);
        const glm::vec3 to_point = point.position - origin;
        const float distance = glm::length(to_point);
        if (!(distance > 0)) continue;
        const glm::vec3 direction = to_point / distance;
        if (glm::dot(direction, path.normal) <= 0 || !path.is_above(direction)) continue;
        rays_.push(origin, 0, direction, k_infinity);
        ray_path_.push_back(i);
        emitter_points_.push_back(point);
    }
    const std::size_t count = rays_.size();
    if (count == 0) return;

    // The point counts where it is the first surface that the ray meets.
    counters_.rays += count;
    hits_.resize(count);
    light_.rays_.closest(rays_, 0, count, hits_, ray::Sides::both);
    if (light_.transparent_) pass_transparent();
    for (std::size_t r = 0; r < count; ++r) {
        const EmitterPoint& point = emitter_points_[r];
        if (hits_.object[r] != point.object || hits_.triangle[r] != point.triangle) continue;
        const shading::SurfacePoint s = surface_of(r);
        const glm::vec3 emission = EmitterSampler::emission(s, material_of(r));
        if (emission == glm::vec3(0) || (bounce == 0 && !light_.options_.shining_unbounced)) continue;
        const glm::vec3 direction = rays_.direction(r);
        Path& path = paths_[ray_path_[r]];
        const float density = solid_density(point.density, hits_.t[r], direction, s);
        const glm::vec3 passed = light_.transparent_ ? passed_[r] : glm::vec3(1);
        gain(path, bounce, passed * response(path, direction) * emission / (density + own_density(path, direction)));
    }
}

void ReferencePaths::gain(Path& path, int bounce, const glm::vec3& irradiance)
{
    (bounce == 0 ? path.surroundings : path.indirect) += irradiance;
}

// Continues each path to the next surface. A path that meets none is done.
// @return whether any path met a surface and may bounce
bool ReferencePaths::trace_on(int bounce)
{
    const bool last = bounce >= light_.options_.bounces;
    const bool lobes = bounce == 0 && std::any_of(standing_.begin(), standing_.end(),
                                                  [&](std::uint32_t i) { return paths_[i].glossy != nullptr; });
    if (last && !light_.background_shines_ && !light_.emitters_ && !lobes) return false;
    rays_.clear(), ray_path_.clear();
    for (const std::uint32_t i : standing_) {
        const Path& path = paths_[i];
        // A direction above the shading normal's horizon may lie below the surface's.
        if (!path.is_above(path.direction)) continue;
        rays_.push(path.origin_to(path.direction), 0, path.direction, k_infinity);
        ray_path_.push_back(i);
    }
    standing_.clear();
    const std::size_t count = rays_.size();
    if (count == 0) return false;
    counters_.rays += count;
    const auto background = [&](std::size_t ray) {
        const Path& path = paths_[ray_path_[ray]];
        glm::vec3 radiance = light_.background_.radiance(path.direction);
        if (light_.environment_) {
            const float own = own_density(path, path.direction);
            const float other = light_.environment_->density(path.direction);
            radiance *= own / std::max(own + other, std::numeric_limits<float>::min());
        }
        gain(paths_[ray_path_[ray]], bounce, path.weight * k_float_pi * radiance);
    };

    // The last ray only needs to know whether it leaves the scene.
    if (last && !light_.emitters_ && !lobes) {
        occluded_.resize(count + ray::k_packet_pad);
        light_.rays_.occluded(rays_, 0, count, occluded_.data());
        if (light_.rays_.thins_light()) let_through(rays_);
        for (std::size_t r = 0; r < count; ++r) {
            if (occluded_[r]) continue;
            if (light_.rays_.thins_light()) paths_[ray_path_[r]].weight *= passed_[r];
            background(r);
        }
        return false;
    }

    hits_.resize(count);
    light_.rays_.closest(rays_, 0, count, hits_, ray::Sides::both);
    if (light_.transparent_) pass_transparent();
    for (std::size_t r = 0; r < count; ++r) {
        Path& path = paths_[ray_path_[r]];
        if (light_.transparent_) path.weight *= passed_[r];
        if (hits_.object[r] == scene::none) {
            if (light_.background_shines_ || path.glossy) background(r);
            continue;
        }
        const shading::SurfacePoint s = surface_of(r);
        if (light_.emitters_) {
            const glm::vec3 emission = EmitterSampler::emission(s, material_of(r));
            const float own = own_density(path, path.direction);
            float other = 0;
            if (emission != glm::vec3(0))
                other = solid_density(
                    light_.emitters_->density_for(path.position, path.normal, hits_.object[r], hits_.triangle[r]),
                    hits_.t[r], path.direction, s);
            if (emission != glm::vec3(0) && (bounce > 0 || light_.options_.shining_unbounced))
                gain(path, bounce,
                     path.weight * k_float_pi * (own / std::max(own + other, std::numeric_limits<float>::min())) *
                         emission);
        }
        path.weight *= s.diffuse;
        path.inverse_density = 0;
        if (connects(bounce)) {
            const float density =
                own_density(path, path.direction) * std::abs(glm::dot(path.direction, s.geometric_normal));
            if (density > 0) path.inverse_density = hits_.t[r] * hits_.t[r] / density;
        }
        if (path.glossy || last || path.weight == glm::vec3(0)) continue;
        path.position = s.position;
        path.origin = s.position + s.offset * s.geometric_normal;
        path.geometric_normal = s.geometric_normal, path.normal = s.normal;
        path.smooth_normal = s.smooth_normal, path.smooth_origin = path.origin;
        if (s.smooth_normal != s.geometric_normal)
            path.smooth_origin = shading::smooth_origin(light_.rays_.geometry(hits_.object[r]), hits_.triangle[r],
                                                        hits_.u[r], hits_.v[r], s);
        // AFF's lights lack a factor of pi.
        path.aff = s.model == scene::ShadingModel::whitted;
        standing_.push_back(ray_path_[r]);
    }
    return !standing_.empty();
}

// Continues rays that met a surface that does not block light, behind it.
void ReferencePaths::pass_transparent()
{
    // A surface that lets a part of the light through blocks a path with the probability of the rest.
    const auto blocks = [&](std::size_t r) {
        if (hits_.object[r] == scene::none) return true;
        const scene::Material& material = material_of(r);
        if (material.surface_class() != scene::SurfaceClass::transparent) return true;
        if (!scene::thins_light(material)) return false;
        const scene::Scene& scene = light_.state_.scene();
        const scene::Mesh& mesh = scene.meshes[scene.objects[hits_.object[r]].mesh];
        const glm::vec3 passes = ray::let_through(scene, mesh, material, hits_.triangle[r], hits_.u[r], hits_.v[r]);
        const float chance = std::max({passes.x, passes.y, passes.z});
        Path& path = paths_[ray_path_[r]];
        if (!(path.numbers.one(k_passing + path.passes++) < chance)) return true;
        passed_[r] *= passes / chance;
        return false;
    };
    passed_.assign(rays_.size(), glm::vec3(1));
    std::vector<std::uint8_t> blocked(rays_.size(), 0);
    for (int pass = 0; pass < k_most_passes; ++pass) {
        passing_.clear(), passing_ray_.clear();
        for (std::uint32_t r = 0; r < rays_.size(); ++r) {
            if (blocked[r]) continue;
            if (blocks(r)) {
                blocked[r] = 1;
                continue;
            }
            // Start behind the surface by the rounding error of a hit's distance.
            const shading::SurfacePoint s = surface_of(r);
            const float cosine = std::abs(glm::dot(s.geometric_normal, rays_.direction(r)));
            const float tnear = hits_.t[r] + s.offset / std::max(cosine, k_least_cosine);
            passing_.push(rays_.origin(r), tnear, rays_.direction(r), k_infinity);
            passing_ray_.push_back(r);
        }
        if (passing_.empty()) return;
        counters_.rays += passing_.size();
        next_hits_.resize(passing_.size());
        light_.rays_.closest(passing_, 0, passing_.size(), next_hits_, ray::Sides::both);
        for (std::size_t i = 0; i < passing_ray_.size(); ++i) {
            const std::uint32_t r = passing_ray_[i];
            hits_.t[r] = next_hits_.t[i], hits_.u[r] = next_hits_.u[i], hits_.v[r] = next_hits_.v[i];
            hits_.object[r] = next_hits_.object[i], hits_.triangle[r] = next_hits_.triangle[i];
        }
    }
    for (std::uint32_t r = 0; r < rays_.size(); ++r)
        if (!blocked[r]) hits_.object[r] = scene::none;
}

shading::SurfacePoint ReferencePaths::surface_of(std::size_t r) const
{
    shading::SurfacePoint s;
    shading::surface_at(light_.state_.scene(), light_.rays_.geometry(hits_.object[r]), hits_.triangle[r], hits_.u[r],
                        hits_.v[r], hits_.t[r], rays_.direction(r), {}, s);
    return s;
}

const scene::Material& ReferencePaths::material_of(std::size_t r) const
{
    const scene::Scene& scene = light_.state_.scene();
    const scene::Mesh& mesh = scene.meshes[scene.objects[hits_.object[r]].mesh];
    return scene.materials[mesh.part_of(hits_.triangle[r]).material];
}

// Samples one light from the surface of each path.
void ReferencePaths::ask_lights(int bounce)
{
    if (light_.lights_.empty()) return;
    const scene::Scene& scene = light_.state_.scene();
    shadow_rays_.clear(), shadow_path_.clear(), shadow_gain_.clear();
    for (const std::uint32_t i : standing_) {
        Path& path = paths_[i];
        const double number =
            light_.lights_.size() > 1 ? static_cast<double>(path.numbers.one(decision_at(bounce, light))) : 0;
        const LightChoice::Chosen chosen =
            light_.choice_->choose(path.position, path.normal, path.smooth_normal, number, choice_);
        if (!(chosen.chance > 0)) continue;
        const scene::LightId l = light_.lights_[chosen.light];
        const scene::LightState& at = light_.state_.light(l);
        const scene::LightSample& sample = chosen.sample;
        const bool directional = scene.lights[l].type == scene::LightType::directional;
        const glm::vec3& origin = path.origin_to(sample.to_light);
        glm::vec3 way = directional ? -at.direction : at.position - origin;
        if (directional && light_.options_.sun_diameter > 0 && !scene.lights[l].of_environment) {
            // A direction of the disc; below the horizon, it brings nothing.
            glm::vec3 across, up;
            make_basis(way, across, up);
            const float reach = static_cast<float>(std::tan(0.5 * light_.options_.sun_diameter));
            const glm::vec2 on_disc = path.numbers.pair(decision_at(bounce, sun));
            const float r = reach * std::sqrt(on_disc.x), turn = 2 * k_float_pi * on_disc.y;
            way = glm::normalize(way + r * std::cos(turn) * across + r * std::sin(turn) * up);
            if (!path.is_above(way) || glm::dot(way, path.normal) <= 0) continue;
        }
        const float cosine = glm::dot(directional ? way : sample.to_light, path.normal);
        shadow_rays_.push(directional ? path.origin_to(way) : origin, 0, way,
                          directional ? k_infinity : ray::k_shadow_ray_end);
        shadow_path_.push_back(i);
        const bool lacks_pi = path.aff && !scene.lights[l].of_environment;
        // Weigh the chance of this light against the density of its own rays.
        float chance = chosen.chance;
        if (path.inverse_density > 0 && !directional)
            chance += from_light(
                path, sample.to_light,
                light_.emission_->density(chosen.light, -sample.to_light) / (sample.distance * sample.distance));
        shadow_gain_.push_back(path.weight * sample.irradiance * ((lacks_pi ? k_float_pi : 1.0f) * cosine / chance));
    }
    trace_shadows(false);
}

void ReferencePaths::trace_shadows(bool to_surroundings)
{
    const std::size_t count = shadow_rays_.size();
    if (count == 0) return;
    counters_.rays += count;
    occluded_.resize(count + ray::k_packet_pad);
    light_.rays_.occluded(shadow_rays_, 0, count, occluded_.data());
    if (light_.rays_.thins_light()) let_through(shadow_rays_);
    for (std::size_t r = 0; r < count; ++r) {
        if (occluded_[r]) continue;
        Path& path = paths_[shadow_path_[r]];
        const glm::vec3 gain = light_.rays_.thins_light() ? passed_[r] * shadow_gain_[r] : shadow_gain_[r];
        (to_surroundings ? path.surroundings : path.indirect) += gain;
    }
}

void ReferencePaths::let_through(const ray::RayQueue& rays)
{
    passed_.resize(rays.size());
    light_.rays_.let_through(rays, 0, rays.size(), passed_.data());
}

void ReferencePaths::choose_directions(int bounce)
{
    for (const std::uint32_t i : standing_) {
        Path& path = paths_[i];
        const glm::vec2 at = path.numbers.pair(decision_at(bounce, direction));
        path.direction = cosine_direction(path.normal, at.x, at.y);
    }
}

}   // namespace gnomon::reference
