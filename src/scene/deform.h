// SPDX-License-Identifier: Apache-2.0
#pragma once
// Vertices of meshes that change shape: vertex keys, then morph targets, then skinning by linear blending (glTF 2.0).
//
// Cost: the mesh's vertices times its targets and joints. Called for meshes that changed, never for others.

#include <span>

#include "scene/mesh.h"

namespace gnomon::scene {

/// The vertices of a deforming object now. Morphs and vertex keys: in object space. Skins: in world space (the object's
/// matrix is then the identity).
struct DeformedMesh {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents;
};

/// @param weights  of the morph targets; as many as the mesh has
/// @param joints   joint world matrix times inverse bind matrix, for skinned meshes; else empty
/// @param out      its arrays keep their memory from call to call
void deform_mesh(const Mesh& mesh, double time, std::span<const float> weights, std::span<const glm::mat4> joints,
                 DeformedMesh& out);

}   // namespace gnomon::scene
