// SPDX-License-Identifier: Apache-2.0
#include "scene/defaults/emissive_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "base/check.h"
#include "scene/defaults/interior.h"
#include "scene/defaults/space_grid.h"
#include "scene/emission.h"
#include "scene/emission_cone.h"
#include "scene/material_layers.h"

namespace gnomon::scene {

namespace {

constexpr int k_grid = 4;   // lights along each side of a rectangle, where there are enough

float area_of(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c)
{
    return 0.5f * glm::length(glm::cross(b - a, c - a));
}

bool inside(const glm::vec2& p, const glm::vec2& a, const glm::vec2& b, const glm::vec2& c)
{
    const auto turn = [](const glm::vec2& s, const glm::vec2& t, const glm::vec2& u) {
        return (t.x - s.x) * (u.y - s.y) - (t.y - s.y) * (u.x - s.x);
    };
    const float x = turn(a, b, p), y = turn(b, c, p), z = turn(c, a, p);
    return (x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0);
}

// Spreads points over a patch: the centres of a grid along its longest edge if the patch fills them (a rectangle does),
// else points of a low-discrepancy sequence [Roberts 2018], distributed over triangles in proportion to area.
std::vector<glm::vec3> spread(const EmitterPatch& patch, int count)
{
    const std::vector<glm::vec3>& t = patch.triangles;
    // The legs of a rectangle's triangle are its second and third longest edges: align with the second.
    glm::vec3 edges[3] = {t[1] - t[0], t[2] - t[1], t[0] - t[2]};
    std::sort(edges, edges + 3, [](const auto& a, const auto& b) { return glm::dot(a, a) > glm::dot(b, b); });
    glm::vec3 along = edges[1] - glm::dot(edges[1], patch.normal) * patch.normal;
    glm::vec3 other;
    if (glm::dot(along, along) > 0)
        along = glm::normalize(along), other = glm::cross(patch.normal, along);
    else
        make_basis(patch.normal, along, other);
    // Project the triangles into the patch's plane.
    std::vector<glm::vec2> flat;
    glm::vec2 low(k_infinity), high(-k_infinity);
    float height = 0;
    for (const glm::vec3& p : t) {
        flat.emplace_back(glm::dot(p, along), glm::dot(p, other));
        low = glm::min(low, flat.back()), high = glm::max(high, flat.back());
        height += glm::dot(p, patch.normal) / static_cast<float>(t.size());
    }

    // Keep the grid points that lie in a triangle.
    std::vector<glm::vec3> points;
    const int side = std::min(k_grid, static_cast<int>(std::sqrt(static_cast<float>(count) + 0.5f)));
    for (int i = 0; i < side * side; ++i) {
        const int column = i % side, row = i / side;
        const glm::vec2 place((static_cast<float>(column) + 0.5f) / static_cast<float>(side),
                              (static_cast<float>(row) + 0.5f) / static_cast<float>(side));
        const glm::vec2 p = low + place * (high - low);
        for (std::size_t k = 0; k < flat.size(); k += 3) {
            if (!inside(p, flat[k], flat[k + 1], flat[k + 2])) continue;
            points.push_back(p.x * along + p.y * other + height * patch.normal);
            break;
        }
    }
    if (points.size() == static_cast<std::size_t>(side) * side) return points;

    points.clear();
    std::vector<float> sums;
    for (std::size_t k = 0; k < t.size(); k += 3)
        sums.push_back((sums.empty() ? 0 : sums.back()) + area_of(t[k], t[k + 1], t[k + 2]));
    for (int i = 0; i < count; ++i) {
        const float pick = sums.back() * (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
        const auto at = std::min<std::size_t>(
            static_cast<std::size_t>(std::lower_bound(sums.begin(), sums.end(), pick) - sums.begin()), sums.size() - 1);
        double u = 0.5 + 0.7548776662466927 * i, v = 0.5 + 0.5698402909980532 * i;
        u -= std::floor(u), v -= std::floor(v);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const glm::vec3 &a = t[3 * at], &b = t[3 * at + 1], &c = t[3 * at + 2];
        points.push_back(a + static_cast<float>(u) * (b - a) + static_cast<float>(v) * (c - a));
    }
    return points;
}

// Collects connected pieces of one object's emissive triangles, split by the axis direction nearest to their
// normals.
void collect(const Scene& scene, const Object& object, const MeshPart& part, const glm::mat4& world,
             std::vector<EmitterPatch>& patches)
{
    const Mesh& mesh = scene.meshes[object.mesh];
    const Emission emission(scene, mesh, scene.materials[part.material]);
    const bool mirrored = glm::determinant(glm::mat3(world)) < 0;

    // Join triangles that share the position of a corner.
    std::vector<std::uint32_t> root(part.triangle_count);
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t i) {
        while (root[i] != i) i = root[i] = root[root[i]];
        return i;
    };
    std::map<std::tuple<float, float, float>, std::uint32_t> seen;
    for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            const glm::vec3& p = mesh.positions[mesh.triangles[part.first_triangle + i][k]];
            const auto [at, added] = seen.try_emplace({p.x, p.y, p.z}, i);
            if (!added) root[find(i)] = find(at->second);
        }
    }

