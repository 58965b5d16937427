// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_light.h"

#include <algorithm>
#include <cmath>

#include "base/morton.h"
#include "lighting/diffuse.h"
#include "ray/origin.h"

namespace gnomon::irradiance_cache {

namespace {

// The sum is irradiance for the point's own normal. For other normals it must stay bounded at grazing angles.
constexpr float k_least_cosine = 0.1f;

// The cell, of 16 across, in which a coordinate of a unit vector lies.
std::uint32_t cell_of(float coordinate)
{
    return static_cast<std::uint32_t>(std::clamp(8 + 8 * coordinate, 0.0f, 15.0f));
}

// Tangent, bitangent and normal of a receiver.
glm::mat3 axes_of(const NearReceiver& receiver)
{
    glm::vec3 t, b;
    make_basis(receiver.normal, t, b);
    return {t, b, receiver.normal};
}

void push_short_ray(const NearReceiver& receiver, const glm::mat3& axes, const glm::vec3& d, float radius,
                    ray::RayQueue& queue)
{
    queue.push(receiver.origin, 0, d.x * axes[0] + d.y * axes[1] + d.z * axes[2], radius);
}

}   // namespace

std::vector<glm::vec3> cosine_directions(int count)
{
    constexpr double k_golden_angle = 2.399963229728653;
    std::vector<glm::vec3> directions;
    for (int i = 0; i < count; ++i) {
        const double r = std::sqrt((i + 0.5) / count), phi = i * k_golden_angle;
        directions.emplace_back(r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r));
    }
    std::stable_sort(directions.begin(), directions.end(), [](const glm::vec3& a, const glm::vec3& b) {
        return morton_code(cell_of(a.x), cell_of(a.y)) < morton_code(cell_of(b.x), cell_of(b.y));
    });
    return directions;
}

NearLight::NearLight(const NearOptions& options) : options_(options), directions_(cosine_directions(options.rays)) {}

// A surface that a short ray meets.
struct NearLight::Met {
    std::size_t receiver, ray;
    glm::vec3 normal;      // of the receiver
    glm::vec3 factor{1};   // of the light that it reflects
};

// Queues a ray to each light that shines on a surface.
// @return  how much of its light is a part of the near field, 0 to 1
float NearLight::light_surface(const scene::SceneState& state, const ray::RayScene& rays, const Met& met,
                               Scratch& scratch) const
{
    const scene::Scene& scene = state.scene();
    const std::size_t i = met.ray;
    const glm::vec3 direction = scratch.rays.direction(i);
    const auto weight = static_cast<float>(k_pi) / static_cast<float>(directions_.size());
    const ray::ObjectGeometry& geometry = rays.geometry(scratch.hits.object[i]);
    const std::uint32_t triangle = scratch.hits.triangle[i];
    glm::vec3 p[3];
    geometry.corners(triangle, p);
    const float u = scratch.hits.u[i], v = scratch.hits.v[i];
    glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(normal);
    if (!(length > 0)) return 0;
    normal /= length;
    if (glm::dot(normal, direction) > 0) normal = -normal;
    const glm::vec3 position = std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2];
    const glm::vec3 from = position + ray::origin_lift(p) * normal;
    glm::vec3 exitance(-1);
    float most = -1;
    for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
        const scene::Light& light = scene.lights[l];
        const scene::LightState& at = state.light(l);
        if (!takes_part(light, at)) continue;
        const scene::LightSample sample = scene::illuminate(light, at, position);
        const float cosine = glm::dot(normal, sample.to_light);
        if (!(cosine > 0) || sample.irradiance == glm::vec3(0)) continue;
        const float width = options_.tree ? options_.tree->leaf_width(l, position, cosine) : k_infinity;
        const float near = 1 - far_fraction(scratch.hits.t[i], options_.radius_at(width));
        most = std::max(most, near);
        if (!(near > 0)) continue;
        if (exitance.x < 0) exitance = met.factor * lighting::exitance_per_irradiance(scene, geometry, triangle, u, v);
        if (exitance == glm::vec3(0)) break;
        if (light.type == scene::LightType::directional)
            scratch.shadow_rays.push(from, 0, -at.direction, k_infinity);
        else
            scratch.shadow_rays.push(from, 0, at.position - from, ray::k_shadow_ray_end);
        const glm::vec3 radiance = exitance * sample.irradiance * (cosine / static_cast<float>(k_pi));
        const float at_point = std::max(glm::dot(direction, met.normal), k_least_cosine);
        scratch.lit.push_back({met.receiver, radiance * (near * weight), direction / at_point, i});
    }
    return most < 0 ? 1 - far_fraction(scratch.hits.t[i], options_.radius) : most;
}

