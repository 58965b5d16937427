// SPDX-License-Identifier: Apache-2.0
#include "patches/patch_links.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/interruption.h"
#include "patches/patch_rays.h"

namespace gnomon::patches {

namespace {

constexpr std::size_t k_patches_at_once = 64;          // in a task that casts rays
constexpr std::size_t k_patches_to_block = 256;        // in a task that casts some again
constexpr std::size_t k_patches_to_gather = 1024;      // in a task that sums
constexpr double k_golden_angle = 2.399963229728653;   // radians
// Ray r starts at place number k_order * r: neighbouring directions start far apart.
constexpr std::size_t k_order = 13;

// Unit vectors around +z: a Fibonacci lattice on the unit disk, projected up.
std::array<glm::dvec3, PatchLinks::k_rays> fibonacci_lattice()
{
    std::array<glm::dvec3, PatchLinks::k_rays> lattice;
    for (std::size_t r = 0; r < PatchLinks::k_rays; ++r) {
        const double square = (static_cast<double>(r) + 0.5) / static_cast<double>(PatchLinks::k_rays);
        const double radius = std::sqrt(square), phi = static_cast<double>(r) * k_golden_angle;
        lattice[r] = {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1 - square)};
    }
    return lattice;
}

struct PatchRay {
    glm::vec3 origin{0}, direction{0}, normal{0};   // the normal of its place
};

// A patch's rays: k_rays, and those to spots that its places face.
struct RaysOfPatch {
    PatchRay ray[PatchLinks::k_all_rays];
    bool exists[PatchLinks::k_all_rays] = {};
};

// The spot that a ray goes to. @pre there are spots
const Surroundings::Spot& spot_of(const Surroundings& surroundings, std::size_t r)
{
    return surroundings.spots()[(r - PatchLinks::k_rays) % surroundings.spots().size()];
}

const std::array<glm::dvec3, PatchLinks::k_rays>& lattice()
{
    static const std::array<glm::dvec3, PatchLinks::k_rays> directions = fibonacci_lattice();
    return directions;
}

// Whether make_basis() is the same for both normals: it tells zeros apart by their sign.
bool same_basis(const glm::vec3& a, const glm::vec3& b)
{
    return a == b && std::signbit(a.z) == std::signbit(b.z);
}

// The cosine and the sine by which the lattice of a patch is turned against that of its neighbours.
glm::dvec2 turn_of(PatchId p)
{
    const double turn = std::fmod(static_cast<double>(p) * k_golden_angle, 2 * k_pi);
    return {std::cos(turn), std::sin(turn)};
}

// By bit: some of the first k_rays of a patch.
using SomeRays = std::uint32_t;
constexpr SomeRays k_every_ray = 0xffffffff;
static_assert(PatchLinks::k_rays == 32);

// Finds rays of a patch, from places at equal steps of area: some, and all those to spots.
void find_rays(const SurfacePatches& patches, PatchId p, const glm::dvec2& turn, const Surroundings& surroundings,
               SomeRays some, RaysOfPatch& out)
{
    const std::span<const PatchPlace> places = patches.places(patches.patches()[p]);
    double all = 0;
    for (const PatchPlace& place : places) all += static_cast<double>(place.area);
    std::size_t at[PatchLinks::k_rays];
    double sum = static_cast<double>(places[0].area);
    std::fill(std::begin(at), std::end(at), 0);
    for (std::size_t k = 0, place = 0; k < PatchLinks::k_rays && places.size() > 1; ++k) {
        const double wanted = all * (static_cast<double>(k) + 0.5) / static_cast<double>(PatchLinks::k_rays);
        while (sum < wanted && place + 1 < places.size()) sum += static_cast<double>(places[++place].area);
        at[k] = place;
    }
    const double cosine = turn.x, sine = turn.y;
    glm::vec3 normal(0), x(0), y(0);
    for (std::size_t r = 0; r < PatchLinks::k_rays; ++r) {
        out.exists[r] = (some >> r & 1) != 0;
        if (!out.exists[r]) continue;
        const PatchPlace& place = places[at[k_order * r % PatchLinks::k_rays]];
        if (!same_basis(place.normal, normal)) normal = place.normal, make_basis(normal, x, y);
        const glm::dvec3& l = lattice()[r];
        const glm::vec3 d(cosine * l.x - sine * l.y, sine * l.x + cosine * l.y, l.z);
        out.ray[r] = {place.position, d.x * x + d.y * y + d.z * place.normal, place.normal};
    }
    for (std::size_t r = PatchLinks::k_rays; r < PatchLinks::k_all_rays; ++r) {
        out.exists[r] = false;
        if (surroundings.spots().empty()) continue;
        const std::size_t step = PatchLinks::k_rays / PatchLinks::k_to_spots, of_spot = r - PatchLinks::k_rays;
        const PatchPlace& place = places[at[(step * of_spot + step / 2 + p) % PatchLinks::k_rays]];
        const glm::vec3& direction = spot_of(surroundings, r).direction;
        out.ray[r] = {place.position, direction, place.normal};
        out.exists[r] = glm::dot(direction, place.normal) > 0;
    }
}

// PatchLinks::reach
float reach_of(const SurfacePatches& patches, const Patch& patch)
{
    float reach = 0;
    const std::span<const PatchPlace> places = patches.places(patch);
    for (const PatchPlace& place : places) {
        if (!same_basis(place.normal, places[0].normal)) return k_infinity;
        reach = std::max(reach, glm::length(place.position - patch.position));
    }
    return reach;
}

// The rays that may cross a sphere, and perhaps others: of a flat patch, those that do so from its middle if the sphere
// is wider by what lies between. @pre reach is finite
SomeRays rays_across(const SurfacePatches& patches, PatchId p, float reach, const BoundingSphere& sphere,
                     const glm::dvec2& turn)
{
    struct Lattice {
        float x[PatchLinks::k_rays], y[PatchLinks::k_rays], z[PatchLinks::k_rays];
        SomeRays bit[PatchLinks::k_rays];
        Lattice()
        {
            for (std::size_t r = 0; r < PatchLinks::k_rays; ++r) {
                const glm::vec3 l(lattice()[r]);
                x[r] = l.x, y[r] = l.y, z[r] = l.z, bit[r] = 1u << r;
            }
        }
    };
    static const Lattice directions;
    constexpr float k_rounding = 1e-4f;
    const Patch& patch = patches.patches()[p];
    const glm::vec3 normal = patches.places(patch)[0].normal, to = sphere.centre - patch.position;
    glm::vec3 x, y;
    make_basis(normal, x, y);
    const glm::vec2 flat(glm::dot(to, x), glm::dot(to, y)), cosine_sine(turn);
    const float across = glm::dot(cosine_sine, flat), along = cosine_sine.x * flat.y - cosine_sine.y * flat.x,
                up = glm::dot(to, normal);
    const float square = glm::dot(to, to), radius = sphere.radius + reach,
                least = square - radius * radius - k_rounding * (square + radius * radius);
    if (!(least > 0)) return k_every_ray;
    SomeRays some = 0;
    for (std::size_t r = 0; r < PatchLinks::k_rays; ++r) {
        const float ahead = directions.x[r] * across + directions.y[r] * along + directions.z[r] * up;
        some |= ahead * std::abs(ahead) >= least ? directions.bit[r] : 0u;
    }
    return some;
}

// The part of the irradiance that one ray brings, of a radiance.
constexpr auto k_ray_weight = static_cast<float>(k_pi / static_cast<double>(PatchLinks::k_rays));

// The irradiance that a ray brings if it leaves the scene.
// @param missed  PatchLinks::missed
glm::vec3 from_beyond(const Surroundings& surroundings, const glm::vec3& missed, const PatchRay& ray, std::size_t r)
{
    if (r < PatchLinks::k_rays) return k_ray_weight * surroundings.radiance_beside_spots(ray.direction) + missed;
    const std::size_t spots = surroundings.spots().size(), number = (r - PatchLinks::k_rays) % spots;
    const std::size_t rays = (PatchLinks::k_to_spots - number + spots - 1) / spots;   // to this spot
    return glm::dot(ray.direction, ray.normal) / static_cast<float>(rays) * surroundings.spots()[number].irradiance;
}

// PatchLinks::missed
glm::vec3 missed_by(const RaysOfPatch& rays, const Surroundings& surroundings)
{
    if (!surroundings.any()) return glm::vec3(0);
    glm::vec3 all(0), found(0);
    for (std::size_t r = 0; r < PatchLinks::k_rays; ++r) {
        all += surroundings.irradiance_beside_spots(rays.ray[r].normal);
        found += static_cast<float>(k_pi) * surroundings.radiance_beside_spots(rays.ray[r].direction);
    }
    constexpr auto k_count = static_cast<float>(PatchLinks::k_rays);
    return (all - found) / (k_count * k_count);
}

class Caster {
 public:
    Caster(const SurfacePatches& patches, const scene::SceneState& state, const ray::RayScene& rays)
        : patches_(patches), scene_(state.scene()), scene_rays_(rays)
    {
    }