    std::map<std::pair<std::uint32_t, int>, std::size_t> patch_of;
    for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
        glm::vec3 p[3];
        for (int k = 0; k < 3; ++k)
            p[k] = transform_point(world, mesh.positions[mesh.triangles[part.first_triangle + i][k]]);
        if (mirrored) std::swap(p[1], p[2]);
        const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        const float area = 0.5f * glm::length(cross);
        if (!(area > 0) || !std::isfinite(area)) continue;
        const glm::vec3 radiance = emission.mean(part.first_triangle + i);
        if (radiance == glm::vec3(0)) continue;
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            if (std::abs(cross[a]) > std::abs(cross[axis])) axis = a;
        const int facing = 2 * axis + (cross[axis] < 0);
        const auto [at, added] = patch_of.try_emplace({find(i), facing}, patches.size());
        if (added) {
            patches.emplace_back();
            patches.back().node = object.node;
            patches.back().two_sided = !scene.materials[part.material].one_sided();
        }
        EmitterPatch& patch = patches[at->second];
        patch.triangles.insert(patch.triangles.end(), p, p + 3);
        patch.area += area;
        patch.radiance += area * radiance;   // divided by the area below
        patch.normal += 0.5f * cross;
    }
}

// The sides of a patch that emit into open space: the front, and the back of a two-sided one. A side that lies on
// another surface lights nothing.
std::vector<EmitterPatch> open_sides(const EmitterPatch& patch, const SpaceGrid* grid)
{
    std::vector<EmitterPatch> sides{patch};
    sides[0].normal = glm::normalize(patch.normal);
    if (!patch.two_sided) return sides;
    sides.push_back(sides[0]);
    sides[1].normal = -sides[0].normal;
    if (!grid || grid->empty()) return sides;
    const glm::vec3 middle = (patch.triangles[0] + patch.triangles[1] + patch.triangles[2]) / 3.0f;
    const double front = grid->cast(middle, sides[0].normal).distance,
                 back = grid->cast(middle, sides[1].normal).distance;
    const double least = static_cast<double>(grid->cell());
    if (std::max(front, back) <= least) return sides;
    if (back <= least) sides.pop_back();
    if (front <= least) sides.erase(sides.begin());
    return sides;
}

// Approximates what emits within a cone by a spot light at the object's origin: its intensity along the axis is the
// radiance times a fourth of the area, which is what a sphere shows from each side.
void add_spot(const Scene& scene, const Object& object, const MeshPart& part, std::vector<Light>& spots)
{
    const Mesh& mesh = scene.meshes[object.mesh];
    const Material& material = scene.materials[part.material];
    const Emission emission(scene, mesh, material);
    Light light;
    light.name = "emitter";
    light.of_surface = true;
    light.type = LightType::spot;
    light.profile = SpotProfile::smooth_cosine;
    light.inner_angle = material.layers->emission_inner;
    light.outer_angle = material.layers->emission_outer;
    light.node = object.node;
    light.color = glm::vec3(0);
    for (std::uint32_t t = part.first_triangle; t < part.first_triangle + part.triangle_count; ++t) {
        const glm::uvec3& index = mesh.triangles[t];
        const float area = area_of(mesh.positions[index[0]], mesh.positions[index[1]], mesh.positions[index[2]]);
        if (std::isfinite(area)) light.color += 0.25f * area * emission.mean(t);
    }
    if (light.color != glm::vec3(0)) spots.push_back(light);
}

}   // namespace

