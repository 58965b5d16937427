// SPDX-License-Identifier: Apache-2.0
#pragma once
// The `m` statement of AFF [BART AFF]: positions, normals and texture coordinates, each with indices of its own.
//
//   m vertices n ...  [normals n ...]  [texturecoords n texture ...]  triangles n ...
//
// The file's three index lists become one: each combination that occurs is a vertex. Cost: n log n in the corners.

#include "io/aff/tokens.h"
#include "scene/mesh.h"

namespace gnomon::io {

/// What the statement holds: a mesh without parts, and the token that names its texture (empty: none).
struct AffMesh {
    scene::Mesh mesh;
    AffToken texture;
};

/// Reads what follows the `m`.
/// @throws InputError
AffMesh read_aff_mesh(AffTokens& tokens);

/// A normal of length 1: the given one, else that of the triangle, else upwards.
glm::vec3 usable_normal(const glm::vec3& normal, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

}   // namespace gnomon::io
