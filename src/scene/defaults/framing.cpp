// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/framing.h"

#include <algorithm>
#include <limits>

#include "scene/state.h"

namespace gnomon::scene {

namespace {

constexpr double k_huge = std::numeric_limits<double>::max();
constexpr double k_least_distance = 0.05;   // in front of the nearest point, as a fraction of the scene's size
constexpr double k_least_size = 1e-6;

// Finds the nearest position from which all points are in view. A point with coordinates r to the right, u up and b
// back is within the frame's width, seen from (x, y, d), if |r - x| <= t (d - b), with t the tangent of half the
// horizontal angle. So the greatest r + t b bounds x + t d from below, and the greatest -r + t b bounds -x + t d; the
// smallest d that satisfies both has x half-way between. The height is treated likewise.
class Frustum {
 public:
    explicit Frustum(const FramingOptions& options)
        : back_(options.back),
          right_(glm::normalize(glm::cross(glm::dvec3(0, 1, 0), back_))),
          up_(glm::cross(back_, right_)),
          tangent_{options.narrowest_aspect * std::tan(options.vertical_fov / 2) / options.margin,
                   std::tan(options.vertical_fov / 2) / options.margin}
    {
    }

    void add(const glm::dvec3& p)
    {
        const double back = glm::dot(p, back_);
        const double across[2] = {glm::dot(p, right_), glm::dot(p, up_)};
        for (int axis = 0; axis < 2; ++axis) {
            high_[axis] = std::max(high_[axis], across[axis] + tangent_[axis] * back);
            low_[axis] = std::max(low_[axis], -across[axis] + tangent_[axis] * back);
        }
        nearest_ = std::max(nearest_, back);
        box_.add(glm::vec3(p));
    }

    const Box3& box() const { return box_; }

    Framed framed() const
    {
        if (box_.empty()) return {back_ / std::sin(std::atan(tangent_[1])), 2};
        const double size = std::max(static_cast<double>(box_.diagonal()), k_least_size);
        double distance = nearest_ + k_least_distance * size;
        for (int axis = 0; axis < 2; ++axis)
            distance = std::max(distance, (high_[axis] + low_[axis]) / (2 * tangent_[axis]));
        return {0.5 * (high_[0] - low_[0]) * right_ + 0.5 * (high_[1] - low_[1]) * up_ + distance * back_, size};
    }

 private:
    glm::dvec3 back_, right_, up_;
    double tangent_[2];
    double high_[2] = {-k_huge, -k_huge}, low_[2] = {-k_huge, -k_huge};
    double nearest_ = -k_huge;
    Box3 box_;
};

void add_object(const SceneState& state, ObjectId id, Frustum& frustum)
{
    if (!state.object_visible(id)) return;
    const Scene& scene = state.scene();
    const Object& object = scene.objects[id];
    const glm::mat4 world = state.object_matrix(id);
    const std::vector<glm::vec3>& positions =
        object.deforming ? state.deformed(id).positions : scene.meshes[object.mesh].positions;
    for (const glm::uvec3& triangle : scene.meshes[object.mesh].triangles)
        for (int i = 0; i < 3; ++i)
            if (const glm::vec3 p = transform_point(world, positions[triangle[i]]); is_finite(p))
                frustum.add(glm::dvec3(p));
}

}   // namespace

Framed frame_clip(const Scene& scene, const FramingOptions& options)
{
    const double start = scene.timeline.start, length = scene.timeline.end - start;
    const auto objects = static_cast<ObjectId>(scene.objects.size());
    SceneState state({std::shared_ptr<const Scene>(), &scene}, start);   // the pointer does not own the scene
    Frustum first(options);
    for (ObjectId id = 0; id < objects; ++id) add_object(state, id, first);
    Frustum all = first;
    for (int look = 1; length > 0 && look < options.looks; ++look) {
        state.advance(start + length * look / (options.looks - 1));
        for (ObjectId id = 0; id < objects; ++id)
            if (scene.objects[id].dynamic) add_object(state, id, all);
    }
    const bool goes_far = !first.box().empty() && all.box().diagonal() > options.widest_clip * first.box().diagonal();
    return (goes_far ? first : all).framed();
}

}   // namespace gnomon::scene