void add_patch_lights(Scene& scene, const EmitterPatch& patch, int count, float fraction, float lift, const Light& like)
{
    const std::vector<glm::vec3> points = spread(patch, count);
    const glm::dmat4 to_node =
        patch.node == none ? glm::dmat4(1) : glm::inverse(scene.world_matrix(patch.node, scene.timeline.start));
    const glm::dvec3 direction(patch.normal);
    const glm::dvec3 up = std::abs(direction.y) > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
    for (const glm::vec3& point : points) {
        const glm::dvec3 eye = glm::dvec3(point) + static_cast<double>(lift * std::sqrt(patch.area)) * direction;
        Light light = like;
        light.type = LightType::spot;
        light.profile = SpotProfile::cosine;
        light.outer_angle = static_cast<float>(k_pi / 2);
        light.color = patch.radiance * (patch.area * fraction / static_cast<float>(points.size()));
        light.node =
            scene.add_node(like.name, patch.node, to_node * glm::inverse(glm::lookAt(eye, eye + direction, up)));
        scene.lights.push_back(light);
    }
}

void add_room_fill(Scene& scene, const glm::vec3& flux)
{
    const auto interior = find_interior(scene);
    if (!interior || !interior->covered) return;
    // The mean irradiance of all bounces is flux / surface * r / (1 - r), with r the walls' reflectance.
    constexpr float r = 1.0f / 3.0f;
    const glm::vec3 s = scene.bounds(scene.timeline.start).size();
    const float surface = 2 * (s.x * s.y + s.y * s.z + s.z * s.x);
    if (surface > 0) scene.ambient += flux * (r / (1 - r) / (surface * static_cast<float>(k_pi)));
}

void add_emitter_lights(Scene& scene, const EmitterOptions& options)
{
    const bool alone = scene.lights.empty();
    std::vector<EmitterPatch> patches;
    std::vector<Light> spots;
    std::vector<glm::dmat4> world;   // by node, because walking up from each object is too slow in deep hierarchies
    bool two_sided = false;
    for (const Object& object : scene.objects) {
        if (object.removed || scene.meshes[object.mesh].deforms()) continue;
        for (const MeshPart& part : scene.meshes[object.mesh].parts) {
            const Material& material = scene.materials[part.material];
            if (!may_emit(material)) continue;
            two_sided |= !material.one_sided();
            if (material.layers && material.layers->emission_outer > 0) {
                add_spot(scene, object, part, spots);
                continue;
            }
            if (world.empty()) world = scene.world_matrices(scene.timeline.start);
            collect(scene, object, part, glm::mat4(world[object.node]), patches);
        }
    }
    scene.lights.insert(scene.lights.end(), spots.begin(), spots.end());
    if (patches.empty()) {
        if (!spots.empty()) scene.finish();
        return;
    }

    // Find the sides that emit; keep the strongest.
    std::optional<SpaceGrid> grid;
    if (two_sided) grid.emplace(scene, scene.timeline.start);
    std::erase_if(patches, [](const EmitterPatch& patch) { return !(glm::length(patch.normal) > 0); });
    const std::size_t found = patches.size();
    std::vector<EmitterPatch> sides;
    for (EmitterPatch& patch : patches) {
        patch.radiance /= patch.area;
        const std::vector<EmitterPatch> open = open_sides(patch, grid ? &*grid : nullptr);
        sides.insert(sides.end(), open.begin(), open.end());
    }
    patches = std::move(sides);
    if (patches.empty()) return;
    const auto power = [](const EmitterPatch& patch) { return luminance(patch.radiance) * patch.area; };
    std::stable_sort(patches.begin(), patches.end(),
                     [&](const EmitterPatch& a, const EmitterPatch& b) { return power(a) > power(b); });
    float all = 0, kept = 0;
    for (const EmitterPatch& patch : patches) all += power(patch);
    if (patches.size() > static_cast<std::size_t>(options.most_lights)) patches.resize(options.most_lights);
    for (const EmitterPatch& patch : patches) kept += power(patch);

    glm::vec3 flux(0);
    const int each = std::max(1, options.most_lights / static_cast<int>(patches.size()));
    for (const EmitterPatch& patch : patches) {
        flux += patch.radiance * (static_cast<float>(k_pi) * patch.area * all / kept);
        Light like;
        like.name = "emitter";
        like.of_surface = true;
        add_patch_lights(scene, patch, each, all / kept, options.lift, like);
    }
    scene.finish();
    if (!alone) return;
    if (options.fill) add_room_fill(scene, flux);
    scene.warnings.push_back(
        fmt::format("{} emissive surface{} the scene; {} point lights approximate {} where light bounces in rasterised "
                    "frames, and by --indirect quadtree and rsm",
                    found, found == 1 ? " lights" : "s light", scene.lights.size(), found == 1 ? "it" : "them"));
}

}   // namespace gnomon::scene