// Lets the rays in scratch.on go on behind surfaces that thin light, with what these let through of the light from
// beyond.
void NearLight::light_behind(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                             ray::Against against, Scratch& scratch) const
{
    constexpr int k_most_surfaces = 8;
    for (int surface = 0; surface < k_most_surfaces && !scratch.on.empty(); ++surface) {
        scratch.behind.find(rays, scratch.rays, scratch.on, against, scratch.hits);
        scratch.cast += scratch.on.size();
        scratch.next_on.clear();
        for (const std::uint32_t i : scratch.on) {
            const std::size_t k = scratch.receiver_of[i];
            ray::ThinSurface thin{.passes = glm::vec3(0), .covered = 1};
            if (scratch.hits.object[i] == scene::none) continue;
            if (ray::hits_thin_surface(state.scene(), rays, scratch.hits, i, thin)) scratch.next_on.push_back(i);
            if (!state.is_dynamic(scratch.hits.object[i]))
                light_surface(state, rays, {k, i, receivers[k].normal, thin.covered * scratch.passes[i]}, scratch);
            scratch.passes[i] *= thin.passes;
        }
        scratch.on.swap(scratch.next_on);
    }
}

// Queues all short rays of some receivers.
void NearLight::queue_all(const NearReceiver* receivers, std::size_t count, Scratch& scratch) const
{
    scratch.rays.clear();
    scratch.receiver_of.clear();
    for (std::uint32_t k = 0; k < count; ++k) {
        const glm::mat3 axes = axes_of(receivers[k]);
        for (const glm::vec3& d : directions_) push_short_ray(receivers[k], axes, d, options_.radius, scratch.rays);
        scratch.receiver_of.insert(scratch.receiver_of.end(), directions_.size(), k);
    }
}

// Queues those short rays that lead to surfaces whose light a dynamic object may occlude.
void NearLight::queue_doubted(const scene::SceneState& state, const MovingSpheres& spheres,
                              const NearReceiver* receivers, std::size_t count, Scratch& scratch) const
{
    scratch.lights.clear();
    const scene::Scene& scene = state.scene();
    for (scene::LightId l = 0; l < scene.lights.size(); ++l)
        if (takes_part(scene.lights[l], state.light(l)))
            scratch.lights.push_back(way_to(scene.lights[l], state.light(l)));
    scratch.rays.clear();
    scratch.receiver_of.clear();
    NearDoubts doubts(options_.radius, directions_);
    for (std::uint32_t k = 0; k < count; ++k) {
        const glm::mat3 axes = axes_of(receivers[k]);
        doubts.find(receivers[k], axes, scratch.lights, spheres, scratch.directions);
        for (const std::uint32_t i : scratch.directions)
            push_short_ray(receivers[k], axes, directions_[i], options_.radius, scratch.rays);
        scratch.receiver_of.insert(scratch.receiver_of.end(), scratch.directions.size(), k);
    }
}

