// SPDX-License-Identifier: Apache-2.0
#include "patches/patch_links.h"

#include <algorithm>
#include <cmath>

#include "base/interruption.h"
#include "ray/origin.h"

namespace gnomon::patches {

namespace {

constexpr std::size_t k_patches_at_once = 64;       // in a task that casts rays
constexpr std::size_t k_patches_to_gather = 1024;   // in a task that sums
constexpr int k_most_passes = 8;                    // through surfaces that do not block light
constexpr float k_least_cosine = 1e-3f;
constexpr double k_golden_angle = 2.399963229728653;   // radians
// Ray r starts at place number k_order * r: neighbouring directions start far apart.
constexpr std::size_t k_order = 13;

// A unit vector around +z: ray r of a Fibonacci lattice on the unit disk, turned and projected up.
glm::dvec3 direction_of(std::size_t r, double turn)
{
    const double square = (static_cast<double>(r) + 0.5) / static_cast<double>(PatchLinks::k_rays);
    const double radius = std::sqrt(square), phi = static_cast<double>(r) * k_golden_angle + turn;
    return {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(1 - square)};
}

class Caster {
 public:
    Caster(const SurfacePatches& patches, const scene::SceneState& state, const ray::RayScene& rays)
        : patches_(patches), scene_(state.scene()), scene_rays_(rays)
    {
        rays_.purpose = passing_.purpose = ray::RayClass::indirect;
    }

    void cast(PatchId first, PatchId last, const Surroundings& surroundings, PatchLinks& links)
    {
        rays_.clear();
        for (PatchId p = first; p < last; ++p) push(p);
        hits_.resize(rays_.size());
        scene_rays_.closest(rays_, 0, rays_.size(), hits_, ray::Sides::both, ray::Against::static_only);
        pass_transparent();
        const auto weight = static_cast<float>(k_pi / static_cast<double>(PatchLinks::k_rays));
        std::size_t r = 0;
        for (PatchId p = first; p < last; ++p)
            for (std::size_t k = 0; k < PatchLinks::k_rays; ++k, ++r) {
                if (hits_.object[r] == scene::none) {
                    if (surroundings.any()) links.surroundings[p] += weight * surroundings.radiance(rays_.direction(r));
                    continue;
                }
                const Surface at = surface(r);
                const bool front = glm::dot(at.normal, rays_.direction(r)) < 0;
                const PatchId met =
                    patches_.patch_at(scene_rays_, hits_.object[r], hits_.triangle[r], hits_.u[r], hits_.v[r], front,
                                      at.position + (front ? at.lift : -at.lift) * at.normal);
                if (met != k_no_patch) links.target[PatchLinks::k_rays * p + k] = static_cast<std::uint16_t>(met);
            }
    }

