// SPDX-License-Identifier: Apache-2.0
// The camera's path: a slow arc about the sundial from left to right, rising; it starts and ends at rest.

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/kinetic.h"

namespace gnomon::scene::kinetic {

namespace {

class CameraTrack final : public TransformTrack {
 public:
    glm::dmat4 evaluate(double time) const override
    {
        const double t = std::min(std::max(time / k_end, 0.0), 1.0);
        const double s = t * t * t * (10 + t * (6 * t - 15));   // no speed and no acceleration at either end
        // Polar coordinates about the sundial: angle from +Z, distance, height.
        const double angle = glm::mix(-0.40, 0.42, s);
        const double distance = 12.0 - 1.4 * std::sin(k_pi * s);
        const double height = glm::mix(2.9, 3.7, s);
        const glm::dvec3 eye(distance * std::sin(angle), height, distance * std::cos(angle));
        const glm::dvec3 target(glm::mix(0.55, -0.25, s), glm::mix(1.85, 1.9, s), 0);
        return glm::inverse(glm::lookAt(eye, target, glm::dvec3(0, 1, 0)));
    }
    std::vector<Interval> changing() const override { return {{0, k_end}}; }
};

}   // namespace

void add_camera(Scene& scene)
{
    Camera camera;
    camera.name = "walk";
    camera.vertical_fov = 0.75;
    camera.node = scene.add_node("camera", none);
    scene.nodes[camera.node].transform = std::make_shared<CameraTrack>();
    scene.cameras.push_back(camera);
}

}   // namespace gnomon::scene::kinetic
