// SPDX-License-Identifier: Apache-2.0
#include "scene/near_origin.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/scene_bounds.h"

namespace gnomon::scene {

namespace {

// Distance from which on a scene or a mesh is far from an origin, in units of its own extent. Rays start 2e-6 of the
// largest coordinate above a surface: for a scene that is near, below a ten-thousandth of its extent.
constexpr float k_far = 32;

class NearerTrack : public TransformTrack {
 public:
    NearerTrack(std::shared_ptr<const TransformTrack> track, const glm::dvec3& origin)
        : track_(std::move(track)), origin_(origin)
    {
    }
    glm::dmat4 evaluate(double time) const override { return translated(track_->evaluate(time), -origin_); }
    std::vector<Interval> changing() const override { return track_->changing(); }

 private:
    std::shared_ptr<const TransformTrack> track_;
    glm::dvec3 origin_;
};

float largest(const glm::vec3& v)
{
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

bool is_far(const Box3& box)
{
    return !box.empty() && largest(box.centre()) > k_far * std::max({box.size().x, box.size().y, box.size().z});
}

// Whether rays are traced in the coordinates of a mesh whose vertices are far from their origin, or joints place a
// mesh.
bool must_stay(const Scene& scene)
{
    return std::any_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
        return object.skin != none ||
               ((object.dynamic || object.deforming) && is_far(scene.meshes[object.mesh].bounds()));
    });
}

}   // namespace

std::shared_ptr<const TransformTrack> nearer_track(std::shared_ptr<const TransformTrack> track,
                                                   const glm::dvec3& origin)
{
    return std::make_shared<const NearerTrack>(std::move(track), origin);
}

glm::dvec3 bring_near(Scene& scene)
{
    const Box3 box = clip_bounds(scene, 1).dense;
    if (!is_far(box) || must_stay(scene)) return glm::dvec3(0);

    // Round the middle to a multiple of a power of two.
    const float extent = std::max({box.size().x, box.size().y, box.size().z, std::ldexp(largest(box.centre()), -20)});
    const double step = std::exp2(std::ceil(std::log2(static_cast<double>(extent))));
    const glm::dvec3 origin = glm::round(glm::dvec3(box.centre()) / step) * step;

    // Move the root nodes, and what is given in coordinates of the world.
    for (Node& node : scene.nodes) {
        if (!node.reach.empty()) {
            node.reach.low -= glm::vec3(origin);
            node.reach.high -= glm::vec3(origin);
        }
        if (node.parent != none) continue;
        node.local = translated(node.local, -origin);
        if (node.transform) node.transform = nearer_track(node.transform, origin);
    }
    return origin;
}

}   // namespace gnomon::scene