    void cast(PatchId first, PatchId last, const Surroundings& surroundings, PatchLinks& links)
    {
        rays_.clear();
        of_patch_.resize(last - first);
        for (PatchId p = first; p < last; ++p) {
            RaysOfPatch& of = of_patch_[p - first];
            links.turn[p] = turn_of(p);
            find_rays(patches_, p, links.turn[p], surroundings, k_every_ray, of);
            links.reach[p] = reach_of(patches_, patches_.patches()[p]);
            links.missed[p] = missed_by(of, surroundings);
            for (std::size_t k = 0; k < PatchLinks::k_all_rays; ++k)
                if (of.exists[k]) rays_.push(of.ray[k].origin, of.ray[k].direction);
        }
        rays_.trace(scene_, scene_rays_);
        passes_.resize(links.passes.empty() ? 0 : rays_.size());
        if (!passes_.empty()) rays_.find_passing(scene_rays_, passes_.data());
        std::size_t r = 0;
        for (PatchId p = first; p < last; ++p) {
            const RaysOfPatch& of = of_patch_[p - first];
            std::size_t meet = 0, known = 0;   // surfaces, and patches
            for (std::size_t k = 0; k < PatchLinks::k_all_rays; ++k) {
                if (!of.exists[k]) continue;
                const std::size_t ray = r++, number = PatchLinks::k_all_rays * p + k;
                if (!passes_.empty()) links.passes[number] = passes_[ray];
                if (rays_.leaves(ray)) {
                    links.leaves[number] = 1;
                    if (!surroundings.any()) continue;
                    const glm::vec3 light = from_beyond(surroundings, links.missed[p], of.ray[k], k);
                    links.surroundings[p] += passes_.empty() ? light : light * passes_[ray];
                    continue;
                }
                if (k >= PatchLinks::k_rays) continue;
                const PatchId met = rays_.patch(patches_, scene_rays_, ray);
                ++meet;
                if (met == k_no_patch) continue;
                ++known;
                links.target[PatchLinks::k_rays * p + k] = static_cast<std::uint16_t>(met);
            }
            constexpr auto k_all = static_cast<float>(PatchLinks::k_rays);
            if (known > 0) links.weight[p] = static_cast<float>(meet) / (static_cast<float>(known) * k_all);
            links.surroundings[p] = glm::max(links.surroundings[p], glm::vec3(0));
        }
    }

