// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/near_field/near_light.h"

#include <algorithm>
#include <cmath>

#include "lighting/diffuse.h"
#include "ray/origin.h"

namespace gnomon::irradiance_cache {

namespace {

// The sum is irradiance for the point's own normal. For other normals it must stay bounded at grazing angles.
constexpr float k_least_cosine = 0.1f;

}   // namespace

std::vector<glm::vec3> cosine_directions(int count)
{
    constexpr double k_golden_angle = 2.399963229728653;
    std::vector<glm::vec3> directions;
    for (int i = 0; i < count; ++i) {
        const double r = std::sqrt((i + 0.5) / count), phi = i * k_golden_angle;
        directions.emplace_back(r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - r * r));
    }
    return directions;
}

NearLight::NearLight(const NearOptions& options) : options_(options), directions_(cosine_directions(options.rays)) {}

void NearLight::gather(const scene::SceneState& state, const ray::RayScene& rays, const NearReceiver* receivers,
                       std::size_t count, ray::Against against, Scratch& scratch, NearAnswer* answers) const
{
    const scene::Scene& scene = state.scene();
    const std::size_t n = directions_.size();
    // Cast the short rays.
    ray::RayQueue& queue = scratch.rays;
    queue.clear();
    queue.purpose = scratch.shadow_rays.purpose = ray::RayClass::indirect;
    for (std::size_t k = 0; k < count; ++k) {
        glm::vec3 t, b;
        make_basis(receivers[k].normal, t, b);
        for (const glm::vec3& d : directions_)
            queue.push(receivers[k].origin, 0, d.x * t + d.y * b + d.z * receivers[k].normal, options_.radius);
    }
    scratch.hits.resize(queue.size());
    rays.closest(queue, 0, queue.size(), scratch.hits, ray::Sides::both, against);
    scratch.cast += queue.size();

    // Light the surfaces that they meet, and queue a ray to each light.
    scratch.shadow_rays.clear();
    scratch.lit.clear();
    const auto weight = static_cast<float>(k_pi) / static_cast<float>(n);
    for (std::size_t k = 0; k < count; ++k) {
        answers[k] = {};
        for (std::size_t i = k * n; i < k * n + n; ++i) {
            const scene::ObjectId object = scratch.hits.object[i];
            if (object == scene::none) continue;
            answers[k].nearest = std::min(answers[k].nearest, scratch.hits.t[i]);
            const glm::vec3 direction = queue.direction(i);
            if (!(glm::dot(direction, receivers[k].horizon) > 0)) continue;
            const float near = 1 - far_fraction(scratch.hits.t[i], options_.radius);
            if (state.is_dynamic(object)) continue;
            const ray::ObjectGeometry& geometry = rays.geometry(object);
            const std::uint32_t triangle = scratch.hits.triangle[i];
            glm::vec3 p[3];
            geometry.corners(triangle, p);
            const float u = scratch.hits.u[i], v = scratch.hits.v[i];
            glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
            const float length = glm::length(normal);
            if (!(length > 0)) continue;
            normal /= length;
            if (glm::dot(normal, direction) > 0) normal = -normal;
            const glm::vec3 position = std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2];
            const glm::vec3 from = position + ray::origin_lift(p) * normal;
            glm::vec3 exitance(-1);
            for (scene::LightId l = 0; l < scene.lights.size(); ++l) {
                const scene::Light& light = scene.lights[l];
                const scene::LightState& at = state.light(l);
                if (!at.visible || light.of_environment || (light.of_surface && !options_.surface_lights)) continue;
                const scene::LightSample sample = scene::illuminate(light, at, position);
                const float cosine = glm::dot(normal, sample.to_light);
                if (!(cosine > 0) || sample.irradiance == glm::vec3(0)) continue;
                if (exitance.x < 0) exitance = lighting::exitance_per_irradiance(scene, geometry, triangle, u, v);
                if (exitance == glm::vec3(0)) break;
                if (light.type == scene::LightType::directional)
                    scratch.shadow_rays.push(from, 0, -at.direction, k_infinity);
                else
                    scratch.shadow_rays.push(from, 0, at.position - from, ray::k_shadow_ray_end);
                const glm::vec3 radiance = exitance * sample.irradiance * (cosine / static_cast<float>(k_pi));
                const float at_point = std::max(glm::dot(direction, receivers[k].normal), k_least_cosine);
                scratch.lit.push_back({k, radiance * (near * weight), direction / at_point});
            }
        }
    }
    // Add the light that arrives.
    const std::size_t shadow_rays = scratch.shadow_rays.size();
    scratch.cast += shadow_rays;
    scratch.occluded.resize(shadow_rays + ray::k_packet_pad);
    rays.occluded(scratch.shadow_rays, 0, shadow_rays, scratch.occluded.data(), against);
    for (std::size_t s = 0; s < shadow_rays; ++s) {
        if (scratch.occluded[s]) continue;
        const Scratch::Lit& lit = scratch.lit[s];
        for (int colour = 0; colour < 3; ++colour)
            answers[lit.receiver].light[colour] += lit.light[colour] * lit.direction;
    }
}

}   // namespace gnomon::irradiance_cache