// Casts the queued short rays, and queues a ray to each light that shines on a surface that they meet.
void NearLight::find_lit(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                         std::size_t count, ray::Against against, Scratch& scratch, NearAnswer* answers) const
{
    const bool thins = rays.thins_light();
    // Cast the short rays.
    ray::RayQueue& queue = scratch.rays;
    queue.purpose = scratch.shadow_rays.purpose = ray::RayClass::indirect;
    scratch.hits.resize(queue.size());
    rays.closest(queue, 0, queue.size(), scratch.hits, ray::Sides::both, against);
    scratch.cast += queue.size();

    // Light the surfaces that they meet, and queue a ray to each light.
    scratch.shadow_rays.clear();
    scratch.lit.clear();
    scratch.on.clear();
    if (thins) scratch.passes.assign(queue.size(), glm::vec3(1));
    std::fill(answers, answers + count, NearAnswer{});
    const float ray_share = 1 / static_cast<float>(directions_.size());
    for (std::size_t i = 0; i < queue.size(); ++i) {
        const std::uint32_t k = scratch.receiver_of[i];
        const scene::ObjectId object = scratch.hits.object[i];
        if (object == scene::none) continue;
        answers[k].nearest = std::min(answers[k].nearest, scratch.hits.t[i]);
        if (!(glm::dot(queue.direction(i), receivers[k].horizon) > 0)) continue;
        Met met{k, i, receivers[k].normal};
        if (ray::ThinSurface thin; thins && ray::hits_thin_surface(state.scene(), rays, scratch.hits, i, thin)) {
            met.factor = glm::vec3(thin.covered);
            scratch.passes[i] = thin.passes;
            scratch.on.push_back(static_cast<std::uint32_t>(i));
        }
        if (!state.is_dynamic(object)) answers[k].form_factor += ray_share * light_surface(state, rays, met, scratch);
    }
    light_behind(state, rays, receivers, against, scratch);
}

// Finds how far the short rays go that lead to surfaces of which a light is not occluded.
void NearLight::note_reach(const NearReceiver* receivers, std::size_t count, const Scratch& scratch,
                           std::uint8_t* reach) const
{
    const ReachSteps steps(options_.radius);
    std::fill(reach, reach + count * directions_.size(), ReachSteps::k_nothing_lit);
    for (std::size_t s = 0; s < scratch.lit.size(); ++s) {
        if (scratch.occluded[s]) continue;
        const std::size_t i = scratch.lit[s].ray;
        reach[i] = steps.encode(receivers[scratch.lit[s].receiver].origin, scratch.rays.direction(i), scratch.hits.t[i],
                                scratch.shadow_rays.origin(s));
    }
}

void NearLight::gather(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                       std::size_t count, ray::Against against, Scratch& scratch, NearAnswer* answers,
                       std::uint8_t* reach) const
{
    queue_all(receivers, count, scratch);
    find_lit(state, rays, receivers, count, against, scratch, answers);
    // Add the light that arrives.
    const std::size_t shadow_rays = scratch.shadow_rays.size();
    scratch.cast += shadow_rays;
    scratch.occluded.resize(shadow_rays + ray::k_packet_pad);
    rays.occluded(scratch.shadow_rays, 0, shadow_rays, scratch.occluded.data(), against);
    if (rays.thins_light()) {
        scratch.lit_passes.resize(shadow_rays);
        rays.let_through(scratch.shadow_rays, 0, shadow_rays, scratch.lit_passes.data(), against);
        for (std::size_t s = 0; s < shadow_rays; ++s) scratch.lit[s].light *= scratch.lit_passes[s];
    }
    for (std::size_t s = 0; s < shadow_rays; ++s) {
        if (scratch.occluded[s]) continue;
        const Scratch::Lit& lit = scratch.lit[s];
        for (int colour = 0; colour < 3; ++colour)
            answers[lit.receiver].light[colour] += lit.light[colour] * lit.direction;
    }
    if (!reach) return;
    if (rays.thins_light())
        std::fill(reach, reach + count * directions_.size(), ReachSteps::k_inexact);   // a ray may meet several
    else
        note_reach(receivers, count, scratch, reach);
}

