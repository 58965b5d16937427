// SPDX-License-Identifier: Apache-2.0
#pragma once
// A k-d tree that counts traversed nodes and ray-triangle tests. These figures do not depend on the machine, and papers
// on culling report them [Nah, Park and Han 2009, 5]. RayScene gives the same results far faster.
//
// Built from the scene's hierarchy [Hunt, Mark and Fussell 2007, 'Fast and Lazy Build of Acceleration Structures from
// Scene Hierarchies']: the upper splits lie at bounds of scene-graph nodes and objects, a few of which are open at a
// time. Below, where bounds gain little, the surface area heuristic is applied to single triangles.
//
// Static and dynamic triangles never share a node. The root's two children are a static and a dynamic one, each with a
// box and a tree of its own. The static tree is kept between frames; the dynamic one is rebuilt in frames in which
// something changed. Rays against dynamic objects only do not enter the static child.
//
// DEVIATION(Nah 2009, 2.4): there nodes are marked as free of dynamic primitives, and such traversal stops at them;
// with separate trees it stops at one child of the root.
//
// DEVIATION(Hunt 2007, 4): nothing is built lazily, because the static tree is built once and the dynamic tree is
// small.
//
// All triangles are tested in world space, with the corners of RayScene::geometry(). Of equal distances, the smaller
// object wins, then the smaller triangle.

#include <cstdint>
#include <memory>

#include "ray/ray_scene.h"

namespace gnomon::ray {

/// The work for one class of rays (primary, shadow ...). `nodes` counts the root, its children whose box was tested,
/// inner nodes and leaves. For occlusion rays, transparent triangles are not tested and not counted.
struct KdCounts {
    std::uint64_t nodes = 0;
    std::uint64_t tests = 0;
};

/// Parameters of the build of one tree. Costs are in units of one node's traversal. The defaults of the dynamic tree
/// accept more tests for a shorter build, because it is built in every frame.
struct KdBuildOptions {
    bool from_hierarchy = true;   // false: triangles only, from the root on: the reference implementation
    int open_groups = 32;         // bounds that are tested for one upper split
    int groups_above = 10000;     // expected triangles in a cell; with fewer, splits are sought over triangles
    float group_split_gain =
        0.8f;                   // an upper split must reduce the expected cost to this fraction; else over triangles
    int exact_below = 256;      // triangles; above, splits are sought between `bins`, below at every bound
    int bins = 32;              // per axis; 2 to 64
    bool clip = true;           // clips triangles to their cell: tighter bounds, slower build
    float test_cost = 1.5f;     // of one ray-triangle test
    float empty_bonus = 0.2f;   // fraction of the cost that is saved by cutting off empty space
    int leaf = 2;               // cells with so few triangles are not split
    float depth_base = 8;       // deepest leaf: base + slope * log2(triangles)
    float depth_slope = 1.3f;
};

struct KdOptions {
    KdBuildOptions still;
    KdBuildOptions moving{.groups_above = 1000, .exact_below = 0, .bins = 8, .test_cost = 0.7f, .leaf = 12};
};

struct KdTreeStatistics {
    std::uint64_t triangles = 0;
    std::uint64_t references = 0;   // of leaves to triangles
    std::uint64_t nodes = 0;
    std::uint64_t group_splits = 0;   // nodes split at bounds of the scene's hierarchy
    std::uint64_t bytes = 0;
    std::uint64_t builds = 0;   // since construction
    double build_ms = 0;        // the last
};

struct KdStatistics {
    KdTreeStatistics still, moving;
};

class CountingKdTree {
 public:
    /// Keeps a reference to the state's scene, none to `rays`.
    CountingKdTree(const scene::SceneState& state, const RayScene& rays, const KdOptions& options = {});
    ~CountingKdTree();
    CountingKdTree(const CountingKdTree&) = delete;
    CountingKdTree& operator=(const CountingKdTree&) = delete;

    /// Follows one advance() of the state, after RayScene::update. Cost: nothing if nothing changed, else a build of
    /// the dynamic tree; of the static tree only after a promotion.
    void update(const scene::SceneState& state, const RayScene& rays);

    /// Whether a surface that blocks light lies at a distance in (tnear, tfar]. Thread-safe.
    bool occluded(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Against against,
                  KdCounts& counts) const;
    /// The nearest surface, transparent ones included; t is tfar if there is none. Thread-safe.
    Hit closest(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides,
                KdCounts& counts, Against against = Against::everything) const;

    /// The reference implementations, which test every triangle.
    bool occluded_by_any(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
                         Against against) const;
    Hit closest_of_all(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides,
                       Against against = Against::everything) const;

    KdStatistics statistics() const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}   // namespace gnomon::ray
