// SPDX-License-Identifier: Apache-2.0
#pragma once
// World-space triangles of the dynamic objects, for techniques that test lists of triangles instead of rays.
//
// They are found when they are first asked for, and again after the object changed.
// Cost: a transform per vertex of what changed and is asked for. Memory: 36 bytes for each triangle that was asked for.

#include <atomic>
#include <deque>
#include <mutex>

#include "visibility/dynamic_bounds.h"
#include "visibility/static_triangles.h"

namespace gnomon::visibility {

class DynamicTriangles {
 public:
    static constexpr std::size_t k_most = 1 << 14;   // triangles of an object or group that are listed

    struct Blocker {
        // Whether `triangles` is all that can block light: false for an object with holes by alpha, with very many
        // triangles, or one that rays do not meet where its triangles are.
        bool listed = false;
        std::vector<StaticTriangle> triangles;
    };

    /// Follows the state, after the ray scene and the bounds did. All three must outlive the frame.
    void follow(const scene::SceneState& state, const ray::RayScene& rays, const DynamicBounds& bounds);
    /// The triangles of one of the bounds' boxes (DynamicBounds::select). Thread-safe; valid until the next follow().
    const Blocker& of(std::uint32_t index) const;
    std::size_t bytes() const { return kept_.size() * sizeof(Kept) + triangle_bytes_; }

 private:
    struct Kept {
        Blocker blocker;
        std::atomic<std::uint64_t> made{0};   // one more than the update that placed its box then; 0: never
    };
    void make(std::uint32_t index, Blocker& blocker) const;

    const scene::SceneState* state_ = nullptr;
    const ray::RayScene* rays_ = nullptr;
    const DynamicBounds* bounds_ = nullptr;
    mutable std::deque<Kept> kept_;
    mutable std::mutex mutex_;
    mutable std::atomic<std::size_t> triangle_bytes_{0};
};

}   // namespace gnomon::visibility
