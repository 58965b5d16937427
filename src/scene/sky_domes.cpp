// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>

#include "base/interruption.h"
#include "scene/file_surfaces.h"

namespace gnomon::scene {

namespace {

constexpr float k_flat = 0.02f;                // of the width of a floor: its height, at most
constexpr float k_wide = 0.5f;                 // of a dome's diagonal: that of a floor which shows that it is one
constexpr float k_room = 0.02f;                // of a dome's diagonal: how far a floor may reach beyond it
constexpr float k_round = 0.05f;               // of a dome's radius: how far its vertices may be from a sphere
constexpr std::size_t k_least_vertices = 24;   // of a round dome; a box has its corners on a sphere

// The positions that triangles use.
std::vector<glm::vec3> used_positions(const Mesh& mesh, const glm::dmat4& world)
{
    std::vector<char> used(mesh.positions.size());
    for (const glm::uvec3& t : mesh.triangles)
        for (int c = 0; c < 3; ++c) used[t[c]] = 1;
    std::vector<glm::vec3> result;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v])
            if (const glm::vec3 p(transform_point(world, glm::dvec3(mesh.positions[v]))); is_finite(p))
                result.push_back(p);
    return result;
}

Box3 box_of(const std::vector<glm::vec3>& points)
{
    Box3 box;
    for (const glm::vec3& p : points) box.add(p);
    return box;
}

bool lie_on_sphere(const std::vector<glm::vec3>& points, const glm::vec3& centre)
{
    float least = k_infinity, most = 0;
    for (const glm::vec3& p : points) {
        const float distance = glm::distance(p, centre);
        least = std::min(least, distance), most = std::max(most, distance);
    }
    return least >= (1 - k_round) * most;
}

// Whether points lie on a sphere or its upper half, and not on a few corners of it.
bool are_round(const std::vector<glm::vec3>& points, const Box3& box)
{
    std::vector<glm::vec3> sorted = points;
    const auto key = [](const glm::vec3& p) { return std::array{p.x, p.y, p.z}; };
    std::ranges::sort(sorted, {}, key);
    const auto last = std::unique(sorted.begin(), sorted.end());
    if (static_cast<std::size_t>(last - sorted.begin()) < k_least_vertices) return false;
    const glm::vec3 centre = box.centre();
    return lie_on_sphere(points, centre) || lie_on_sphere(points, {centre.x, box.low.y, centre.z});
}

}   // namespace

bool is_floor_of_dome(const Box3& box, const Box3& dome)
{
    const glm::vec3 size = box.size(), room(k_room * dome.diagonal());
    return size.y <= k_flat * std::max(size.x, size.z) && glm::all(glm::greaterThanEqual(box.low, dome.low - room)) &&
           glm::all(glm::lessThanEqual(box.high, dome.high + room));
}

std::size_t find_sky_domes(Scene& scene)
{
    // Find what may be a dome: what is unlit, and what is opaque and round.
    struct Candidate {
        NodeId node;
        Box3 box;
        bool unlit;
    };
    const std::vector<glm::dmat4> world = scene.world_matrices(scene.timeline.start);
    std::vector<Candidate> candidates;
    std::vector<Box3> others;
    for (NodeId n = 0; n < scene.nodes.size(); ++n) {
        if (scene.nodes[n].mesh == none) continue;
        interruption_point();
        const Mesh& mesh = scene.meshes[scene.nodes[n].mesh];
        const std::vector<glm::vec3> points = used_positions(mesh, world[n]);
        const Box3 box = box_of(points);
        if (box.empty()) continue;
        bool unlit = true, opaque = true, shines = false;
        for (const MeshPart& part : mesh.parts) {
            const Material& material = scene.materials[part.material];
            unlit = unlit && material.model == ShadingModel::unlit;
            opaque = opaque && material.alpha_mode == AlphaMode::opaque && material.transmission == 0 &&
                     material.transmittance == 0;
            shines = shines || material.emissive != glm::vec3(0);
        }
        const bool plain = !mesh.parts.empty() && !mesh.skin && opaque;
        if (plain && (unlit || (!shines && are_round(points, box))))
            candidates.push_back({n, box, unlit});
        else
            others.push_back(box);
    }
    if (candidates.empty()) return 0;

    // Those that are not far larger than the others belong to the rest. A floor as wide as a dome does not count.
    std::ranges::sort(candidates, {}, [](const Candidate& c) { return std::pair(c.box.diagonal(), c.node); });
    std::size_t found = 0;
    std::map<MaterialId, MaterialId> copies;
    for (const Candidate& dome : candidates) {
        Box3 rest;
        bool has_floor = false;
        for (const Box3& box : others) {
            if (is_floor_of_dome(box, dome.box))
                has_floor = has_floor || box.diagonal() > k_wide * dome.box.diagonal();
            else
                rest.add(box.low), rest.add(box.high);
        }
        // A ball without a floor hides what is in it.
        const glm::vec3 room(k_room * dome.box.diagonal());
        const bool around =
            !rest.empty() && (dome.unlit || has_floor) && glm::all(glm::lessThanEqual(dome.box.low - room, rest.low)) &&
            glm::all(glm::greaterThan(dome.box.high, rest.high)) && dome.box.diagonal() > k_dome * rest.diagonal();
        if (!around) {
            if (found == 0) others.push_back(dome.box);
            continue;
        }
        ++found;
        Mesh& mesh = scene.meshes.edit(scene.nodes[dome.node].mesh);
        for (MeshPart& part : mesh.parts) {
            if (scene.materials[part.material].outline) continue;
            const auto [known, fresh] =
                copies.try_emplace(part.material, static_cast<MaterialId>(scene.materials.size()));
            if (fresh) {
                Material copy = scene.materials[part.material];
                copy.outline = true;
                scene.materials.push_back(std::move(copy));
            }
            part.material = known->second;
        }
    }
    return found;
}

}   // namespace gnomon::scene
