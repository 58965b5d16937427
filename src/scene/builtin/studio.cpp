// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin/studio.h"

#include <algorithm>

#include "scene/direction_grid.h"

namespace gnomon::scene {

namespace {

constexpr int k_width = 256, k_height = 128;

// A soft box, seen from the middle of the studio.
struct SoftBox {
    float azimuth, elevation;   // of its centre, degrees; azimuth 0 is +Z, 90 is +X
    float width, height;        // half, as tangents
    glm::vec3 radiance;
};

constexpr SoftBox k_boxes[] = {
    {-38, 46, 0.55f, 0.42f, {5.3f, 5.15f, 4.9f}},   // key
    {74, 42, 0.60f, 0.38f, {1.75f, 1.8f, 1.85f}},   // fill
    {0, 88, 0.75f, 0.75f, {1.2f, 1.2f, 1.2f}},      // ceiling
    {-128, 40, 0.16f, 0.38f, {4.1f, 4.4f, 4.7f}},   // strips behind
    {146, 44, 0.16f, 0.36f, {3.5f, 3.7f, 4.0f}},
};
constexpr float k_edge = 0.06f;   // width of a box's soft edge, as a tangent

constexpr glm::vec3 k_floor{0.2f, 0.2f, 0.2f}, k_horizon{0.26f, 0.26f, 0.263f}, k_wall{0.14f, 0.14f, 0.143f};
constexpr float k_floor_depth = 0.7f;    // sine below the horizon at which the floor has its own colour
constexpr float k_wall_height = 0.45f;   // sine above it at which the wall has

float smooth(float low, float high, float x)
{
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

}   // namespace

glm::vec3 studio_radiance(const glm::vec3& direction)
{
    glm::vec3 result = direction.y < 0 ? glm::mix(k_horizon, k_floor, smooth(0, k_floor_depth, -direction.y))
                                       : glm::mix(k_horizon, k_wall, smooth(0, k_wall_height, direction.y));
    for (const SoftBox& box : k_boxes) {
        const auto radians = [](float degrees) { return degrees * static_cast<float>(k_pi / 180); };
        const float a = radians(box.azimuth), e = radians(box.elevation);
        const glm::vec3 centre(std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e));
        const glm::vec3 right(std::cos(a), 0, -std::sin(a)), up = glm::cross(centre, right);
        const float ahead = glm::dot(direction, centre);
        if (ahead <= 0) continue;
        const float x = std::abs(glm::dot(direction, right)) / ahead, y = std::abs(glm::dot(direction, up)) / ahead;
        const float inside =
            (1 - smooth(box.width - k_edge, box.width, x)) * (1 - smooth(box.height - k_edge, box.height, y));
        // Brighter in the middle, as a light behind cloth is.
        const float middle =
            1 - 0.35f * std::min(1.0f, (x * x + y * y) / (box.width * box.width + box.height * box.height));
        result = glm::mix(result, box.radiance * middle, inside);
    }
    return result;
}

std::shared_ptr<const Environment> studio_environment()
{
    static const std::shared_ptr<const Environment> made = [] {
        ImageF image(k_width, k_height, 3);
        const DirectionGrid directions(k_width, k_height);
        for (int y = 0; y < k_height; ++y)
            for (int x = 0; x < k_width; ++x) {
                const glm::vec3 radiance = studio_radiance(directions.at(x, y));
                float* to = image.pixel(x, y);
                to[0] = radiance.x, to[1] = radiance.y, to[2] = radiance.z;
            }
        return std::make_shared<const Environment>(std::move(image));
    }();
    return made;
}

}   // namespace gnomon::scene
