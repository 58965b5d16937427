// SPDX-License-Identifier: Apache-2.0
#include "scene/pose_between.h"

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <optional>

#include "scene/material_layers.h"
#include "scene/material_members.h"

namespace gnomon::scene {

namespace {

constexpr double k_skew = 1e-6;   // cosine between axes beyond which a matrix is more than turned and scaled

struct Parts {
    glm::dvec3 scale{1};
    glm::dquat rotation{1, 0, 0, 0};
};

// A matrix as a rotation after a scale, of which one factor is negative if it mirrors.
std::optional<Parts> parts_of(const glm::dmat4& m)
{
    Parts parts;
    glm::dmat3 axes(m);
    for (int i = 0; i < 3; ++i) {
        parts.scale[i] = std::sqrt(glm::dot(axes[i], axes[i]));
        if (!(parts.scale[i] > 0)) return {};
        axes[i] /= parts.scale[i];
    }
    for (int i = 0; i < 3; ++i)
        if (std::abs(glm::dot(axes[i], axes[(i + 1) % 3])) > k_skew) return {};
    if (glm::dot(glm::cross(axes[0], axes[1]), axes[2]) < 0) {
        axes[0] = -axes[0];
        parts.scale[0] = -parts.scale[0];
    }
    parts.rotation = glm::normalize(glm::quat_cast(axes));
    return parts;
}

template <class T>
T linear(const T& a, const T& b, double fraction)
{
    return a + (b - a) * fraction;
}

// Blends members of a table.
template <class T, class Members>
void blend(T& of, const T& second, const Members& members, float fraction)
{
    for (const auto member : members) of.*member += (second.*member - of.*member) * fraction;
}

}   // namespace

glm::dmat4 pose_between(const glm::dmat4& first, const glm::dmat4& second, double fraction)
{
    if (first == second) return first;
    const std::optional<Parts> a = parts_of(first), b = parts_of(second);
    if (!a || !b || (a->scale.x < 0) != (b->scale.x < 0)) return linear(first, second, fraction);
    const glm::dquat to = glm::dot(a->rotation, b->rotation) < 0 ? -b->rotation : b->rotation;
    const glm::dquat rotation = glm::normalize(a->rotation * (1 - fraction) + to * fraction);
    const glm::dvec3 scale = linear(a->scale, b->scale, fraction);
    const glm::dmat3 axes = glm::mat3_cast(rotation);
    glm::dmat4 result(1);
    for (int i = 0; i < 3; ++i) result[i] = glm::dvec4(axes[i] * scale[i], 0);
    result[3] = linear(first[3], second[3], fraction);
    return result;
}

DeformedMesh pose_between(const DeformedMesh& first, const std::vector<glm::vec3>& second, double fraction)
{
    DeformedMesh result = first;
    const auto f = static_cast<float>(fraction);
    for (std::size_t i = 0; i < second.size(); ++i)
        result.positions[i] = first.positions[i] + (second[i] - first.positions[i]) * f;
    return result;
}

std::vector<float> pose_between(const std::vector<float>& first, const std::vector<float>& second, double fraction)
{
    std::vector<float> result = first;
    const auto f = static_cast<float>(fraction);
    for (std::size_t i = 0; i < second.size(); ++i) result[i] = first[i] + (second[i] - first[i]) * f;
    return result;
}

Light pose_between(const Light& first, const Light& second, double fraction)
{
    constexpr float Light::*k_numbers[] = {&Light::inner_angle, &Light::outer_angle, &Light::range};
    constexpr glm::vec3 Light::*k_colors[] = {&Light::color};
    Light result = first;
    blend(result, second, k_numbers, static_cast<float>(fraction));
    blend(result, second, k_colors, static_cast<float>(fraction));
    return result;
}

Material pose_between(const Material& first, const Material& second, double fraction)
{
    const auto f = static_cast<float>(fraction);
    Material result = first;
    blend(result, second, k_material_numbers, f);
    blend(result, second, k_material_colors, f);
    if (first.layers && second.layers) {
        MaterialLayers layers = *first.layers;
        blend(layers, *second.layers, k_layer_numbers, f);
        blend(layers, *second.layers, k_layer_colors, f);
        result.layers = std::make_shared<const MaterialLayers>(layers);
    }
    return result;
}

View view_between(const Camera& first, const glm::dmat4& first_to_world, const Camera& second,
                  const glm::dmat4& second_to_world, Size size, double fraction)
{
    const glm::dmat4 place = pose_between(first_to_world, second_to_world, fraction);
    View view = make_view(first, place, size);
    const View end = make_view(second, place, size);
    const auto f = static_cast<float>(fraction);
    view.right += (end.right - view.right) * f;
    view.up += (end.up - view.up) * f;
    view.shift += (end.shift - view.shift) * f;
    view.pixel_spread += (end.pixel_spread - view.pixel_spread) * f;
    view.pixel_width += (end.pixel_width - view.pixel_width) * f;
    return view;
}

}   // namespace gnomon::scene
