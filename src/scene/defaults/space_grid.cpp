// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/space_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/interruption.h"

namespace gnomon::scene {

namespace {

constexpr float k_faces = 0.25f;   // least cosine at which a surface counts as facing an axis direction
constexpr int k_enclosure_directions = 40;

// Calls body for each node with a visible mesh, with its world matrix.
template <class Body>
void for_each_triangle(const Scene& scene, const std::vector<glm::dmat4>& world, const std::vector<char>& visible,
                       const Body& body)
{
    for (const Object& object : scene.objects) {
        interruption_point();
        if (!visible[object.node]) continue;
        const Mesh& mesh = scene.meshes[object.mesh];
        const glm::mat4 matrix(world[object.node]);
        const bool mirrored = glm::determinant(glm::mat3(matrix)) < 0;
        for (const glm::uvec3& t : mesh.triangles) {
            glm::vec3 a = transform_point(matrix, mesh.positions[t.x]),
                      b = transform_point(matrix, mesh.positions[t.y]);
            const glm::vec3 c = transform_point(matrix, mesh.positions[t.z]);
            if (mirrored) std::swap(a, b);
            body(a, b, c);
        }
    }
}

std::uint8_t facing_bits(const glm::vec3& normal)
{
    std::uint8_t bits = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (normal[axis] > k_faces) bits |= static_cast<std::uint8_t>(1u << (2 * axis));
        if (normal[axis] < -k_faces) bits |= static_cast<std::uint8_t>(2u << (2 * axis));
    }
    return bits;
}

// The length of a vector whose square may exceed the range of float.
float length_of(const glm::vec3& v)
{
    const float length = glm::length(v);
    if (std::isfinite(length)) return length;
    constexpr auto k_most = static_cast<double>(std::numeric_limits<float>::max());
    return static_cast<float>(std::min(glm::length(glm::dvec3(v)), k_most));
}

// The cross product of two edges of a triangle.
struct Cross {
    glm::vec3 direction{0};   // of unit length
    double length = 0;
};

Cross cross_of(const glm::vec3& u, const glm::vec3& v)
{
    const glm::vec3 cross = glm::cross(u, v);
    if (const float length = glm::length(cross); std::isfinite(length))
        return length > 0 ? Cross{cross / length, static_cast<double>(length)} : Cross{};
    // Edges of billions of units.
    const glm::dvec3 wide = glm::cross(glm::dvec3(u), glm::dvec3(v));
    const double length = glm::length(wide);
    return length > 0 && std::isfinite(length) ? Cross{glm::vec3(wide / length), length} : Cross{};
}

}   // namespace

glm::vec3 sphere_direction(int i, int count)
{
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z);
    const double angle = 2 * k_pi * i * (std::numbers::phi - 1);
    return {static_cast<float>(r * std::cos(angle)), static_cast<float>(z), static_cast<float>(r * std::sin(angle))};
}

