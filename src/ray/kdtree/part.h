// SPDX-License-Identifier: Apache-2.0
#pragma once
// One of the two trees of a CountingKdTree. Private to this folder: built in kdtree_build.cpp, walked by kdtree_walk.h.
//
// Invariant: every triangle, fattened by `pad` against rounding, is in each leaf whose cell it overlaps.

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

/// A scene-graph node or an object, as far as it belongs to this tree. Nodes come before what is below them.
struct KdGroup {
    Box3 box;                                          // fattened; empty if nothing below is visible
    std::uint32_t first_triangle = 0, triangles = 0;   // objects: their own run; nodes: the number below alone
    std::uint32_t parent = scene::none;
    std::vector<std::uint32_t> children;   // empty: an object
    scene::ObjectId object = scene::none;
};

struct KdNode {
    static constexpr std::uint32_t k_leaf = 3;   // as axis
    float split = 0;
    std::uint32_t axis = k_leaf;
    std::uint32_t first = 0;   // inner: child below the plane, the one above follows; leaf: of its references
    std::uint32_t count = 0;   // leaf: its references
};

inline constexpr int k_deepest = 60;   // whatever the options say: the walk's stack is that long

struct KdPart {
    std::vector<KdTriangle> triangles;
    std::vector<KdGroup> groups;
    Box3 box;   // of everything, fattened
    float pad = 0;
    std::vector<KdNode> nodes;   // [0] is the root; empty: no triangles
    std::vector<std::uint32_t> references;
    std::uint64_t group_splits = 0, builds = 0;
    double build_ms = 0;

    /// From triangles, groups (their boxes, too) and box.
    void build(const KdBuildOptions& options);
};

}   // namespace gnomon::ray
