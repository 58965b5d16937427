// SPDX-License-Identifier: Apache-2.0
#include "patches/patch_rays.h"

#include <algorithm>
#include <cmath>

#include "ray/origin.h"

namespace gnomon::patches {

namespace {

constexpr int k_most_passes = 8;   // through surfaces that do not block light
constexpr float k_least_cosine = 1e-3f;

}   // namespace

PatchRays::PatchRays()
{
    rays_.purpose = passing_.purpose = ray::RayClass::indirect;
}

PatchRays::Surface PatchRays::surface(const ray::RayScene& rays, std::size_t r) const
{
    glm::vec3 p[3];
    rays.geometry(hits_.object[r]).corners(hits_.triangle[r], p);
    const float u = hits_.u[r], v = hits_.v[r];
    return {std::max(0.0f, 1 - u - v) * p[0] + u * p[1] + v * p[2],
            glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0])), ray::origin_lift(p)};
}

bool PatchRays::blocks(const scene::Scene& scene, const ray::RayScene& rays, std::size_t r) const
{
    if (hits_.object[r] == scene::none) return true;
    const scene::Mesh& mesh = *rays.geometry(hits_.object[r]).mesh;
    return scene.materials[mesh.part_of(hits_.triangle[r]).material].surface_class() !=
           scene::SurfaceClass::transparent;
}

void PatchRays::trace(const scene::Scene& scene, const ray::RayScene& rays, ray::Against against)
{
    hits_.resize(rays_.size());
    rays.closest(rays_, 0, rays_.size(), hits_, ray::Sides::both, against);
    // Continue rays that met a surface that does not block light, behind it.
    for (int pass = 0; pass < k_most_passes; ++pass) {
        passing_.clear(), passing_ray_.clear();
        for (std::uint32_t r = 0; r < rays_.size(); ++r) {
            if (blocks(scene, rays, r)) continue;
            const Surface at = surface(rays, r);
            const float cosine = std::abs(glm::dot(at.normal, rays_.direction(r)));
            passing_.push(rays_.origin(r), hits_.t[r] + at.lift / std::max(cosine, k_least_cosine), rays_.direction(r),
                          far_[r]);
            passing_ray_.push_back(r);
        }
        if (passing_.empty()) return;
        next_.resize(passing_.size());
        rays.closest(passing_, 0, passing_.size(), next_, ray::Sides::both, against);
        for (std::size_t i = 0; i < passing_ray_.size(); ++i) {
            const std::uint32_t r = passing_ray_[i];
            hits_.t[r] = next_.t[i], hits_.u[r] = next_.u[i], hits_.v[r] = next_.v[i];
            hits_.object[r] = next_.object[i], hits_.triangle[r] = next_.triangle[i];
        }
    }
}

void PatchRays::keep_ended()
{
    passing_.clear();
    std::size_t kept = 0;
    for (std::size_t r = 0; r < rays_.size(); ++r) {
        if (leaves(r)) continue;
        passing_.push(rays_.origin(r), 0, rays_.direction(r), far_[r]);
        far_[kept++] = far_[r];
    }
    far_.resize(kept);
    std::swap(rays_, passing_);
}

PatchId PatchRays::patch(const SurfacePatches& patches, const ray::RayScene& rays, std::size_t r) const
{
    const Surface at = surface(rays, r);
    const bool front = glm::dot(at.normal, rays_.direction(r)) < 0;
    return patches.patch_at(rays, hits_.object[r], hits_.triangle[r], hits_.u[r], hits_.v[r], front,
                            at.position + (front ? at.lift : -at.lift) * at.normal);
}

void PatchRays::find_passing(const ray::RayScene& rays, glm::vec3* passes, ray::Against against)
{
    for (std::size_t r = 0; r < rays_.size(); ++r) rays_.tfar[r] = leaves(r) ? far_[r] : hits_.t[r];
    rays.let_through(rays_, 0, rays_.size(), passes, against);
}

}   // namespace gnomon::patches
