// SPDX-License-Identifier: Apache-2.0
#pragma once
// The viewer's interactive camera: it orbits a pivot, pans with it, zooms towards it, or flies. World up is +Y.

#include <optional>

#include "base/math.h"
#include "gnomon/scene_parts.h"

namespace gnomon::viewer {

/// Where a camera stands, and the unit vector along which it looks; both in world space.
glm::vec3 eye_of(const Camera& camera);
glm::vec3 forward_of(const Camera& camera);

class OrbitCamera {
 public:
    /// Starts from a camera, whose projection it keeps; the pivot is the point `distance` ahead of it.
    /// @param size      of the images that the camera makes
    /// @param distance  above 0, in scene units
    void follow(const Camera& camera, Size size, float distance);

    /// Turns around the pivot by angles in radians, to the right and upwards, stopping short of straight up and down.
    void orbit(float right, float up);
    /// Turns around the eye by angles in radians.
    void look(float right, float up);
    /// Moves eye and pivot across the view, in fractions of the view's height at the pivot.
    void pan(float right, float up);
    /// Multiplies the distance to the pivot by `factor`; above 1 moves away.
    void zoom(float factor);
    /// Moves along the view direction, to the right and straight up, in scene units.
    void fly(float forward, float right, float up);
    /// Makes `point` the pivot and turns the view towards it; the eye stays.
    void aim(const glm::vec3& point);

    /// Sides to look from: along an axis of the world, or from a corner of a cube.
    enum class Side { front, right, top, corner };
    /// The side that a digit key stands for: 1, 3, 7 and 9, as in f3d.
    static std::optional<Side> side_of(int character);
    /// Looks at the pivot from a side, at the same distance.
    void look_from(Side side);
    /// Makes a box's centre the pivot, and moves along the view until all of the box is shown, if it is not empty.
    /// @param size  of the images that the camera makes
    void fit(const Box3& box, Size size);

    /// The camera as it stands now, with its transform to the world.
    Camera camera() const;
    float distance() const { return distance_; }
    const glm::vec3& pivot() const { return pivot_; }

 private:
    glm::vec3 forward() const;
    glm::vec3 right() const;

    Camera lens_;   // its projection
    glm::vec3 pivot_{0};
    float yaw_ = 0, pitch_ = 0;   // radians; at 0 the view is level and towards -Z
    float distance_ = 1;
    float half_height_ = 0.4f;   // of the view at the pivot, as a fraction of the distance to it
    bool orthographic_ = false;
};

}   // namespace gnomon::viewer
