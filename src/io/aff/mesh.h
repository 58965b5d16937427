// SPDX-License-Identifier: Apache-2.0
#pragma once
// The `m` statement of AFF [BART AFF]: positions, normals and texture coordinates, each with its own indices.
//
//   m vertices n ...  [normals n ...]  [texturecoords n texture ...]  triangles n ...
//
// The file's three index lists are merged into one: each combination that occurs is a vertex. Cost: O(n log n) in the
// number of corners.

#include "io/aff/tokens.h"
#include "scene/mesh.h"

namespace gnomon::io {

/// The result: a mesh without parts, and the token that names its texture (empty: none).
struct AffMesh {
    scene::Mesh mesh;
    AffToken texture;
};

/// Reads the text after the `m`.
/// @throws InputError
AffMesh read_aff_mesh(AffTokens& tokens);

/// A normal of length 1: the given one if it can be normalised, else that of the triangle, else upwards.
glm::vec3 usable_normal(const glm::vec3& normal, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

}   // namespace gnomon::io
