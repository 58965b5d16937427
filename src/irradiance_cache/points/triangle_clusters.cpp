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

// The coordinates of a place in units of a cube, and of that cube.
std::array<std::int64_t, 3> cube_at(const glm::dvec3& place)
{
    std::array<std::int64_t, 3> at{};
    for (int axis = 0; axis < 3; ++axis)
        if (std::isfinite(place[axis]))
            at[static_cast<std::size_t>(axis)] =
                static_cast<std::int64_t>(std::floor(std::clamp(place[axis], -1e15, 1e15)));
    return at;
}

// A triangle that represents others, in units of a cube.
struct Representative {
    std::uint32_t triangle;
    glm::vec3 centre, normal;   // the normal is the mean of the vertices'
    float area;                 // of all triangles that it represents
};

}   // namespace

// The representatives, in their cubes.
class ClusterBlends::Cubes {
 public:
    Cubes(const scene::Mesh& mesh, double scale, const std::vector<std::uint32_t>& representatives) : scale_(scale)
    {
        std::vector<float> area(representatives.size(), 0.0f);
        for (std::uint32_t t = 0; t < representatives.size(); ++t) {
            const glm::uvec3 index = mesh.triangles[t];
            const glm::dvec3 a = at(mesh, index[0]), b = at(mesh, index[1]), c = at(mesh, index[2]);
            area[representatives[t]] += static_cast<float>(glm::length(glm::cross(b - a, c - a)));
        }
        for (std::uint32_t t = 0; t < representatives.size(); ++t) {
            if (representatives[t] != t) continue;
            const glm::uvec3 index = mesh.triangles[t];
            const glm::dvec3 a = at(mesh, index[0]), b = at(mesh, index[1]), c = at(mesh, index[2]);
            const glm::vec3 cross(glm::cross(b - a, c - a));
            const float length = glm::length(cross);
            const auto longest = static_cast<float>(std::max(glm::dot(b - a, b - a), glm::dot(c - a, c - a)));
            const glm::vec3 normal = mesh.normals[index[0]] + mesh.normals[index[1]] + mesh.normals[index[2]];
            if (!(length > k_degenerate * longest) || !std::isfinite(length) || !(glm::dot(normal, normal) > 0))
                continue;
            const glm::dvec3 centre = (a + b + c) / 3.0;
            in_cube_[{with_zero(cube_at(centre))}].push_back({t, glm::vec3(centre), glm::normalize(normal), area[t]});
        }
    }

    // Blends those in the cube of a vertex and in the cubes that touch it.
    Blend at_vertex(const scene::Mesh& mesh, std::uint32_t vertex) const
    {
        const glm::dvec3 place = at(mesh, vertex);
        const glm::vec3 p(place), n = mesh.normals[vertex];
        const std::array<std::int64_t, 3> own = cube_at(place);
        Blend blend;
        int count = 0;
        for (std::int64_t x = own[0] - 1; x <= own[0] + 1; ++x)
            for (std::int64_t y = own[1] - 1; y <= own[1] + 1; ++y)
                for (std::int64_t z = own[2] - 1; z <= own[2] + 1; ++z)
                    if (const auto in = in_cube_.find({{x, y, z, 0}}); in != in_cube_.end())
                        for (const Representative& r : in->second) add(blend, count, r.triangle, weight_of(r, p, n));
        const float sum = (blend.weight[0] + blend.weight[1]) + (blend.weight[2] + blend.weight[3]);
        if (sum > 0)
            for (float& weight : blend.weight) weight /= sum;
        return blend;
    }

 private:
    static constexpr int k_most = 4;
    static constexpr float k_reach = 1.5f, k_height = 0.5f;           // cubes
    static constexpr float k_facing = 0.85f, k_faces_alike = 0.97f;   // cosines
    static constexpr float k_degenerate = 1e-5f;   // height, in lengths: such a triangle has no normal

    static float weight_of(const Representative& r, const glm::vec3& p, const glm::vec3& n)
    {
        const glm::vec3 d = r.centre - p;
        const float near = 1 - glm::dot(d, d) / (k_reach * k_reach);
        const float facing = (glm::dot(r.normal, n) - k_facing) / (k_faces_alike - k_facing);
        const float height = glm::dot(d, n) / k_height, low = 1 - height * height;
        return near > 0 && facing > 0 && low > 0 ? r.area * near * near * std::min(facing, 1.0f) * low : 0.0f;
    }
    static std::array<std::int64_t, 4> with_zero(const std::array<std::int64_t, 3>& at)
    {
        return {at[0], at[1], at[2], 0};
    }
    glm::dvec3 at(const scene::Mesh& mesh, std::uint32_t vertex) const
    {
        return glm::dvec3(mesh.positions[vertex]) * scale_;
    }

