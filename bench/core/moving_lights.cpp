// SPDX-License-Identifier: Apache-2.0
#include "bench/core/moving_lights.h"

#include <cmath>

namespace gnomon::bench {

namespace {

// Moves along a circle in the parent's space for the whole clip.
class CircleTrack : public scene::TransformTrack {
 public:
    CircleTrack(const glm::dvec3& across, const glm::dvec3& along, double turn, double speed, scene::Interval clip)
        : across_(across), along_(along), turn_(turn), speed_(speed), clip_(clip)
    {
    }
    glm::dmat4 evaluate(double time) const override
    {
        const double angle = speed_ * (time - clip_.first);
        const glm::dmat4 moved = glm::translate(glm::dmat4(1), std::cos(angle) * across_ + std::sin(angle) * along_);
        return glm::rotate(moved, turn_ * std::sin(angle + 1), glm::dvec3(1, 0, 0));
    }
    std::vector<scene::Interval> changing() const override { return {clip_}; }

 private:
    glm::dvec3 across_, along_;
    double turn_, speed_;
    scene::Interval clip_;
};

// Adds a child of `parent` to a finished scene.
scene::NodeId add_child(scene::Scene& scene, scene::NodeId parent)
{
    const scene::NodeId node = scene.add_node("moving light", parent);
    const auto end = static_cast<std::ptrdiff_t>(scene.child_begin[parent + 1]);
    scene.child_list.insert(scene.child_list.begin() + end,
                            node);   // its index is the largest, so the list stays sorted
    for (std::size_t n = parent + 1; n < scene.child_begin.size(); ++n) ++scene.child_begin[n];
    scene.child_begin.push_back(scene.child_begin.back());
    return node;
}

}   // namespace

std::shared_ptr<const scene::Scene> with_moving_lights(const std::shared_ptr<const scene::Scene>& scene,
                                                       const MovingLightsOptions& options)
{
    auto changed = std::make_shared<scene::Scene>(*scene);
    const scene::Timeline& timeline = changed->timeline;
    const Box3 box = changed->bounds(timeline.start);
    const double radius = options.radius * (box.empty() ? 1 : glm::length(glm::dvec3(box.high - box.low)));
    const double frame = timeline.frames > 1 ? (timeline.end - timeline.start) / (timeline.frames - 1) : 1;
    for (scene::Light& light : changed->lights) {
        // Undo the node's scale, so that the circle has the same radius in world space for every light.
        const glm::dmat3 to_node = glm::inverse(glm::dmat3(changed->world_matrix(light.node, timeline.start)));
        const scene::NodeId node = add_child(*changed, light.node);
        changed->nodes[node].transform = std::make_shared<CircleTrack>(
            to_node * glm::dvec3(radius, 0, 0), to_node * glm::dvec3(0, 0, radius), options.turn, options.step / frame,
            scene::Interval{timeline.start, timeline.end});
        changed->nodes[node].animated = true;
        changed->track_nodes.push_back(node);
        light.node = node;
    }
    return changed;
}

}   // namespace gnomon::bench
