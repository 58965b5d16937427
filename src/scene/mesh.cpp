// SPDX-License-Identifier: Apache-2.0
#include "scene/mesh.h"

#include <algorithm>

#include "base/check.h"

namespace gnomon::scene {

Box3 Mesh::bounds() const
{
    Box3 box;
    for (const glm::vec3& p : positions) box.add(p);
    return box;
}

const MeshPart& Mesh::part_of(std::uint32_t triangle) const
{
    if (parts.size() == 1) return parts.front();
    const auto after = std::upper_bound(parts.begin(), parts.end(), triangle,
                                        [](std::uint32_t t, const MeshPart& part) { return t < part.first_triangle; });
    return *(after - 1);
}

void check_mesh(const Mesh& mesh)
{
    const std::size_t n = mesh.positions.size();
    const auto fits = [n](std::size_t size) { return size == 0 || size == n; };
    GNOMON_CHECK(fits(mesh.normals.size()));
    GNOMON_CHECK(fits(mesh.tangents.size()));
    GNOMON_CHECK(fits(mesh.texcoords[0].size()) && fits(mesh.texcoords[1].size()));
    GNOMON_CHECK(fits(mesh.colors.size()));
    for (const glm::uvec3& t : mesh.triangles) GNOMON_CHECK_LT(std::max({t.x, t.y, t.z}), n);

    // Check that parts cover all triangles in order.
    std::size_t covered = 0;
    for (const MeshPart& part : mesh.parts) {
        GNOMON_CHECK_EQ(part.first_triangle, covered);
        covered += part.triangle_count;
    }
    GNOMON_CHECK_EQ(covered, mesh.triangles.size());

    // Check the arrays of deformations.
    for (const MorphTarget& target : mesh.morph_targets) {
        GNOMON_CHECK(fits(target.positions.size()) && fits(target.normals.size()) && fits(target.tangents.size()));
    }
    if (!mesh.morph_targets.empty()) GNOMON_CHECK_EQ(mesh.morph_weights.size(), mesh.morph_targets.size());
    if (mesh.skin) {
        for (int group = 0; group < 2; ++group) {
            GNOMON_CHECK_EQ(mesh.skin->joints[group].size(), mesh.skin->weights[group].size());
            GNOMON_CHECK(fits(mesh.skin->joints[group].size()));
        }
    }
    if (mesh.vertex_keys) {
        const VertexKeys& keys = *mesh.vertex_keys;
        GNOMON_CHECK(!keys.times.empty());
        GNOMON_CHECK_EQ(keys.times.size(), keys.positions.size());
        GNOMON_CHECK(keys.normals.empty() || keys.normals.size() == keys.times.size());
        for (const auto& positions : keys.positions) GNOMON_CHECK_EQ(positions.size(), n);
        for (const auto& normals : keys.normals) GNOMON_CHECK_EQ(normals.size(), n);
    }
}

}   // namespace gnomon::scene
