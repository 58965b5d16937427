// SPDX-License-Identifier: Apache-2.0
#pragma once
// One of the two trees of a CountingKdTree. Private to this folder: built in build.cpp, traversed by walk.h.
//
// Invariant: every triangle, enlarged by `pad` against rounding, is in each leaf whose cell it overlaps.

#include <cstdint>
#include <vector>

#include "ray/kdtree/kdtree.h"

namespace gnomon::ray {

struct KdTriangle {
    glm::vec3 p[3];
    scene::ObjectId object = scene::none;
    std::uint32_t triangle = 0;   // of the object's mesh
    scene::MaterialId material = scene::none;
    scene::SurfaceClass surface = scene::SurfaceClass::opaque;
    bool one_sided = false;
    bool mirrored = false;   // the front is clockwise
};

/// A scene-graph node or an object of this tree. Nodes come before those below them.
struct KdGroup {
    Box3 box;                                          // enlarged; empty if nothing below is visible
    std::uint32_t first_triangle = 0, triangles = 0;   // objects: their run; nodes: only the number below
    std::uint32_t parent = scene::none;
    std::vector<std::uint32_t> children;   // empty: an object
    scene::ObjectId object = scene::none;
};

struct KdNode {
    static constexpr std::uint32_t k_leaf = 3;   // in place of an axis
    float split = 0;
    std::uint32_t axis = k_leaf;
    std::uint32_t first = 0;   // inner: child below the plane, followed by the one above; leaf: first reference
    std::uint32_t count = 0;   // leaf: number of references
};

inline constexpr int k_deepest = 60;   // limit of the depth: the size of the traversal's stack

// Bits of the nodes of a tree that holds everything: what is somewhere below.
inline constexpr std::uint8_t k_holds_clip_dynamic = 1, k_holds_dynamic = 2;

struct KdPart {
    std::vector<KdTriangle> triangles;
    std::vector<KdGroup> groups;
    Box3 box;   // of everything, enlarged
    float pad = 0;
    std::vector<KdNode> nodes;   // [0] is the root; empty: no triangles
    std::vector<std::uint32_t> references;
    std::vector<std::uint8_t> holds;   // by node: k_holds_*; empty for trees that are entered only if all are asked
    std::uint64_t group_splits = 0, builds = 0;
    double build_ms = 0;

    /// Builds from triangles, groups (with their boxes) and box.
    void build(const KdBuildOptions& options);
};

}   // namespace gnomon::ray
