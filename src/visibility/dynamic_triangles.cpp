// SPDX-License-Identifier: Apache-2.0
#include "visibility/dynamic_triangles.h"

#include <algorithm>

namespace gnomon::visibility {

void DynamicTriangles::follow(const scene::SceneState& state, const ray::RayScene& rays, const DynamicBounds& bounds)
{
    const scene::FrameChanges& changes = state.changes();
    const bool anew = bounds_ != &bounds || !changes.added.empty() || !changes.removed.empty() ||
                      !changes.promoted.empty() || !changes.separated.empty() || !changes.materials_changed.empty();
    state_ = &state, rays_ = &rays, bounds_ = &bounds;
    if (anew) kept_.clear(), triangle_bytes_ = 0;
    while (kept_.size() < bounds.size()) kept_.emplace_back();
}

const DynamicTriangles::Blocker& DynamicTriangles::of(std::uint32_t index) const
{
    Kept& kept = kept_[index];
    const std::uint64_t stamp = bounds_->placed_at(index) + 1;
    if (kept.made.load(std::memory_order_acquire) != stamp) {
        const std::lock_guard lock(mutex_);
        if (kept.made.load(std::memory_order_relaxed) != stamp) {
            triangle_bytes_ -= kept.blocker.triangles.capacity() * sizeof(StaticTriangle);
            make(index, kept.blocker);
            triangle_bytes_ += kept.blocker.triangles.capacity() * sizeof(StaticTriangle);
            kept.made.store(stamp, std::memory_order_release);
        }
    }
    return kept.blocker;
}

void DynamicTriangles::make(std::uint32_t index, Blocker& blocker) const
{
    blocker.triangles.clear();
    blocker.listed = false;
    const scene::Scene& scene = state_->scene();
    std::vector<scene::ObjectId> objects;
    bounds_->objects_of(index, *state_, objects);
    for (const scene::ObjectId o : objects) {
        const ray::Meeting meeting = rays_->meeting(o);
        if (meeting == ray::Meeting::never) continue;
        const ray::ObjectGeometry& geometry = rays_->geometry(o);
        bool listed = meeting == ray::Meeting::truly;
        for (const scene::MeshPart& part : geometry.mesh->parts) {
            const scene::SurfaceClass surface = scene.materials[part.material].surface_class();
            if (surface == scene::SurfaceClass::transparent) continue;
            listed = listed && surface == scene::SurfaceClass::opaque &&
                     blocker.triangles.size() + part.triangle_count <= k_most;
            if (!listed) break;
            for (std::uint32_t t = 0; t < part.triangle_count; ++t) {
                StaticTriangle triangle;
                geometry.corners(part.first_triangle + t, triangle.p);
                blocker.triangles.push_back(triangle);
            }
        }
        if (!listed) {
            blocker.triangles.clear();
            return;
        }
    }
    blocker.listed = true;
}

}   // namespace gnomon::visibility
