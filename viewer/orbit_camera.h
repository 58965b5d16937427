// SPDX-License-Identifier: Apache-2.0
#pragma once
// The viewer's own eye: it circles a point, moves with it, comes nearer, or flies. World up is +Y.

#include "scene/view.h"

namespace gnomon::viewer {

class OrbitCamera {
 public:
    /// Takes over from a view, turning around the point `distance` ahead of it.
    void follow(const scene::View& view, float distance);

    /// Around the pivot, radians: to the right and upwards. Stops short of straight up and down.
    void orbit(float right, float up);
    /// Looks around from where the eye is, radians.
    void look(float right, float up);
    /// Across the view, as shares of its height at the pivot.
    void pan(float right, float up);
    /// @param factor  of the distance to the pivot; above 1 backs away
    void zoom(float factor);
    /// Along the view, to its right and straight up, in scene units.
    void fly(float forward, float right, float up);
    /// The pivot becomes that point; the eye stays, the view turns towards it.
    void aim(const glm::vec3& point);

    scene::View view(Size size) const;
    float distance() const { return distance_; }
    const glm::vec3& pivot() const { return pivot_; }

 private:
    glm::vec3 forward() const;
    glm::vec3 right() const;

    glm::vec3 pivot_{0};
    float yaw_ = 0, pitch_ = 0;   // radians; 0: towards -Z, level
    float distance_ = 1;
    float half_height_ = 0.4f;   // tangent of half the vertical field of view; of an orthographic view, at distance 1
    bool orthographic_ = false;
    float near_ = 0.01f, far_ = k_infinity;
};

}   // namespace gnomon::viewer
