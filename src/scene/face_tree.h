// SPDX-License-Identifier: Apache-2.0
#pragma once
// A tree over the faces of a light with many of them, so that a point near to the light sums up what is far for its
// size in groups: a glowing body of thousands of triangles costs a point some hundred terms.
//
// Cost: O(n log^2 n) for n faces, when the light is made. Memory: 48 bytes for each two faces.

#include <span>
#include <vector>

#include "scene/sized_face.h"

namespace gnomon::scene {

/// A group of faces. Nodes are in depth-first order: the first child of a node follows it.
struct FaceNode {
    glm::vec3 centre{0};   // of a sphere around all faces
    float radius = 0;
    glm::vec3 normal{0};       // unit, the mean of the faces' normals
    float normal_spread = 2;   // sine of the largest angle between it and a face's normal; 2: beyond 90 degrees, or
                               // one- and two-sided faces are in one group
    glm::vec3 power{0};        // sum of radiance times area, projected onto the plane of the mean normal
    float area = 0;            // likewise, without radiance
    std::uint32_t first = 0, count = 0;   // of a leaf, in FaceTree::order
    std::uint32_t next = 0;               // the node that follows in depth-first order if this one is not opened
    bool two_sided = false;
};

struct FaceTree {
    static constexpr std::size_t k_fewest = 32;   // faces of a light that get a tree
    static constexpr std::size_t k_leaf = 2;      // faces of a leaf at the most

    std::vector<FaceNode> nodes;        // empty: there is none
    std::vector<std::uint32_t> order;   // indices of faces
};

/// A tree over faces; empty if there are too few of them.
FaceTree make_face_tree(std::span<const SizedFace> faces);

}   // namespace gnomon::scene
