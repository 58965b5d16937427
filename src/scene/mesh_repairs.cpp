// SPDX-License-Identifier: Apache-2.0
#include "scene/mesh_repairs.h"

#include <algorithm>
#include <cmath>

namespace gnomon::scene {

namespace {
constexpr float k_usual_weight = 2;   // a weight that is greater is scaled down before weights are summed
}

glm::vec3 unit_or(const glm::vec3& v, const glm::vec3& otherwise)
{
    const float single = glm::length(v);
    if (single > k_least_direction && std::isfinite(single)) return v / single;
    // The square of a long vector overflows in single precision.
    const double length = glm::length(glm::dvec3(v));
    return length > k_least_direction ? glm::vec3(glm::dvec3(v) / length) : otherwise;
}

glm::vec3 perpendicular_to(const glm::vec3& normal)
{
    const glm::vec3 axis = std::abs(normal.x) < std::abs(normal.y) ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    return unit_or(glm::cross(axis, normal), glm::vec3(1, 0, 0));
}

void fill_normals(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                  std::span<glm::vec3> normals)
{
    const auto missing = [&](std::uint32_t v) { return normals[v] == glm::vec3(0); };
    if (normals.size() != positions.size()) return;
    std::vector<glm::dvec3> sums;
    for (const glm::uvec3& t : triangles) {
        if (!missing(t.x) && !missing(t.y) && !missing(t.z)) continue;
        sums.resize(normals.size());
        const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
        for (int k = 0; k < 3; ++k) sums[t[k]] += glm::cross(b - a, c - a);
    }
    for (std::uint32_t v = 0; v < normals.size(); ++v) {
        if (!missing(v)) continue;
        const double length = sums.empty() ? 0 : glm::length(sums[v]);
        normals[v] = length > 0 && std::isfinite(length) ? glm::vec3(sums[v] / length) : glm::vec3(0, 0, 1);
    }
}

std::size_t normalize_weights(std::span<std::vector<glm::vec4>> weights, float tolerance)
{
    std::size_t changed = 0;
    const std::size_t vertices = weights.empty() ? 0 : weights[0].size();
    for (std::size_t v = 0; v < vertices; ++v) {
        // Divide the largest weight out first, because the sum may overflow.
        float largest = 0;
        for (const std::vector<glm::vec4>& set : weights)
            for (int k = 0; k < 4 && !set.empty(); ++k) largest = std::max(largest, set[v][k]);
        const float unit = largest > k_usual_weight ? largest : 1;
        float sum = 0;
        for (const std::vector<glm::vec4>& set : weights) {
            if (set.empty()) continue;
            const glm::vec4 w = set[v] / unit;
            sum += w.x + w.y + w.z + w.w;
        }
        if (unit == 1 && std::abs(sum - 1) <= tolerance) continue;
        ++changed;
        for (std::vector<glm::vec4>& set : weights)
            if (!set.empty() && sum > 0) set[v] = set[v] / unit / sum;
        if (!(sum > 0)) weights[0][v] = {1, 0, 0, 0};
    }
    return changed;
}

}   // namespace gnomon::scene
