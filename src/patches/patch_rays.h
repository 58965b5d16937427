// SPDX-License-Identifier: Apache-2.0
#pragma once
// Rays that find patches: each continues past surfaces that do not block light, and ends where one does.
//
// Holds a thread's scratch memory. Cost: a closest hit per ray, one more for each surface that it passes; what
// SurfacePatches::patch_at() costs where it is asked.

#include "patches/surface_patches.h"

namespace gnomon::patches {

class PatchRays {
 public:
    PatchRays();
    void clear() { rays_.clear(), far_.clear(); }
    /// @param direction  unit
    /// @param far        where the ray ends
    void push(const glm::vec3& origin, const glm::vec3& direction, float far = k_infinity)
    {
        rays_.push(origin, 0, direction, far);
        far_.push_back(far);
    }
    std::size_t size() const { return rays_.size(); }
    glm::vec3 direction(std::size_t r) const { return rays_.direction(r); }

    /// Finds where all rays end.
    void trace(const scene::Scene& scene, const ray::RayScene& rays, ray::Against against = ray::Against::static_only);
    /// Whether a ray meets nothing that blocks light: if it has no end, it leaves the scene. @pre traced
    bool leaves(std::size_t r) const { return hits_.object[r] == scene::none; }
    /// Removes the rays that leave(). @pre traced; then they are to be traced again
    void keep_ended();
    /// How far along a ray its end is. @pre traced, and it does not leave the scene
    float distance(std::size_t r) const { return hits_.t[r]; }
    /// The object that a ray ends on. @pre traced, and it does not leave the scene
    scene::ObjectId object(std::size_t r) const { return hits_.object[r]; }
    /// Where a ray ends, and the normal there of the side that it meets. @pre traced, and it does not leave the scene
    struct End {
        glm::vec3 position, normal;
    };
    End end(const ray::RayScene& rays, std::size_t r) const
    {
        const Surface at = surface(rays, r);
        return {at.position, glm::dot(at.normal, rays_.direction(r)) < 0 ? at.normal : -at.normal};
    }
    /// The patch that a ray ends on, if any. @pre traced, and it does not leave the scene
    PatchId patch(const SurfacePatches& patches, const ray::RayScene& rays, std::size_t r) const;
    /// Finds the part of light that passes along each ray, up to where it ends. @pre traced
    /// @param passes  out: by ray
    void find_passing(const ray::RayScene& rays, glm::vec3* passes, ray::Against against = ray::Against::static_only);

 private:
    struct Surface {
        glm::vec3 position, normal;   // the normal of the front
        float lift;
    };
    Surface surface(const ray::RayScene& rays, std::size_t r) const;
    bool blocks(const scene::Scene& scene, const ray::RayScene& rays, std::size_t r) const;

    ray::RayQueue rays_, passing_;
    std::vector<float> far_;   // by ray
    ray::Hits hits_, next_;
    std::vector<std::uint32_t> passing_ray_;
};

}   // namespace gnomon::patches
