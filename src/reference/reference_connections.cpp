// SPDX-License-Identifier: Apache-2.0
// The second way to light over one bounce: places that rays from lights meet, connected with paths by shadow rays.
//
// Let x be a surface of a path, y the next one and z a light. A path samples y from x, and then z from y.
// A ray from the light samples y from z. Both sample the same product, so that its weight is 1 over the sum of both
// densities [Veach and Guibas 1995]. All densities are functions of x, y and z alone.
#include "ray/origin.h"
#include "reference/reference.h"

namespace gnomon::reference {

namespace {

constexpr int k_connected = 3;   // bounces of a path from which it is connected: later ones bring less light
constexpr auto k_float_pi = static_cast<float>(k_pi);

// Decisions of a path's ray from a light.
enum Decision : std::uint32_t { source = 1u << 29, direction };

}   // namespace

// Whether paths are connected from their surfaces after so many bounces.
bool ReferencePaths::connects(int bounce) const
{
    return light_.emission_ && bounce < k_connected && bounce < light_.options_.bounces;
}

// Traces one ray from a light for each path.
void ReferencePaths::find_lit_places()
{
    lit_.clear();
    if (!light_.emission_) return;
    lit_.resize(paths_.size());
    rays_.clear(), ray_path_.clear();
    for (std::uint32_t i = 0; i < paths_.size(); ++i) {
        if (paths_[i].glossy) continue;
        const PathNumbers& numbers = paths_[i].numbers;
        EmittedRay& ray = lit_[i].ray;
        ray = light_.emission_->sample(numbers.one(source), numbers.pair(direction));
        rays_.push(ray.origin, light_.emission_->nearest(), ray.direction, k_infinity);
        ray_path_.push_back(i);
    }
    const std::size_t count = rays_.size();
    if (count == 0) return;
    counters_.rays += count;
    hits_.resize(count);
    light_.rays_.closest(rays_, 0, count, hits_, ray::Sides::both);
    for (std::size_t r = 0; r < count; ++r) {
        if (hits_.object[r] == scene::none) continue;
        LitPlace& place = lit_[ray_path_[r]];
        glm::vec3 p[3];
        light_.rays_.geometry(hits_.object[r]).corners(hits_.triangle[r], p);
        const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float length = glm::length(cross), u = hits_.u[r], v = hits_.v[r];
        if (!(length > 0)) continue;
        const float facing = -glm::dot(cross, rays_.direction(r)) / length;
        place.object = hits_.object[r], place.triangle = hits_.triangle[r], place.u = u, place.v = v;
        place.geometric_normal = (facing < 0 ? -1 : 1) / length * cross;
        place.position = (1 - u - v) * p[0] + u * p[1] + v * p[2] + ray::origin_lift(p) * place.geometric_normal;
        place.density = std::abs(facing) / (hits_.t[r] * hits_.t[r]);
    }
}

// What density of rays from a light, per unit of area of the path's surface, there is for one unit of the density with
// which the path has chosen its surface.
// @param to_light  unit
// @param density   of the light's rays, per unit of area that faces the light
float ReferencePaths::from_light(const Path& path, const glm::vec3& to_light, float density)
{
    return std::max(glm::dot(path.geometric_normal, to_light), 0.0f) * path.inverse_density * density;
}

// Connects each path with the place that its light ray met.
void ReferencePaths::connect(int bounce)
{
    if (!connects(bounce)) return;
    shadow_rays_.clear(), shadow_path_.clear(), shadow_gain_.clear();
    for (const std::uint32_t i : standing_) {
        const LitPlace& place = lit_[i];
        if (place.object == scene::none) continue;
        const Path& path = paths_[i];
        const glm::vec3& origin = path.origin_to(place.position - path.position);
        const glm::vec3 to = place.position - origin;
        const float square = glm::dot(to, to);
        if (!(square > 0)) continue;
        const glm::vec3 way = to / std::sqrt(square);
        const float facing = -glm::dot(way, place.geometric_normal);
        const float own = own_density(path, way) * facing / square;   // per unit of area there
        if (!(facing > 0) || !(own > 0) || !path.is_above(way)) continue;
        shading::SurfacePoint s;
        shading::surface_at(light_.state_.scene(), light_.rays_.geometry(place.object), place.triangle, place.u,
                            place.v, 0, way, {}, s);
        float both = 0;
        const glm::vec3 light = arriving(place, s, own, both);
        const glm::vec3 gain = path.weight * s.diffuse * light;
        if (gain == glm::vec3(0) || !(both > 0)) continue;
        // pi times `own` is the geometry factor of light that is reflected diffusely.
        shadow_rays_.push(origin, 0, to, ray::k_shadow_ray_end);
        shadow_path_.push_back(i);
        shadow_gain_.push_back(gain * (own / both));
    }
    trace_shadows(false);
}

// Returns the irradiance that a light ray brings to its place, for a density of 1.
// @param s     the place as it is seen from the path
// @param own   density per unit of area with which the path would choose it
// @param both  out: the sum of both ways' densities, in the same unit as the irradiance
glm::vec3 ReferencePaths::arriving(const LitPlace& place, const shading::SurfacePoint& s, float own, float& both)
{
    const glm::vec3 to_light = -place.ray.direction;
    const float cosine = glm::dot(s.normal, to_light);
    if (!(cosine > 0) || !(glm::dot(s.smooth_normal, to_light) > 0)) return glm::vec3(0);
    const LightChoice::Chosen chosen =
        light_.choice_->chosen(place.ray.light, s.position, s.normal, s.smooth_normal, choice_);
    if (!(chosen.chance > 0)) return glm::vec3(0);
    both = light_.emission_->density(chosen.light, place.ray.direction) * place.density + own * chosen.chance;
    const bool lacks_pi = s.model == scene::ShadingModel::whitted;
    return chosen.sample.irradiance * (cosine * (lacks_pi ? k_float_pi : 1.0f));
}

}   // namespace gnomon::reference
