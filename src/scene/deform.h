// SPDX-License-Identifier: Apache-2.0
#pragma once
// Vertices of deforming meshes: vertex keys, then morph targets, then linear blend skinning (glTF 2.0).
//
// Cost: the mesh's vertices times its targets and joints. Called only for meshes that changed.

#include <span>

#include "scene/mesh.h"

namespace gnomon::scene {

/// The current vertices of a deforming object. Morphs and vertex keys give object space. Skins give world space; the
/// object's matrix is then the identity.
struct DeformedMesh {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec4> tangents;
};

/// @param weights  of the morph targets; as many as the mesh has
/// @param joints   joint world matrix times inverse bind matrix, for skinned meshes; else empty
/// @param out      its arrays keep their capacity from call to call
void deform_mesh(const Mesh& mesh, double time, std::span<const float> weights, std::span<const glm::mat4> joints,
                 DeformedMesh& out);

/// Fills in what a host left out of the vertices that it hands over, so that an object has the same arrays in all
/// frames: those that deform_mesh() gives. Missing normals are the area-weighted means of the triangles around a
/// vertex; missing tangents are the mesh's, made orthogonal to the normals. Arrays that the mesh lacks are left out.
/// @param handed  as many positions as the mesh has; normals (unit) and tangents as many, or none
/// @throws InternalError  other lengths
void complete_vertices(const Mesh& mesh, const DeformedMesh& handed, DeformedMesh& out);

}   // namespace gnomon::scene
