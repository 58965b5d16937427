// SPDX-License-Identifier: Apache-2.0
#include "scene/deform.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::scene {

namespace {

glm::vec3 unit_or(const glm::vec3& v, const glm::vec3& otherwise)
{
    const float square = glm::dot(v, v);
    return square > 0 && std::isfinite(square) ? v / std::sqrt(square) : otherwise;
}

void apply_keys(const VertexKeys& keys, double time, DeformedMesh& out)
{
    const auto after =
        static_cast<std::size_t>(std::upper_bound(keys.times.begin(), keys.times.end(), time) - keys.times.begin());
    if (after == 0 || after == keys.times.size()) {
        const std::size_t key = after == 0 ? 0 : after - 1;
        out.positions = keys.positions[key];
        if (!keys.normals.empty()) out.normals = keys.normals[key];
        return;
    }
    const double span = keys.times[after] - keys.times[after - 1];
    const auto u = static_cast<float>(span > 0 ? (time - keys.times[after - 1]) / span : 0.0);
    for (std::size_t i = 0; i < out.positions.size(); ++i)
        out.positions[i] = glm::mix(keys.positions[after - 1][i], keys.positions[after][i], u);
    if (keys.normals.empty()) return;
    for (std::size_t i = 0; i < out.normals.size(); ++i)
        out.normals[i] =
            unit_or(glm::mix(keys.normals[after - 1][i], keys.normals[after][i], u), keys.normals[after - 1][i]);
}

void apply_targets(const Mesh& mesh, std::span<const float> weights, DeformedMesh& out)
{
    bool normals_changed = false;
    for (std::size_t t = 0; t < mesh.morph_targets.size(); ++t) {
        const float w = weights[t];
        if (w == 0) continue;
        const MorphTarget& target = mesh.morph_targets[t];
        for (std::size_t i = 0; i < target.positions.size(); ++i) out.positions[i] += w * target.positions[i];
        if (!out.normals.empty() && !target.normals.empty()) {
            normals_changed = true;
            for (std::size_t i = 0; i < target.normals.size(); ++i) out.normals[i] += w * target.normals[i];
        }
        if (!out.tangents.empty())
            for (std::size_t i = 0; i < target.tangents.size(); ++i)
                out.tangents[i] += glm::vec4(w * target.tangents[i], 0);
    }
    if (normals_changed)
        for (std::size_t i = 0; i < out.normals.size(); ++i) out.normals[i] = unit_or(out.normals[i], mesh.normals[i]);
}

void apply_skin(const SkinBinding& skin, std::span<const glm::mat4> joints, DeformedMesh& out)
{
    for (std::size_t i = 0; i < out.positions.size(); ++i) {
        glm::mat4 blend(0);
        for (int group = 0; group < 2; ++group) {
            if (skin.joints[group].empty()) continue;
            const glm::u16vec4 joint = skin.joints[group][i];
            const glm::vec4 weight = skin.weights[group][i];
            for (int k = 0; k < 4; ++k)
                if (weight[k] != 0) blend += weight[k] * joints[joint[k]];
        }
        out.positions[i] = transform_point(blend, out.positions[i]);
        const glm::mat3 linear(blend);
        if (!out.normals.empty()) {
            // Use the cofactor matrix: it equals the inverse transpose up to a factor, and exists for singular
            // joints too.
            const glm::mat3 cofactor(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                                     glm::cross(linear[0], linear[1]));
            out.normals[i] = unit_or(cofactor * out.normals[i], out.normals[i]);
        }
        if (!out.tangents.empty())
            out.tangents[i] =
                glm::vec4(unit_or(linear * glm::vec3(out.tangents[i]), glm::vec3(out.tangents[i])), out.tangents[i].w);
    }
}

// Sums the triangles' normals, weighted by area, in the order of the triangles.
void make_smooth_normals(const Mesh& mesh, DeformedMesh& out)
{
    std::vector<glm::dvec3> sums(mesh.positions.size(), glm::dvec3(0));
    for (const glm::uvec3& triangle : mesh.triangles) {
        const glm::dvec3 p[3] = {glm::dvec3(out.positions[triangle[0]]), glm::dvec3(out.positions[triangle[1]]),
                                 glm::dvec3(out.positions[triangle[2]])};
        const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
        for (int i = 0; i < 3; ++i) sums[triangle[i]] += cross;
    }
    out.normals.resize(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) {
        const double length = glm::length(sums[i]);
        const glm::vec3 at_rest = mesh.normals.empty() ? glm::vec3(0, 1, 0) : mesh.normals[i];
        out.normals[i] = length > 0 && std::isfinite(length) ? glm::vec3(sums[i] / length) : at_rest;
    }
}

}   // namespace

void complete_vertices(const Mesh& mesh, const DeformedMesh& handed, DeformedMesh& out)
{
    const std::size_t count = mesh.positions.size();
    GNOMON_CHECK_EQ(handed.positions.size(), count);
    GNOMON_CHECK(handed.normals.empty() || handed.normals.size() == count);
    GNOMON_CHECK(handed.tangents.empty() || handed.tangents.size() == count);
    out.positions = handed.positions;

    // Take the normals, or make smooth ones.
    const bool has_normals = !mesh.normals.empty() || (mesh.vertex_keys && !mesh.vertex_keys->normals.empty());
    if (!has_normals)
        out.normals.clear();
    else if (!handed.normals.empty())
        out.normals = handed.normals;
    else
        make_smooth_normals(mesh, out);

    // Take the tangents, or turn those of the mesh into the surface.
    out.tangents.clear();
    if (mesh.tangents.empty()) return;
    out.tangents = handed.tangents.empty() ? mesh.tangents : handed.tangents;
    if (!handed.tangents.empty() || out.normals.empty()) return;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 tangent(mesh.tangents[i]), &normal = out.normals[i];
        out.tangents[i] = glm::vec4(unit_or(tangent - glm::dot(tangent, normal) * normal, tangent), mesh.tangents[i].w);
    }
}

void deform_mesh(const Mesh& mesh, double time, std::span<const float> weights, std::span<const glm::mat4> joints,
                 DeformedMesh& out)
{
    GNOMON_CHECK_EQ(weights.size(), mesh.morph_targets.size());
    out.positions = mesh.positions;
    out.normals = mesh.normals;
    out.tangents = mesh.tangents;
    if (mesh.vertex_keys) apply_keys(*mesh.vertex_keys, time, out);
    apply_targets(mesh, weights, out);
    if (mesh.skin && !joints.empty()) apply_skin(*mesh.skin, joints, out);
}

}   // namespace gnomon::scene
