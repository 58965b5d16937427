// SPDX-License-Identifier: Apache-2.0
#include "viewer/orbit_camera.h"

#include <algorithm>
#include <cmath>

namespace gnomon::viewer {

namespace {
constexpr float k_steepest = 1.55f;   // radians: just short of straight up
constexpr float k_nearest = 1e-6f, k_farthest = 1e9f;
}   // namespace

void OrbitCamera::follow(const scene::View& view, float distance)
{
    distance_ = std::clamp(distance, k_nearest, k_farthest);
    yaw_ = std::atan2(view.forward.x, -view.forward.z);
    pitch_ = std::clamp(std::asin(std::clamp(view.forward.y, -1.0f, 1.0f)), -k_steepest, k_steepest);
    pivot_ = view.eye + distance_ * view.forward;
    orthographic_ = view.orthographic;
    half_height_ = glm::length(view.up) / (orthographic_ ? distance_ : 1);
    near_ = view.near;
    far_ = view.far;
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

scene::View OrbitCamera::view(Size size) const
{
    scene::View view;
    view.size = size;
    view.forward = forward();
    view.eye = pivot_ - distance_ * view.forward;
    view.orthographic = orthographic_;
    view.near = near_;
    view.far = far_;
    const float half_height = half_height_ * (orthographic_ ? distance_ : 1);
    view.right = half_height * static_cast<float>(size.width) / static_cast<float>(size.height) * right();
    view.up = half_height * glm::cross(right(), view.forward);
    (view.orthographic ? view.pixel_width : view.pixel_spread) = 2 * half_height / static_cast<float>(size.height);
    return view;
}

}   // namespace gnomon::viewer
