// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "base/hash.h"
#include "base/interruption.h"
#include "scene/file_surfaces.h"

namespace gnomon::scene {

namespace {

struct PositionHash {
    std::size_t operator()(const glm::vec3& p) const { return static_cast<std::size_t>(hash_bytes(&p, sizeof p, 0)); }
};

// Triangles in world space.
struct Soup {
    std::vector<std::array<glm::vec3, 3>> triangles;
    Box3 box;
};

float distance2_to_segment(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b)
{
    const glm::vec3 e = b - a;
    const float square = glm::dot(e, e);
    const float t = square > 0 ? std::clamp(glm::dot(p - a, e) / square, 0.0f, 1.0f) : 0;
    const glm::vec3 d = p - (a + t * e);
    return glm::dot(d, d);
}

float distance2(const glm::vec3& p, const std::array<glm::vec3, 3>& t)
{
    const glm::vec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    const float square = glm::dot(n, n);
    if (square > 0) {
        bool inside = true;
        for (std::size_t i = 0; i < 3 && inside; ++i)
            inside = glm::dot(glm::cross(t[(i + 1) % 3] - t[i], p - t[i]), n) >= 0;
        const float above = glm::dot(p - t[0], n);
        if (inside) return above * above / square;
    }
    return std::min({distance2_to_segment(p, t[0], t[1]), distance2_to_segment(p, t[1], t[2]),
                     distance2_to_segment(p, t[2], t[0])});
}

// Whether a part is closed, with every edge between two triangles that agree on their sides, and each of its connected
// pieces looks inwards. Vertices at the same place are one. A mirroring transform does not swap inside and outside.
bool looks_inwards(const Mesh& mesh, const MeshPart& part)
{
    std::unordered_map<glm::vec3, std::uint32_t, PositionHash> numbers;
    std::vector<glm::uvec3> triangles;
    triangles.reserve(part.triangle_count);
    std::vector<glm::vec3> positions;
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
        glm::uvec3 welded;
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 p = mesh.positions[mesh.triangles[t][i]] + glm::vec3(0);   // -0 becomes 0
            const auto [known, fresh] = numbers.try_emplace(p, static_cast<std::uint32_t>(positions.size()));
            if (fresh) positions.push_back(p);
            welded[i] = known->second;
        }
        if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0]) triangles.push_back(welded);
    }
    if (triangles.size() < 4) return false;

    // Count each edge's directions: +1 and -1 cancel out.
    std::unordered_map<std::uint64_t, std::pair<int, int>> edges;   // by vertices: passes, their sum
    std::vector<std::uint32_t> piece(positions.size());
    for (std::uint32_t i = 0; i < piece.size(); ++i) piece[i] = i;
    const auto root = [&](std::uint32_t i) {
        while (piece[i] != i) i = piece[i] = piece[piece[i]];
        return i;
    };
    for (const glm::uvec3& t : triangles)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = t[i], b = t[(i + 1) % 3];
            auto& [passes, sum] = edges[static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b)];
            ++passes, sum += a < b ? 1 : -1;
            piece[root(a)] = root(b);
        }
    if (std::any_of(edges.begin(), edges.end(), [](const auto& e) { return e.second != std::pair(2, 0); }))
        return false;

    // Sum the signed volume of each piece, from a vertex of its own.
    std::map<std::uint32_t, double> volume;
    for (const glm::uvec3& t : triangles) {
        const std::uint32_t of = root(t[0]);
        const glm::dvec3 origin(positions[of]);
        volume[of] += glm::dot(glm::dvec3(positions[t[0]]) - origin,
                               glm::cross(glm::dvec3(positions[t[1]]) - origin, glm::dvec3(positions[t[2]]) - origin));
    }
    return std::all_of(volume.begin(), volume.end(), [](const auto& v) { return v.second < 0; });
}

}   // namespace

