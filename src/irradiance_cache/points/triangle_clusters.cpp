// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/triangle_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace gnomon::irradiance_cache {

namespace {

struct Cube {
    std::array<std::int64_t, 4> at;   // coordinates, and the axis that triangles face
    bool operator==(const Cube&) const = default;
};
struct CubeHash {
    std::size_t operator()(const Cube& cube) const
    {
        std::uint64_t h = 0;
        for (const std::int64_t v : cube.at)
            h = (h ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15ull, h ^= h >> 32;
        return h;
    }
};

}   // namespace

const std::vector<std::uint32_t>& TriangleClusters::representatives(scene::MeshId id, const scene::Mesh& mesh,
                                                                    int level)
{
    const std::lock_guard lock(mutex_);
    auto& made = made_[{id, level}];
    if (made) return *made;
    made = std::make_unique<std::vector<std::uint32_t>>(mesh.triangles.size());

    const double scale = std::ldexp(1.0, -level);
    struct Largest {
        std::uint32_t triangle;
        float area;
    };
    std::unordered_map<Cube, Largest, CubeHash> largest;
    std::vector<Cube> cube(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::uvec3 index = mesh.triangles[t];
        const glm::vec3 a = mesh.positions[index[0]], b = mesh.positions[index[1]], c = mesh.positions[index[2]];
        const glm::vec3 cross = glm::cross(b - a, c - a), size = glm::abs(cross);
        const glm::dvec3 centre = glm::dvec3(a + b + c) * (scale / 3);
        for (int axis = 0; axis < 3; ++axis)
            cube[t].at[static_cast<std::size_t>(axis)] =
                std::isfinite(centre[axis])
                    ? static_cast<std::int64_t>(std::floor(std::clamp(centre[axis], -1e15, 1e15)))
                    : 0;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        // Keep the two sides of a thin object apart.
        cube[t].at[3] = 2 * axis + (cross[axis] < 0 ? 1 : 0);
        const float area = glm::dot(cross, cross);
        const auto [at, fresh] = largest.try_emplace(cube[t], Largest{t, area});
        if (!fresh && area > at->second.area) at->second = {t, area};
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) (*made)[t] = largest.at(cube[t]).triangle;
    return *made;
}

std::size_t TriangleClusters::bytes() const
{
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (const auto& [key, made] : made_)
        if (made) sum += made->size() * sizeof(std::uint32_t);
    return sum;
}

}   // namespace gnomon::irradiance_cache
