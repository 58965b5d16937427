// SPDX-License-Identifier: Apache-2.0
#pragma once
// Layers of what is seen at the pixels' centres, unfiltered: ids of object and material, and motion vectors.
//
// One camera ray per pixel finds the first surface, as the traced frame's first sample does. The same surface point,
// an object's triangle and barycentric coordinates, is then looked up in the state of the frame before, and both
// points are projected by the view of their own frame. The difference is the motion.
//
// Cost: one closest-hit ray per pixel. The pass runs only in frames in which one of these layers is requested, and
// needs nothing else of the frame, so that it serves the rasterised frame, too.
// Invariant: motion is exactly 0 where neither the surface nor the view changed.

#include "base/tasks.h"
#include "ray/ray_scene.h"
#include "scene/view.h"
#include "shading/frame_buffers.h"

namespace gnomon::trace {

/// The id of an object, a material or another part in the layer of ids; 0 stands for nothing.
constexpr std::uint32_t layer_id(std::uint32_t index)
{
    return index + 1;   // scene::none becomes 0
}

/// The state and the view of the frame before.
struct FrameBefore {
    const scene::SceneState* state = nullptr;   // of the same scene
    scene::View view;
};

/// What the ray through a pixel's centre meets first.
struct ViewHit {
    scene::ObjectId object = scene::none;   // none: nothing; the rest is then undefined
    scene::MaterialId material = scene::none;
    std::uint32_t triangle = 0;   // of the object's mesh
    float u = 0, v = 0;           // the point is (1-u-v) p0 + u p1 + v p2
    float distance = 0;           // from the ray's origin
    glm::vec3 direction{0};       // of the ray; unit
};

/// Fills one or both layers of `out`.
/// @param rays    follow `state`
/// @param before  optional; without it, as in a first frame, motion is 0
class CentreLayers {
 public:
    CentreLayers(const scene::SceneState& state, const ray::RayScene& rays, const scene::View& view,
                 const FrameBefore* before);

    void trace(bool ids, bool motion, Tasks& tasks, shading::FrameBuffers& out) const;

    /// What the layer of ids holds at a pixel, and more. Traces the same rays together, because rays of other packets
    /// may find another one of two surfaces at the same distance.
    ViewHit hit_at(const glm::ivec2& pixel) const;

 private:
    struct Block;
    void find_hits(Block& block) const;
    void trace_block(Block& block, bool ids, bool motion, shading::FrameBuffers& out) const;
    glm::dvec2 surface_motion(scene::ObjectId object, std::uint32_t triangle, float u, float v) const;
    glm::dvec2 background_motion(const glm::vec3& direction) const;

    const scene::SceneState& state_;
    const ray::RayScene& rays_;
    const scene::View& view_;
    const FrameBefore* before_;
    bool hides_surfaces_;   // see hidden_surfaces.h
};

}   // namespace gnomon::trace