// Chooses the lit surfaces whose light a dynamic object may occlude, on its way to them or on to their receiver.
void NearLight::doubt(const MovingSpheres& spheres, Scratch& scratch)
{
    scratch.doubted.clear();
    scratch.to_lights.clear();
    scratch.to_points.clear();
    for (std::uint32_t s = 0; s < scratch.lit.size(); ++s) {
        const std::size_t i = scratch.lit[s].ray;
        const glm::vec3 point = scratch.rays.origin(i), short_way = scratch.rays.direction(i);
        const glm::vec3 surface = scratch.shadow_rays.origin(s), way = scratch.shadow_rays.direction(s);
        const float distance = scratch.hits.t[i], far = scratch.shadow_rays.tfar[s];
        const auto may_occlude = [&](const auto& around) {
            return meets_way(around, surface, way, far) || meets_way(around, point, short_way, distance);
        };
        if (!spheres.any(may_occlude, [&](const Sphere&, const MovingBox& box) { return may_occlude(box); })) continue;
        scratch.doubted.push_back(s);
        scratch.to_lights.push(surface, 0, way, far);
        scratch.to_points.push(point, 0, short_way, distance);
    }
}

void NearLight::find_change(const scene::SceneState& state, const ray::RayScene& rays, const MovingSpheres& spheres,
                            const NearReceiver* receivers, std::size_t count, Scratch& scratch,
                            NearAnswer* answers) const
{
    if (rays.thins_light()) {   // dynamic objects may let a part of it through
        scratch.without.resize(count);
        gather(state, rays, receivers, count, ray::Against::static_only, scratch, scratch.without.data());
        gather(state, rays, receivers, count, ray::Against::everything, scratch, answers);
        for (std::size_t k = 0; k < count; ++k)
            for (int colour = 0; colour < 3; ++colour) answers[k].light[colour] -= scratch.without[k].light[colour];
        return;
    }
    if (std::all_of(receivers, receivers + count, [](const NearReceiver& r) { return !r.reach.empty(); }))
        queue_doubted(state, spheres, receivers, count, scratch);
    else
        queue_all(receivers, count, scratch);
    find_lit(state, rays, receivers, count, ray::Against::static_only, scratch, answers);
    doubt(spheres, scratch);
    const auto occluded = [&](ray::RayQueue& queue, ray::Against against, std::vector<std::uint8_t>& answer) {
        queue.purpose = ray::RayClass::indirect;
        answer.resize(queue.size() + ray::k_packet_pad);
        rays.occluded(queue, 0, queue.size(), answer.data(), against);
        scratch.cast += queue.size();
    };
    // Find which lit surfaces dynamic objects leave without light, and which of them static geometry leaves lit.
    std::vector<std::uint8_t>&hidden = scratch.occluded, &now = scratch.occluded_on;
    occluded(scratch.to_lights, ray::Against::dynamic_only, now);
    occluded(scratch.to_points, ray::Against::dynamic_only, hidden);
    std::size_t kept = 0;
    for (std::size_t d = 0; d < scratch.doubted.size(); ++d)
        if (now[d] || hidden[d]) scratch.doubted[kept++] = scratch.doubted[d];
    scratch.doubted.resize(kept);
    scratch.to_lights.clear();
    for (const std::uint32_t s : scratch.doubted)
        scratch.to_lights.push(scratch.shadow_rays.origin(s), 0, scratch.shadow_rays.direction(s),
                               scratch.shadow_rays.tfar[s]);
    occluded(scratch.to_lights, ray::Against::static_only, hidden);
    for (std::size_t d = 0; d < kept; ++d) {
        if (hidden[d]) continue;
        const Scratch::Lit& lit = scratch.lit[scratch.doubted[d]];
        for (int colour = 0; colour < 3; ++colour)
            answers[lit.receiver].light[colour] -= lit.light[colour] * lit.direction;
    }
}

}   // namespace gnomon::irradiance_cache