 private:
    const SurfacePatches& patches_;
    const scene::Scene& scene_;
    const ray::RayScene& scene_rays_;
    PatchRays rays_;
    std::vector<RaysOfPatch> of_patch_;
    std::vector<glm::vec3> passes_;   // by ray, where anything thins light
};

}   // namespace

PatchLinks link_patches(const SurfacePatches& patches, const scene::SceneState& state, const ray::RayScene& rays,
                        const Surroundings& surroundings, Tasks& tasks)
{
    PatchLinks links;
    const std::size_t count = patches.patches().size();
    links.target.assign(PatchLinks::k_rays * count, PatchLinks::k_none);
    links.leaves.assign(PatchLinks::k_all_rays * count, 0);
    links.weight.assign(count, 0.0f);
    links.reach.assign(count, k_infinity);
    links.turn.assign(count, glm::dvec2(0));
    links.missed.assign(count, glm::vec3(0));
    links.surroundings.assign(count, glm::vec3(0));
    if (rays.thins_light()) links.passes.assign(PatchLinks::k_all_rays * count, glm::vec3(1));
    tasks.for_each((count + k_patches_at_once - 1) / k_patches_at_once, [&](std::size_t run, int) {
        interruption_point();
        const std::size_t first = run * k_patches_at_once, last = std::min(first + k_patches_at_once, count);
        Caster(patches, state, rays).cast(static_cast<PatchId>(first), static_cast<PatchId>(last), surroundings, links);
    });
    return links;
}

