// SPDX-License-Identifier: Apache-2.0
#include "api/area_light_shape.h"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "api/convert.h"
#include "gnomon/error.h"

namespace gnomon::api {

namespace {

constexpr std::uint32_t k_corners = 32;   // of a disc

void require_size(float size, const std::string& owner, const char* what)
{
    constexpr float k_least = 1e-6f, k_most = 1e6f;
    if (!(size >= k_least && size <= k_most))
        throw UsageError(fmt::format("{}: the {} is {}: expected {} to {} m", owner, what, size, k_least, k_most));
}

LightShape rectangle(float width, float height)
{
    const float x = 0.5f * width, y = 0.5f * height;
    return {{{-x, -y, 0}, {-x, y, 0}, {x, y, 0}, {x, -y, 0}}, {}, {0, 1, 2, 0, 2, 3}};
}

LightShape disc(double radius)
{
    // Give the polygon the area of the circle.
    const double turn = 2 * k_pi / k_corners;
    const double out = radius * std::sqrt(turn / std::sin(turn));
    LightShape shape;
    for (std::uint32_t k = 0; k < k_corners; ++k)
        shape.positions.push_back(
            {static_cast<float>(out * std::cos(k * turn)), static_cast<float>(-out * std::sin(k * turn)), 0});
    for (std::uint32_t k = 1; k + 1 < k_corners; ++k) shape.indices.insert(shape.indices.end(), {0, k, k + 1});
    return shape;
}

// An icosahedron whose triangles are divided into sixteen.
LightShape sphere(double radius)
{
    const double golden = 0.5 * (1 + std::sqrt(5.0));
    std::vector<glm::dvec3> corners;
    for (const double one : {-1.0, 1.0})
        for (const double other : {-golden, golden})
            for (int axis = 0; axis < 3; ++axis) {
                glm::dvec3 corner(0);
                corner[axis] = one, corner[(axis + 1) % 3] = other;
                corners.push_back(glm::normalize(corner));
            }
    // Its faces are the triples of corners that are next to each other.
    std::vector<glm::uvec3> faces;
    const auto near = [&](std::uint32_t a, std::uint32_t b) { return glm::dot(corners[a], corners[b]) > 0.4; };
    for (std::uint32_t a = 0; a < 12; ++a)
        for (std::uint32_t b = a + 1; b < 12; ++b)
            for (std::uint32_t c = b + 1; c < 12; ++c) {
                if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
                const bool out = glm::dot(glm::cross(corners[b] - corners[a], corners[c] - corners[a]), corners[a]) > 0;
                faces.push_back(out ? glm::uvec3(a, b, c) : glm::uvec3(a, c, b));
            }
    for (int level = 0; level < 2; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [at, made] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(corners.size()));
            if (made) corners.push_back(glm::normalize(corners[a] + corners[b]));
            return at->second;
        };
        std::vector<glm::uvec3> finer;
        for (const glm::uvec3& f : faces) {
            const std::uint32_t ab = middle(f.x, f.y), bc = middle(f.y, f.z), ca = middle(f.z, f.x);
            finer.insert(finer.end(), {{f.x, ab, ca}, {f.y, bc, ab}, {f.z, ca, bc}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    // Give the mesh the area of the sphere.
    double area = 0;
    for (const glm::uvec3& f : faces)
        area += 0.5 * glm::length(glm::cross(corners[f.y] - corners[f.x], corners[f.z] - corners[f.x]));
    const double out = radius * std::sqrt(4 * k_pi / area);
    LightShape shape;
    for (const glm::dvec3& corner : corners) {
        shape.positions.push_back(vec(glm::vec3(out * corner)));
        shape.normals.push_back(vec(glm::vec3(corner)));
    }
    for (const glm::uvec3& f : faces) shape.indices.insert(shape.indices.end(), {f.x, f.y, f.z});
    return shape;
}

}   // namespace

LightShape shape_of(const AreaLight& light)
{
    const std::string owner = titled("area light", light.name);
    require_known(light.shape, AreaLightShape::sphere, owner, "the shape");
    if (light.shape == AreaLightShape::rectangle) {
        require_size(light.width, owner, "width");
        require_size(light.height, owner, "height");
        return rectangle(light.width, light.height);
    }
    require_size(light.width, owner, "diameter");
    const double radius = 0.5 * static_cast<double>(light.width);
    return light.shape == AreaLightShape::disc ? disc(radius) : sphere(radius);
}

}   // namespace gnomon::api
