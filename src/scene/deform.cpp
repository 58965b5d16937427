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

}   // namespace

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