SpaceGrid::SpaceGrid(const Scene& scene, double time, const Options& options) : box_(scene.bounds(time))
{
    const glm::vec3 extent = box_.size();
    const float longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0) || !std::isfinite(longest)) return;
    cell_ = longest / static_cast<float>(options.cells);
    for (int axis = 0; axis < 3; ++axis)
        size_[axis] = std::min(options.cells, static_cast<int>(extent[axis] / cell_)) + 1;
    facing_.assign(static_cast<std::size_t>(size_.x) * size_.y * size_.z, 0);
    triangles_.assign(facing_.size(), 0);

    std::vector<glm::dmat4> world(scene.nodes.size());
    std::vector<char> visible(scene.nodes.size());
    for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
        const Node& node = scene.nodes[n];
        const glm::dmat4 local = node.transform ? node.transform->evaluate(time) : node.local;
        world[n] = node.parent == none ? local : world[node.parent] * local;
        visible[n] =
            (node.parent == none || visible[node.parent]) && (!node.visibility || node.visibility->evaluate(time));
    }

    // Choose a sample spacing of half a cell, wider only where there would be too many samples.
    double area = 0;
    for_each_triangle(scene, world, visible, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
        area += 0.5 * cross_of(b - a, c - a).length;
    });
    const double spacing =
        std::max(0.5 * static_cast<double>(cell_), std::sqrt(2 * area / static_cast<double>(options.most_samples)));
    for_each_triangle(scene, world, visible, [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
        const Cross cross = cross_of(b - a, c - a);
        if (!(cross.length > 0)) return;
        const std::uint8_t bits = facing_bits(cross.direction);
        ++triangles_[index(cell_of((a + b + c) / 3.0f))];
        // Take a row of samples for each step along b - a; rows get shorter towards b.
        const int rows = 1 + static_cast<int>(length_of(b - a) / spacing);
        for (int i = 0; i < rows; ++i) {
            const float u = (static_cast<float>(i) + 1.0f / 3.0f) / static_cast<float>(rows);
            const int columns = 1 + static_cast<int>(length_of(c - a) * (1 - u) / spacing);
            for (int j = 0; j < columns; ++j) {
                const float v = (1 - u) * (static_cast<float>(j) + 0.5f) / static_cast<float>(columns);
                facing_[index(cell_of(a + u * (b - a) + v * (c - a)))] |= bits;
            }
        }
    });
}

glm::ivec3 SpaceGrid::cell_of(const glm::vec3& point) const
{
    const glm::vec3 p = (point - box_.low) / cell_;
    glm::ivec3 c;
    for (int axis = 0; axis < 3; ++axis)
        c[axis] = static_cast<int>(std::clamp(p[axis], 0.0f, static_cast<float>(size_[axis] - 1)));
    return c;
}

bool SpaceGrid::occupied(const glm::vec3& point) const
{
    return facing_[index(cell_of(point))] != 0;
}

SpaceGrid::Hit SpaceGrid::cast(const glm::vec3& origin, const glm::vec3& direction) const
{
    // March in steps of half a cell, which is exact enough here.
    const float step = 0.5f * cell_;
    float near = 0, far = k_infinity;
    for (int axis = 0; axis < 3; ++axis) {
        const float low = box_.low[axis] - 1e-3f * cell_, high = box_.high[axis] + 1e-3f * cell_;
        if (direction[axis] == 0) {
            if (origin[axis] < low || origin[axis] > high) return {};
            continue;
        }
        const float t0 = (low - origin[axis]) / direction[axis], t1 = (high - origin[axis]) / direction[axis];
        near = std::max(near, std::min(t0, t1));
        far = std::min(far, std::max(t0, t1));
    }
    if (!(near <= far)) return {};

    const bool starts_inside = near == 0;
    const glm::ivec3 start = cell_of(origin);
    const auto steps = static_cast<int>((far - near) / step) + 1;
    for (int i = 0; i <= steps; ++i) {
        const float t = std::min(near + step * static_cast<float>(i), far);
        const glm::ivec3 c = cell_of(origin + t * direction);
        if (starts_inside && c == start) continue;
        const std::uint8_t bits = facing_[index(c)];
        if (bits == 0) continue;
        for (int axis = 0; axis < 3; ++axis) {
            const unsigned against = direction[axis] > 0 ? 2u : 1u;
            if (std::abs(direction[axis]) > k_faces && (bits & (against << (2 * axis))))
                return {Met::front, t, triangles_[index(c)]};
        }
        return {Met::back, t, triangles_[index(c)]};
    }
    return {Met::nothing, far, 0};
}

float SpaceGrid::enclosure(const glm::vec3& point) const
{
    int fronts = 0;
    for (int i = 0; i < k_enclosure_directions; ++i)
        fronts += cast(point, sphere_direction(i, k_enclosure_directions)).met == Met::front;
    return static_cast<float>(fronts) / k_enclosure_directions;
}

}   // namespace gnomon::scene