 private:
    struct Surface {
        glm::vec3 position, normal;   // the normal of the front
        float lift;
    };
    Surface surface(std::size_t r) const
    {
        glm::vec3 p[3];
        scene_rays_.geometry(hits_.object[r]).corners(hits_.triangle[r], p);
        const float u = hits_.u[r], v = hits_.v[r];
        return {std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2],
                glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0])), ray::origin_lift(p)};
    }
    bool blocks(std::size_t r) const
    {
        if (hits_.object[r] == scene::none) return true;
        const scene::Mesh& mesh = *scene_rays_.geometry(hits_.object[r]).mesh;
        return scene_.materials[mesh.part_of(hits_.triangle[r]).material].surface_class() !=
               scene::SurfaceClass::transparent;
    }

    // Queues the rays of a patch, from places at equal steps of area.
    void push(PatchId p)
    {
        const std::span<const PatchPlace> places = patches_.places(patches_.patches()[p]);
        double all = 0;
        for (const PatchPlace& place : places) all += static_cast<double>(place.area);
        std::size_t at[PatchLinks::k_rays];
        double sum = static_cast<double>(places[0].area);
        for (std::size_t k = 0, place = 0; k < PatchLinks::k_rays; ++k) {
            const double wanted = all * (static_cast<double>(k) + 0.5) / static_cast<double>(PatchLinks::k_rays);
            while (sum < wanted && place + 1 < places.size()) sum += static_cast<double>(places[++place].area);
            at[k] = place;
        }
        const double turn = std::fmod(static_cast<double>(p) * k_golden_angle, 2 * k_pi);
        for (std::size_t r = 0; r < PatchLinks::k_rays; ++r) {
            const PatchPlace& place = places[at[k_order * r % PatchLinks::k_rays]];
            glm::vec3 x, y;
            make_basis(place.normal, x, y);
            const glm::vec3 d(direction_of(r, turn));
            rays_.push(place.position, 0, d.x * x + d.y * y + d.z * place.normal, k_infinity);
        }
    }

    // Continues rays that met a surface that does not block light, behind it.
    void pass_transparent()
    {
        for (int pass = 0; pass < k_most_passes; ++pass) {
            passing_.clear(), passing_ray_.clear();
            for (std::uint32_t r = 0; r < rays_.size(); ++r) {
                if (blocks(r)) continue;
                const Surface at = surface(r);
                const float cosine = std::abs(glm::dot(at.normal, rays_.direction(r)));
                passing_.push(rays_.origin(r), hits_.t[r] + at.lift / std::max(cosine, k_least_cosine),
                              rays_.direction(r), k_infinity);
                passing_ray_.push_back(r);
            }
            if (passing_.empty()) return;
            next_.resize(passing_.size());
            scene_rays_.closest(passing_, 0, passing_.size(), next_, ray::Sides::both, ray::Against::static_only);
            for (std::size_t i = 0; i < passing_ray_.size(); ++i) {
                const std::uint32_t r = passing_ray_[i];
                hits_.t[r] = next_.t[i], hits_.u[r] = next_.u[i], hits_.v[r] = next_.v[i];
                hits_.object[r] = next_.object[i], hits_.triangle[r] = next_.triangle[i];
            }
        }
    }

    const SurfacePatches& patches_;
    const scene::Scene& scene_;
    const ray::RayScene& scene_rays_;
    ray::RayQueue rays_, passing_;
    ray::Hits hits_, next_;
    std::vector<std::uint32_t> passing_ray_;
};

}   // namespace

PatchLinks link_patches(const SurfacePatches& patches, const scene::SceneState& state, const ray::RayScene& rays,
                        const Surroundings& surroundings, Tasks& tasks)
{
    PatchLinks links;
    const std::size_t count = patches.patches().size();
    links.target.assign(PatchLinks::k_rays * count, PatchLinks::k_none);
    links.surroundings.assign(count, glm::vec3(0));
    tasks.for_each((count + k_patches_at_once - 1) / k_patches_at_once, [&](std::size_t run, int) {
        interruption_point();
        const std::size_t first = run * k_patches_at_once, last = std::min(first + k_patches_at_once, count);
        Caster(patches, state, rays).cast(static_cast<PatchId>(first), static_cast<PatchId>(last), surroundings, links);
    });
    return links;
}

void gather_links(const PatchLinks& links, std::span<const glm::vec3> exitance, std::span<glm::vec3> irradiance,
                  Tasks& tasks)
{
    constexpr float k_weight = 1 / static_cast<float>(PatchLinks::k_rays);
    const std::size_t count = exitance.size();
    tasks.for_each((count + k_patches_to_gather - 1) / k_patches_to_gather, [&](std::size_t run, int) {
        const std::size_t last = std::min((run + 1) * k_patches_to_gather, count);
        for (std::size_t p = run * k_patches_to_gather; p < last; ++p) {
            glm::vec3 sum(0);
            const std::uint16_t* target = links.target.data() + PatchLinks::k_rays * p;
            for (std::size_t k = 0; k < PatchLinks::k_rays; ++k)
                if (target[k] != PatchLinks::k_none) sum += exitance[target[k]];
            irradiance[p] = k_weight * sum;
        }
    });
}

}   // namespace gnomon::patches
