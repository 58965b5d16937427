// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "api/convert.h"
#include "gnomon/error.h"
#include "gnomon/ranges.h"
#include "scene/mesh_repairs.h"

namespace gnomon::api {

namespace {

constexpr float k_unit = 1e-3f;         // squares of lengths within this of 1 are left as they are
constexpr float k_weight_sum = 1e-3f;   // sums of weights within this of 1, too

// Rejects an array of a mesh that is neither empty nor as long as its positions.
void require_length(std::size_t length, std::size_t count, const std::string& owner, const char* what)
{
    if (length != 0 && length != count)
        throw UsageError(fmt::format("{}: {} {} for {} vertices", owner, length, what, count));
}

void require_at_most(std::size_t length, std::int64_t most, const std::string& owner, const char* what)
{
    if (length > static_cast<std::size_t>(most))
        throw UsageError(fmt::format("{}: {} {}: expected at most {}", owner, length, what, most));
}

// Checks the lengths of all arrays before any element is read or memory is allocated.
void check_lengths(const Mesh& mesh, const std::string& owner)
{
    const std::size_t count = mesh.positions.size();
    const std::size_t corners = mesh.indices.empty() ? count : mesh.indices.size();
    require_at_most(count, ranges::k_most_vertices, owner, "vertices");
    if (corners % 3 != 0) throw UsageError(fmt::format("{}: {} indices are not three per triangle", owner, corners));
    require_at_most(corners / 3, ranges::k_most_triangles, owner, "triangles");
    require_length(mesh.normals.size(), count, owner, "normals");
    require_length(mesh.tangents.size(), count, owner, "tangents");
    for (const auto& set : mesh.texcoords) require_length(set.size(), count, owner, "texture coordinates");
    require_length(mesh.colors.size(), count, owner, "colours");
    require_at_most(mesh.parts.size(), ranges::k_most_mesh_parts, owner, "parts");
    require_at_most(mesh.morph_targets.size(), ranges::k_most_morph_targets, owner, "morph targets");
    for (const MorphTarget& target : mesh.morph_targets) {
        require_length(target.positions.size(), count, owner, "positions of a morph target");
        require_length(target.normals.size(), count, owner, "normals of a morph target");
        require_length(target.tangents.size(), count, owner, "tangents of a morph target");
    }
    if (!mesh.morph_weights.empty() && mesh.morph_weights.size() != mesh.morph_targets.size())
        throw UsageError(fmt::format("{}: {} morph weights for {} targets", owner, mesh.morph_weights.size(),
                                     mesh.morph_targets.size()));
    const bool has_skin =
        !mesh.joints[0].empty() || !mesh.weights[0].empty() || !mesh.joints[1].empty() || !mesh.weights[1].empty();
    for (std::size_t group = 0; group < 2 && has_skin; ++group) {
        const std::size_t joints = mesh.joints[group].size(), weights = mesh.weights[group].size();
        const bool needed = group == 0 || joints > 0 || weights > 0;
        if (needed && (joints != count || weights != count))
            throw UsageError(
                fmt::format("{}: {} joints and {} weights for {} vertices", owner, joints, weights, count));
    }
}

// Copies an array of a mesh, and checks that all numbers are finite.
template <class To, class From>
std::vector<To> copied(std::span<const From> from, const std::string& owner, const char* what)
{
    static_assert(sizeof(To) == sizeof(From) && std::is_trivially_copyable_v<To>);
    std::vector<To> to(from.size());
    if (!from.empty()) std::memcpy(to.data(), from.data(), from.size_bytes());
    constexpr std::size_t floats = sizeof(To) / sizeof(float);
    for (std::size_t i = 0; i < to.size(); ++i)
        for (std::size_t k = 0; k < floats; ++k)
            if (!std::isfinite((&to[i].x)[k])) throw UsageError(fmt::format("{}: {} {} is not finite", owner, what, i));
    return to;
}

bool is_unit(const glm::vec3& v)
{
    return std::abs(glm::dot(v, v) - 1) <= k_unit;
}

// Gives every normal and tangent unit length. Normals without a direction get that of their triangles.
void repair_directions(scene::Mesh& mesh)
{
    bool repaired = false;
    for (glm::vec3& normal : mesh.normals) {
        if (is_unit(normal)) continue;
        repaired = true;
        normal = scene::unit_or(normal, glm::vec3(0));
    }
    if (repaired) scene::fill_normals(mesh.positions, mesh.triangles, mesh.normals);
    for (std::size_t i = 0; i < mesh.tangents.size(); ++i) {
        glm::vec4& tangent = mesh.tangents[i];
        if (is_unit(glm::vec3(tangent)) && std::abs(tangent.w) == 1) continue;
        const glm::vec3 across = mesh.normals.empty() ? glm::vec3(1, 0, 0) : scene::perpendicular_to(mesh.normals[i]);
        tangent = glm::vec4(scene::unit_or(glm::vec3(tangent), across), tangent.w < 0 ? -1 : 1);
    }
}

std::vector<glm::uvec3> triangles_of(const Mesh& mesh, const std::string& owner)
{
    const std::size_t corners = mesh.indices.empty() ? mesh.positions.size() : mesh.indices.size();
    std::vector<glm::uvec3> triangles(corners / 3);
    for (std::size_t i = 0; i < corners; ++i) {
        const std::uint32_t index = mesh.indices.empty() ? static_cast<std::uint32_t>(i) : mesh.indices[i];
        if (index >= mesh.positions.size())
            throw UsageError(
                fmt::format("{}: index {} is {}; the mesh has {} vertices", owner, i, index, mesh.positions.size()));
        triangles[i / 3][static_cast<int>(i % 3)] = index;
    }
    return triangles;
}

std::vector<scene::MeshPart> parts_of(const Mesh& mesh, std::size_t triangles, const SceneStamps& stamps,
                                      scene::MaterialId material, const std::string& owner)
{
    if (triangles == 0) return {};
    if (mesh.parts.empty()) return {{material, 0, static_cast<std::uint32_t>(triangles)}};
    std::vector<scene::MeshPart> parts;
    std::size_t covered = 0;
    for (const MeshPart& part : mesh.parts) {
        if (part.first_triangle != covered || part.triangle_count > triangles - covered)
            throw UsageError(fmt::format("{}: part {} has triangles {} to {} of {}: parts must cover all in order",
                                         owner, parts.size(), part.first_triangle,
                                         std::uint64_t{part.first_triangle} + part.triangle_count, triangles));
        covered += part.triangle_count;
        const std::uint32_t own =
            part.material ? require(stamps.materials, part.material, fmt::format("{}: the material", owner)) : material;
        if (part.triangle_count > 0) parts.push_back({own, part.first_triangle, part.triangle_count});
    }
    if (covered != triangles)
        throw UsageError(fmt::format("{}: its parts cover {} of {} triangles", owner, covered, triangles));
    return parts;
}

void add_morph_targets(const Mesh& mesh, const std::string& owner, scene::Mesh& result)
{
    for (const MorphTarget& target : mesh.morph_targets) {
        scene::MorphTarget& own = result.morph_targets.emplace_back();
        own.positions = copied<glm::vec3>(target.positions, owner, "positions of a morph target");
        own.normals = copied<glm::vec3>(target.normals, owner, "normals of a morph target");
        own.tangents = copied<glm::vec3>(target.tangents, owner, "tangents of a morph target");
    }
    result.morph_weights.assign(mesh.morph_weights.begin(), mesh.morph_weights.end());
    result.morph_weights.resize(mesh.morph_targets.size());
    for (const float weight : result.morph_weights)
        if (!std::isfinite(weight)) throw UsageError(fmt::format("{}: a morph weight is not finite", owner));
}

void add_skin(const Mesh& mesh, const std::string& owner, scene::Mesh& result)
{
    if (mesh.joints[0].empty()) return;
    result.skin.emplace();
    for (std::size_t group = 0; group < 2; ++group) {
        for (const Joints& j : mesh.joints[group])
            result.skin->joints[group].emplace_back(j.joint[0], j.joint[1], j.joint[2], j.joint[3]);
        result.skin->weights[group] = copied<glm::vec4>(mesh.weights[group], owner, "weights");
    }
    for (const auto& group : result.skin->weights)
        for (const glm::vec4& weight : group)
            if (weight.x < 0 || weight.y < 0 || weight.z < 0 || weight.w < 0) return;   // the host means what it says
    scene::normalize_weights(result.skin->weights, k_weight_sum);
}

}   // namespace

scene::Mesh to_scene(const Mesh& mesh, const SceneStamps& stamps, scene::MaterialId material)
{
    const std::string owner = titled("mesh", mesh.name);
    check_lengths(mesh, owner);

    scene::Mesh result;
    result.name = mesh.name;
    result.triangles = triangles_of(mesh, owner);
    result.parts = parts_of(mesh, result.triangles.size(), stamps, material, owner);
    result.positions = copied<glm::vec3>(mesh.positions, owner, "positions");
    result.normals = copied<glm::vec3>(mesh.normals, owner, "normals");
    result.tangents = copied<glm::vec4>(mesh.tangents, owner, "tangents");
    repair_directions(result);
    for (std::size_t set = 0; set < 2; ++set)
        result.texcoords[set] = copied<glm::vec2>(mesh.texcoords[set], owner, "texture coordinates");
    result.colors = copied<glm::vec4>(mesh.colors, owner, "colours");
    add_morph_targets(mesh, owner, result);
    add_skin(mesh, owner, result);
    return result;
}

}   // namespace gnomon::api
