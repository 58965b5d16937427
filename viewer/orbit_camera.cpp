// SPDX-License-Identifier: Apache-2.0
#include "viewer/orbit_camera.h"

#include <algorithm>
#include <cmath>

namespace gnomon::viewer {

namespace {

constexpr float k_steepest = 1.55f;   // radians: just short of straight up
constexpr float k_nearest = 1e-6f, k_farthest = 1e9f;

bool is_orthographic(const Camera& camera)
{
    if (camera.matrix) return camera.matrix->m[15] == 1;
    return !camera.intrinsics && camera.orthographic_height;
}

// Half the height of the image plane at distance 1, or of the whole view if orthographic.
double half_height(const Camera& camera)
{
    if (camera.matrix) return 1 / camera.matrix->m[5];
    if (camera.intrinsics) return camera.intrinsics->size.height / (2 * camera.intrinsics->fy);
    if (camera.orthographic_height) return *camera.orthographic_height / 2;
    return std::tan(camera.vertical_fov / 2);
}

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
    orthographic_ = is_orthographic(lens_);
    half_height_ = static_cast<float>(half_height(lens_)) / (orthographic_ ? distance_ : 1);
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
