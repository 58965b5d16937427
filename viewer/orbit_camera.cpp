// SPDX-License-Identifier: Apache-2.0
#include "viewer/orbit_camera.h"

#include <algorithm>
#include <cmath>

#include "viewer/projection.h"

namespace gnomon::viewer {

namespace {

constexpr float k_steepest = 1.55f;   // radians: just short of straight up
constexpr float k_nearest = 1e-6f, k_farthest = 1e9f;
constexpr double k_filled = 0.92;   // of the view's width or height, by what fits into it

void set_column(Transform& transform, std::size_t column, const glm::vec3& v)
{
    for (std::size_t row = 0; row < 3; ++row)
        transform.m[4 * column + row] = static_cast<double>(v[static_cast<int>(row)]);
}

}   // namespace

glm::vec3 eye_of(const Camera& camera)
{
    const auto& m = camera.transform.m;
    return glm::vec3(glm::dvec3(m[12], m[13], m[14]));
}

glm::vec3 forward_of(const Camera& camera)
{
    const auto& m = camera.transform.m;
    const glm::dvec3 forward(-m[8], -m[9], -m[10]);
    const double length = glm::length(forward);
    return length > 0 && std::isfinite(length) ? glm::vec3(forward / length) : glm::vec3(0, 0, -1);
}

void OrbitCamera::follow(const Camera& camera, Size size, float distance)
{
    lens_ = camera;
    if (lens_.intrinsics && lens_.intrinsics->size.width == 0) lens_.intrinsics->size = size;
    distance_ = std::clamp(distance, k_nearest, k_farthest);
    const glm::vec3 forward = forward_of(camera);
    yaw_ = std::atan2(forward.x, -forward.z);
    pitch_ = std::clamp(std::asin(std::clamp(forward.y, -1.0f, 1.0f)), -k_steepest, k_steepest);
    pivot_ = eye_of(camera) + distance_ * forward;

    // Zooming changes the height of an orthographic view, so a matrix becomes a height.
    const ImagePlane plane = image_plane_of(lens_, glm::vec2(size.width, size.height));
    orthographic_ = plane.orthographic;
    half_height_ = static_cast<float>(plane.half.y) / (orthographic_ ? distance_ : 1);
    if (orthographic_) lens_.matrix.reset();
}

glm::vec3 OrbitCamera::forward() const
{
    return {std::sin(yaw_) * std::cos(pitch_), std::sin(pitch_), -std::cos(yaw_) * std::cos(pitch_)};
}

glm::vec3 OrbitCamera::right() const
{
    return {std::cos(yaw_), 0, std::sin(yaw_)};
}

void OrbitCamera::orbit(float right, float up)
{
    // The scene follows the mouse, so the eye moves the other way.
    yaw_ -= right;
    pitch_ = std::clamp(pitch_ - up, -k_steepest, k_steepest);
}

void OrbitCamera::look(float right, float up)
{
    const glm::vec3 eye = pivot_ - distance_ * forward();
    yaw_ += right;
    pitch_ = std::clamp(pitch_ + up, -k_steepest, k_steepest);
    pivot_ = eye + distance_ * forward();
}

void OrbitCamera::pan(float right, float up)
{
    const float height = 2 * half_height_ * distance_;
    pivot_ -= height * (right * this->right() + up * glm::cross(this->right(), forward()));
}

void OrbitCamera::zoom(float factor)
{
    distance_ = std::clamp(distance_ * factor, k_nearest, k_farthest);
}

void OrbitCamera::fly(float forward, float right, float up)
{
    pivot_ += forward * this->forward() + right * this->right() + up * glm::vec3(0, 1, 0);
}

void OrbitCamera::aim(const glm::vec3& point)
{
    const glm::vec3 eye = pivot_ - distance_ * forward(), to = point - eye;
    const float length = glm::length(to);
    if (!(length > k_nearest)) return;
    distance_ = length;
    yaw_ = std::atan2(to.x, -to.z);
    pitch_ = std::clamp(std::asin(std::clamp(to.y / length, -1.0f, 1.0f)), -k_steepest, k_steepest);
    pivot_ = eye + distance_ * this->forward();
}

std::optional<OrbitCamera::Side> OrbitCamera::side_of(int character)
{
    switch (character) {
        case '1':
            return Side::front;
        case '3':
            return Side::right;
        case '7':
            return Side::top;
        case '9':
            return Side::corner;
        default:
            return std::nullopt;
    }
}

void OrbitCamera::look_from(Side side)
{
    const float quarter = static_cast<float>(k_pi) / 2;
    yaw_ = side == Side::right ? -quarter : side == Side::corner ? -quarter / 2 : 0;
    pitch_ = side == Side::top ? -k_steepest : side == Side::corner ? -std::asin(1 / std::sqrt(3.0f)) : 0;
}

void OrbitCamera::fit(const Box3& box, Size size)
{
    if (box.empty() || !is_finite(box.size())) return;
    pivot_ = box.centre();
    const ImagePlane plane = image_plane_of(camera(), glm::vec2(size.width, size.height));
    // How far the view reaches to the left, right, below and above, as fractions of the distance or of its half height.
    const double unit = orthographic_ ? plane.half.y : 1;
    const glm::vec2 low((k_filled * plane.half - plane.centre) / unit),
        high((k_filled * plane.half + plane.centre) / unit);
    const glm::vec3 across = right(), ahead = forward(), above = glm::cross(across, ahead);
    float distance = k_nearest, half_height = k_nearest;   // the least that show every corner
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const glm::vec3 arm = 0.5f * sign * box.size();
        const float nearer = -glm::dot(arm, ahead);
        const glm::vec2 place(glm::dot(arm, across), glm::dot(arm, above));
        float needed = 0;
        for (int axis = 0; axis < 2; ++axis) {
            // A view that is shifted past its axis on this side cannot show the pivot, so it decides nothing.
            const float reach = place[axis] > 0 ? high[axis] : low[axis];
            if (reach > 0) needed = std::max(needed, std::abs(place[axis]) / reach);
        }
        half_height = std::max(half_height, needed);
        distance = std::max(distance, nearer + (orthographic_ ? 0 : needed));
    }
    // An orthographic camera stands clear of the box, and its height shows it.
    if (orthographic_) distance = std::max(distance, box.diagonal());
    distance_ = std::clamp(distance, k_nearest, k_farthest);
    if (orthographic_) half_height_ = half_height / distance_;
}

Camera OrbitCamera::camera() const
{
    Camera camera = lens_;
    const glm::vec3 ahead = forward();
    camera.transform = {};
    set_column(camera.transform, 0, right());
    set_column(camera.transform, 1, glm::cross(right(), ahead));
    set_column(camera.transform, 2, -ahead);
    set_column(camera.transform, 3, pivot_ - distance_ * ahead);
    if (orthographic_) camera.orthographic_height = 2 * static_cast<double>(half_height_ * distance_);
    return camera;
}

}   // namespace gnomon::viewer