    // Keeps the four largest weights, in falling order.
    static void add(Blend& blend, int& count, std::uint32_t triangle, float weight)
    {
        if (!(weight > 0)) return;
        int i = std::min(count, k_most - 1);
        if (count == k_most && !(weight > blend.weight[i])) return;
        for (; i > 0 && weight > blend.weight[i - 1]; --i)
            blend.weight[i] = blend.weight[i - 1], blend.triangle[i] = blend.triangle[i - 1];
        blend.weight[i] = weight, blend.triangle[i] = triangle;
        count = std::min(count + 1, k_most);
    }

    double scale_;
    std::unordered_map<Cube, std::vector<Representative>, CubeHash> in_cube_;
};

ClusterBlends::ClusterBlends(const scene::Mesh& mesh, int level, const std::vector<std::uint32_t>& representatives)
    : cubes_(std::make_unique<Cubes>(mesh, std::ldexp(1.0, -level), representatives)),
      apart_(mesh.triangles.size()),
      blends_(mesh.positions.size()),
      states_(mesh.positions.size())
{
    // Find which side of the triangles the vertex normals are on.
    std::size_t behind = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const glm::uvec3 index = mesh.triangles[t];
        const glm::vec3 a = mesh.positions[index[0]], b = mesh.positions[index[1]], c = mesh.positions[index[2]];
        const glm::vec3 n = mesh.normals[index[0]] + mesh.normals[index[1]] + mesh.normals[index[2]];
        apart_[t] = glm::dot(glm::cross(b - a, c - a), n) < 0;
        behind += apart_[t] ? 1 : 0;
    }
    if (2 * behind > mesh.triangles.size()) apart_.flip();
}

ClusterBlends::~ClusterBlends() = default;

ClusterBlends::Blend ClusterBlends::of_vertex(const scene::Mesh& mesh, std::uint32_t vertex) const
{
    std::atomic<std::uint8_t>& state = states_[vertex];
    if (state.load(std::memory_order_acquire) == made) return blends_[vertex];
    const Blend blend = cubes_->at_vertex(mesh, vertex);
    // One of those who made it keeps it.
    std::uint8_t expected = unknown;
    if (state.compare_exchange_strong(expected, being_made, std::memory_order_relaxed)) {
        blends_[vertex] = blend;
        state.store(made, std::memory_order_release);
    }
    return blend;
}

std::size_t ClusterBlends::bytes() const
{
    return blends_.size() * (sizeof(Blend) + 1) + apart_.size() / 8;
}

const std::vector<std::uint32_t>& TriangleClusters::representatives(scene::MeshId id, const scene::Mesh& mesh,
                                                                    int level)
{
    const std::lock_guard lock(mutex_);
    return representatives_locked(id, mesh, level);
}

const std::vector<std::uint32_t>& TriangleClusters::representatives_locked(scene::MeshId id, const scene::Mesh& mesh,
                                                                           int level)
{
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
        const std::array<std::int64_t, 3> at = cube_at(glm::dvec3(a + b + c) * (scale / 3));
        std::copy(at.begin(), at.end(), cube[t].at.begin());
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        // Keep the two sides of a thin object apart.
        cube[t].at[3] = 2 * axis + (cross[axis] < 0 ? 1 : 0);
        const float area = glm::dot(cross, cross);
        const auto [found, fresh] = largest.try_emplace(cube[t], Largest{t, area});
        if (!fresh && area > found->second.area) found->second = {t, area};
    }
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) (*made)[t] = largest.at(cube[t]).triangle;
    return *made;
}

const ClusterBlends& TriangleClusters::blends(scene::MeshId id, const scene::Mesh& mesh, int level)
{
    const std::lock_guard lock(mutex_);
    auto& made = blends_[{id, level}];
    if (!made) made = std::make_unique<ClusterBlends>(mesh, level, representatives_locked(id, mesh, level));
    return *made;
}

std::size_t TriangleClusters::bytes() const
{
    const std::lock_guard lock(mutex_);
    std::size_t sum = 0;
    for (const auto& [key, made] : made_)
        if (made) sum += made->size() * sizeof(std::uint32_t);
    for (const auto& [key, made] : blends_)
        if (made) sum += made->bytes();
    return sum;
}

}   // namespace gnomon::irradiance_cache