std::size_t find_outlines(Scene& scene, const OutlineOptions& options)
{
    // Find the parts that may be shells, where they are placed first.
    struct Shell {
        NodeId node;
        std::size_t part;
    };
    std::vector<Shell> shells;
    std::map<MeshId, bool> seen;
    std::size_t triangles = 0;
    std::vector<glm::dmat4> world;
    for (NodeId n = 0; n < scene.nodes.size(); ++n) {
        const MeshId m = scene.nodes[n].mesh;
        if (m == none) continue;
        triangles += scene.meshes[m].triangles.size();
        if (std::exchange(seen[m], true)) continue;
        const Mesh& mesh = scene.meshes[m];
        for (std::size_t i = 0; i < mesh.parts.size(); ++i) {
            const Material& material = scene.materials[mesh.parts[i].material];
            if (material.double_sided || material.transmission > 0 || material.transmittance > 0 || material.outline)
                continue;
            if (world.empty()) world = scene.world_matrices(scene.timeline.start);
            interruption_point();
            if (looks_inwards(mesh, mesh.parts[i])) shells.push_back({n, i});
        }
    }
    if (shells.empty() || triangles > options.most_triangles) return 0;

    // Place everything.
    std::map<std::pair<NodeId, std::size_t>, Soup> soups;
    for (NodeId n = 0; n < scene.nodes.size(); ++n) {
        if (scene.nodes[n].mesh == none) continue;
        const Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
        for (std::size_t i = 0; i < mesh.parts.size(); ++i) {
            Soup& soup = soups[{n, i}];
            const MeshPart& part = mesh.parts[i];
            soup.triangles.reserve(part.triangle_count);
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                auto& corners = soup.triangles.emplace_back();
                for (int c = 0; c < 3; ++c) {
                    corners[static_cast<std::size_t>(c)] =
                        glm::vec3(transform_point(world[n], glm::dvec3(mesh.positions[mesh.triangles[t][c]])));
                    soup.box.add(corners[static_cast<std::size_t>(c)]);
                }
            }
        }
    }
    const auto is_shell = [&](const std::pair<NodeId, std::size_t>& place) {
        return std::any_of(shells.begin(), shells.end(), [&](const Shell& s) {
            return scene.nodes[s.node].mesh == scene.nodes[place.first].mesh && s.part == place.second;
        });
    };

    // Keep the shells that have another surface near every place of theirs.
    std::size_t found = 0;
    std::map<MaterialId, MaterialId> copies;
    for (const Shell& shell : shells) {
        const Soup& own = soups.at({shell.node, shell.part});
        const float reach = options.reach * glm::length(own.box.high - own.box.low);
        if (!(reach > 0) || !std::isfinite(reach)) continue;
        std::vector<const Soup*> others;
        for (const auto& [place, soup] : soups) {
            const bool apart = glm::any(glm::greaterThan(soup.box.low, own.box.high + reach)) ||
                               glm::any(glm::lessThan(soup.box.high, own.box.low - reach));
            if (!apart && !soup.triangles.empty() && !is_shell(place)) others.push_back(&soup);
        }
        const std::size_t step = std::max<std::size_t>(1, own.triangles.size() / options.samples);
        bool follows = !others.empty();
        for (std::size_t t = 0; t < own.triangles.size() && follows; t += step) {
            interruption_point();
            const glm::vec3 middle = (own.triangles[t][0] + own.triangles[t][1] + own.triangles[t][2]) / 3.0f;
            for (const glm::vec3& place : {own.triangles[t][0], middle}) {
                follows = std::any_of(others.begin(), others.end(), [&](const Soup* soup) {
                    return std::any_of(soup->triangles.begin(), soup->triangles.end(),
                                       [&](const auto& other) { return distance2(place, other) <= reach * reach; });
                });
                if (!follows) break;
            }
        }
        if (!follows) continue;

        Mesh& mesh = scene.meshes.edit(scene.nodes[shell.node].mesh);
        MaterialId& material = mesh.parts[shell.part].material;
        const auto [known, fresh] = copies.try_emplace(material, static_cast<MaterialId>(scene.materials.size()));
        if (fresh) {
            Material copy = scene.materials[material];
            copy.outline = true;
            scene.materials.push_back(std::move(copy));
        }
        material = known->second;
        ++found;
    }
    return found;
}

}   // namespace gnomon::scene