BlockedLinks blocked_links(const SurfacePatches& patches, const PatchLinks& links, const scene::SceneState& state,
                           const ray::RayScene& rays, const Surroundings& surroundings,
                           std::span<const BoundingSphere> spheres, std::span<const glm::vec3> exitance, Tasks& tasks)
{
    // A sphere that is seen under a smaller ratio of radius to distance hides at most 1 % of what a patch sees.
    constexpr float k_least_ratio = 0.1f;
    const std::size_t count = patches.patches().size();
    BlockedLinks blocked{std::vector<glm::vec3>(count, glm::vec3(0)), {}};
    if (spheres.empty() || (exitance.empty() && !surroundings.any())) return blocked;
    std::vector<std::vector<BlockedLink>> links_of((count + k_patches_to_block - 1) / k_patches_to_block);   // by run
    tasks.for_each((count + k_patches_to_block - 1) / k_patches_to_block, [&](std::size_t run, int) {
        interruption_point();
        PatchRays cast;
        std::vector<std::size_t> of;     // by ray: its number among all
        std::vector<glm::vec3> brings;   // by ray: from beyond
        RaysOfPatch found;
        std::vector<const BoundingSphere*> near;
        const std::size_t last = std::min((run + 1) * k_patches_to_block, count);
        for (std::size_t p = run * k_patches_to_block; p < last; ++p) {
            const Patch& patch = patches.patches()[p];
            near.clear();
            for (const BoundingSphere& sphere : spheres) {
                const glm::vec3 to = sphere.centre - patch.position;
                const float within = sphere.radius + patch.radius;
                if (glm::dot(to, patch.normal) <= -within ||
                    sphere.radius < k_least_ratio * (glm::length(to) - patch.radius))
                    continue;
                near.push_back(&sphere);
            }
            if (near.empty()) continue;
            const auto id = static_cast<PatchId>(p);
            SomeRays some = 0;
            if (std::isfinite(links.reach[p])) {
                for (const BoundingSphere* sphere : near)
                    some |= rays_across(patches, id, links.reach[p], *sphere, links.turn[p]);
            } else {
                some = k_every_ray;
            }
            if (some == 0 && surroundings.spots().empty()) continue;
            find_rays(patches, id, links.turn[p], surroundings, some, found);
            for (std::size_t r = 0; r < PatchLinks::k_all_rays; ++r) {
                if (!found.exists[r]) continue;
                const PatchRay& ray = found.ray[r];
                const auto crosses = [&](const BoundingSphere* sphere) {
                    const glm::vec3 to = sphere->centre - ray.origin;
                    const float along = glm::dot(to, ray.direction), square = glm::dot(to, to),
                                radius2 = sphere->radius * sphere->radius;
                    return square <= radius2 || (along > 0 && square - along * along <= radius2);
                };
                if (std::ranges::none_of(near, crosses)) continue;
                const std::size_t number = PatchLinks::k_all_rays * p + r;
                const bool beyond = surroundings.any() && links.leaves[number] != 0;
                cast.push(ray.origin, ray.direction);
                of.push_back(number);
                brings.push_back(beyond ? from_beyond(surroundings, links.missed[p], ray, r) : glm::vec3(0));
            }
        }
        // Few rays meet a dynamic object at all. Only these can end on one.
        if (!rays.thins_light()) {
            cast.trace(state.scene(), rays, ray::Against::dynamic_only);
            std::size_t kept = 0;
            for (std::size_t k = 0; k < of.size(); ++k)
                if (!cast.leaves(k)) of[kept] = of[k], brings[kept] = brings[k], ++kept;
            of.resize(kept);
            cast.keep_ended();
        }
        cast.trace(state.scene(), rays, ray::Against::everything);
        std::vector<glm::vec3> passes(rays.thins_light() ? cast.size() : 0);
        if (!passes.empty()) cast.find_passing(rays, passes.data(), ray::Against::dynamic_only);
        for (std::size_t k = 0; k < of.size(); ++k) {
            const bool ends = !cast.leaves(k) && state.is_dynamic(cast.object(k));
            if (!ends && (passes.empty() || passes[k] == glm::vec3(1))) continue;
            const std::size_t p = of[k] / PatchLinks::k_all_rays, r = of[k] % PatchLinks::k_all_rays;
            glm::vec3 part(1);
            if (!links.passes.empty()) part = links.passes[of[k]];
            if (!ends) part *= 1.0f - passes[k];
            glm::vec3 light = brings[k];
            if (r < PatchLinks::k_rays && !exitance.empty())
                if (const std::uint16_t target = links.target[PatchLinks::k_rays * p + r];
                    target != PatchLinks::k_none) {
                    light = links.weight[p] * exitance[target];
                    links_of[run].push_back({static_cast<PatchId>(p), target, links.weight[p] * part});
                }
            blocked.irradiance[p] += light * part;
        }
    });
    for (const std::vector<BlockedLink>& some : links_of)
        blocked.links.insert(blocked.links.end(), some.begin(), some.end());
    return blocked;
}

