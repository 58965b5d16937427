// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where a camera shows a point of the world, and what lies below a place of its image.

#include <optional>

#include "base/math.h"
#include "gnomon/scene_parts.h"

namespace gnomon::viewer {

glm::dmat4 matrix_of(const Transform& transform);

/// What a camera's image shows of the plane at distance 1 in front of it, or of the whole view if it is orthographic.
struct ImagePlane {
    glm::dvec2 half{1}, centre{0};   // half of width and height, and the middle, from the axis along which it looks
    bool orthographic = false;
};
/// @param size  of the image that the camera makes, in any unit
ImagePlane image_plane_of(const Camera& camera, const glm::vec2& size);

class Projection {
 public:
    /// @param size  of the image that the camera makes, in any unit
    Projection(const Camera& camera, const glm::vec2& size);

    /// The place of a point, in fractions of the image's width and height from its top left; none behind the camera.
    std::optional<glm::vec2> place_of(const glm::vec3& point) const;
    /// What a place shows lies on a line.
    struct Line {
        glm::vec3 origin{0}, direction{0};   // direction: unit, away from the camera
    };
    Line line_at(const glm::vec2& place) const;
    /// What the image's height shows at the depth of a point, in metres.
    float height_at(const glm::vec3& point) const;
    /// From a point towards the viewer: a unit vector.
    glm::vec3 to_viewer(const glm::vec3& point) const;

 private:
    glm::mat3 axes_{1};   // the camera's, in world space
    glm::vec3 eye_{0};
    glm::vec2 half_{1}, centre_{0};   // as ImagePlane has them
    bool orthographic_ = false;
};

}   // namespace gnomon::viewer
