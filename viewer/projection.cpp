// SPDX-License-Identifier: Apache-2.0
#include "viewer/projection.h"

#include <cmath>

namespace gnomon::viewer {

namespace {

constexpr float k_least_depth = 1e-6f;

}   // namespace

glm::dmat4 matrix_of(const Transform& transform)
{
    glm::dmat4 matrix;
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = transform.m[static_cast<std::size_t>(i)];
    return matrix;
}

ImagePlane image_plane_of(const Camera& camera, const glm::vec2& size)
{
    ImagePlane plane;
    if (camera.matrix) {
        const auto& p = camera.matrix->m;
        plane.orthographic = p[15] == 1;
        plane.half = {1 / p[0], 1 / p[5]};
        plane.centre =
            plane.orthographic ? glm::dvec2(-p[12] / p[0], -p[13] / p[5]) : glm::dvec2(p[8] / p[0], p[9] / p[5]);
    } else if (camera.intrinsics) {
        const Intrinsics& lens = *camera.intrinsics;
        const glm::dvec2 pixels =
            lens.size.width > 0 ? glm::dvec2(lens.size.width, lens.size.height) : glm::dvec2(size);
        plane.half = {pixels.x / (2 * lens.fx), pixels.y / (2 * lens.fy)};
        plane.centre = {(pixels.x / 2 - lens.cx) / lens.fx, (lens.cy - pixels.y / 2) / lens.fy};
    } else {
        plane.orthographic = camera.orthographic_height.has_value();
        plane.half.y = plane.orthographic ? *camera.orthographic_height / 2 : std::tan(camera.vertical_fov / 2);
        plane.half.x = plane.half.y * static_cast<double>(size.x / size.y);
        plane.centre = 2 * plane.half.y * glm::dvec2(camera.shift_x, camera.shift_y);
    }
    return plane;
}

Projection::Projection(const Camera& camera, const glm::vec2& size)
{
    const auto& m = camera.transform.m;
    for (int axis = 0; axis < 3; ++axis) {
        const auto first = 4 * static_cast<std::size_t>(axis);
        const glm::vec3 column(glm::dvec3(m[first], m[first + 1], m[first + 2]));
        if (glm::length(column) > 0) axes_[axis] = glm::normalize(column);
    }
    eye_ = glm::vec3(glm::dvec3(m[12], m[13], m[14]));

    const ImagePlane plane = image_plane_of(camera, size);
    half_ = glm::vec2(plane.half), centre_ = glm::vec2(plane.centre);
    orthographic_ = plane.orthographic;
}

std::optional<glm::vec2> Projection::place_of(const glm::vec3& point) const
{
    const glm::vec3 seen = glm::transpose(axes_) * (point - eye_);
    if (!orthographic_ && !(-seen.z > k_least_depth)) return std::nullopt;
    const glm::vec2 on_plane = orthographic_ ? glm::vec2(seen) : glm::vec2(seen) / -seen.z;
    const glm::vec2 place = (on_plane - centre_) / half_;
    return glm::vec2(0.5f + 0.5f * place.x, 0.5f - 0.5f * place.y);
}

Projection::Line Projection::line_at(const glm::vec2& place) const
{
    const glm::vec2 on_plane = centre_ + half_ * glm::vec2(2 * place.x - 1, 1 - 2 * place.y);
    if (orthographic_) return {eye_ + axes_ * glm::vec3(on_plane, 0), -axes_[2]};
    return {eye_, glm::normalize(axes_ * glm::vec3(on_plane, -1))};
}

float Projection::height_at(const glm::vec3& point) const
{
    return 2 * half_.y * (orthographic_ ? 1 : glm::dot(eye_ - point, axes_[2]));
}

glm::vec3 Projection::to_viewer(const glm::vec3& point) const
{
    return orthographic_ || point == eye_ ? axes_[2] : glm::normalize(eye_ - point);
}

}   // namespace gnomon::viewer