void gather_links(const PatchLinks& links, std::span<const glm::vec3> exitance, std::span<glm::vec3> irradiance,
                  Tasks& tasks)
{
    const std::size_t count = exitance.size();
    // Four numbers each, so that the three sums are one of vectors; none is the last, which is black.
    std::vector<glm::vec4> light(count + 1, glm::vec4(0));
    std::ranges::transform(exitance, light.begin(), [](const glm::vec3& of) { return glm::vec4(of, 0); });
    tasks.for_each((count + k_patches_to_gather - 1) / k_patches_to_gather, [&](std::size_t run, int) {
        const std::size_t last = std::min((run + 1) * k_patches_to_gather, count);
        for (std::size_t p = run * k_patches_to_gather; p < last; ++p) {
            glm::vec4 sum(0);
            const std::uint16_t* target = links.target.data() + PatchLinks::k_rays * p;
            const glm::vec3* passes = links.passes.empty() ? nullptr : links.passes.data() + PatchLinks::k_all_rays * p;
            for (std::size_t k = 0; k < PatchLinks::k_rays; ++k) {
                const glm::vec4& from = light[std::min<std::size_t>(target[k], count)];
                sum += passes ? glm::vec4(passes[k], 0) * from : from;
            }
            irradiance[p] = links.weight[p] * glm::vec3(sum);
        }
    });
}

}   // namespace gnomon::patches
