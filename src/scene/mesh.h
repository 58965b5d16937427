// SPDX-License-Identifier: Apache-2.0
#pragma once
// Triangle meshes with several materials and data for deformation.

#include <optional>
#include <string>
#include <vector>

#include "base/math.h"
#include "scene/ids.h"

namespace gnomon::scene {

/// A run of triangles with one material.
struct MeshPart {
    MaterialId material = none;
    std::uint32_t first_triangle = 0;
    std::uint32_t triangle_count = 0;
};

/// Offsets from the rest shape; each array is empty or as long as the mesh's.
struct MorphTarget {
    std::vector<glm::vec3> positions, normals, tangents;
};

/// Up to eight joints per vertex, in groups of four as in glTF; weights sum to 1.
struct SkinBinding {
    std::vector<glm::u16vec4> joints[2];
    std::vector<glm::vec4> weights[2];   // the second group is empty if unused
};

/// Complete vertex arrays at key times (AFF `tpa`): linear between keys, constant outside.
struct VertexKeys {
    std::vector<double> times;                       // increasing; not empty
    std::vector<std::vector<glm::vec3>> positions;   // [key][vertex]
    std::vector<std::vector<glm::vec3>> normals;     // [key][vertex], or empty
};

/// Attributes are per vertex; an array is empty or as long as `positions`.
struct Mesh {
    std::string name;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;    // unit; empty: shaded with the triangle's own normal
    std::vector<glm::vec4> tangents;   // xyz unit, w = -1 or 1
    std::vector<glm::vec2> texcoords[2];
    std::vector<glm::vec4> colors;       // linear RGBA; multiplies the base colour
    std::vector<glm::uvec3> triangles;   // counter-clockwise seen from the front
    std::vector<MeshPart> parts;         // cover all triangles, in order

    std::vector<MorphTarget> morph_targets;
    std::vector<float> morph_weights;   // default weights, one per target
    std::optional<SkinBinding> skin;
    std::optional<VertexKeys> vertex_keys;

    bool deforms() const { return skin.has_value() || !morph_targets.empty() || vertex_keys.has_value(); }
    Box3 bounds() const;
    /// The part that contains a triangle (binary search).
    const MeshPart& part_of(std::uint32_t triangle) const;
};

/// Throws InternalError if array lengths disagree or an index is out of range; importers must reject such meshes
/// before.
void check_mesh(const Mesh& mesh);

}   // namespace gnomon::scene
