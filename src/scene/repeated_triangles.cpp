// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "base/hash.h"
#include "base/interruption.h"
#include "scene/file_surfaces.h"

namespace gnomon::scene {

namespace {

// What triangles in one place have in common: the positions of their corners in order, from the least one on.
using Place = std::array<std::array<float, 3>, 3>;

std::optional<Place> place_of(const Mesh& mesh, const glm::uvec3& triangle)
{
    Place place;
    for (int c = 0; c < 3; ++c) {
        const glm::vec3& p = mesh.positions[triangle[c]];
        place[static_cast<std::size_t>(c)] = {p.x, p.y, p.z};
    }
    // A triangle without area costs no more than itself.
    if (place[0] == place[1] || place[1] == place[2] || place[2] == place[0]) return std::nullopt;
    std::rotate(place.begin(), std::min_element(place.begin(), place.end()), place.end());
    return place;
}

// Whether so many triangles have one hash that some place may have too many.
bool may_repeat(const Mesh& mesh)
{
    if (mesh.triangles.size() <= k_most_in_place) return false;
    std::vector<std::uint64_t> hashes;
    hashes.reserve(mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles)
        if (const auto place = place_of(mesh, t)) hashes.push_back(hash_bytes(place->data(), sizeof *place));
    std::sort(hashes.begin(), hashes.end());
    for (std::size_t i = k_most_in_place; i < hashes.size(); ++i)
        if (hashes[i] == hashes[i - k_most_in_place]) return true;
    return false;
}

}   // namespace

std::size_t leave_out_repeats(Scene& scene)
{
    std::size_t left_out = 0;
    for (MeshId id = 0; id < scene.meshes.size(); ++id) {
        if (scene.meshes[id].deforms()) continue;
        interruption_point();
        if (!may_repeat(scene.meshes[id])) continue;
        Mesh& mesh = scene.meshes.edit(id);
        std::map<Place, std::size_t> count;
        std::vector<glm::uvec3> kept;
        for (MeshPart& part : mesh.parts) {
            const auto first = static_cast<std::uint32_t>(kept.size());
            for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
                const auto place = place_of(mesh, mesh.triangles[t]);
                if (place && ++count[*place] > k_most_in_place) continue;
                kept.push_back(mesh.triangles[t]);
            }
            part.first_triangle = first, part.triangle_count = static_cast<std::uint32_t>(kept.size()) - first;
        }
        left_out += mesh.triangles.size() - kept.size();
        mesh.triangles = std::move(kept);
    }
    if (left_out > 0)
        scene.warnings.push_back(fmt::format("{} triangle{} where {} equal ones are already: left out", left_out,
                                             left_out == 1 ? "" : "s", k_most_in_place));
    return left_out;
}

}   // namespace gnomon::scene
