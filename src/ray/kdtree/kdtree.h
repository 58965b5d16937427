// SPDX-License-Identifier: Apache-2.0
#pragma once
// A kd-tree that counts: nodes traversed and ray-triangle tests, figures that do not depend on the machine, by which
// papers on culling compare themselves [Nah, Park and Han 2009, 5]. RayScene answers the same questions far faster.
//
// Built from the scene's hierarchy [Hunt, Mark and Fussell 2007, 'Fast and Lazy Build of Acceleration Structures from
// Scene Hierarchies']: the upper splits lie at bounds of scene-graph nodes and objects, a few of which are open at a
// time; below, where bounds gain little, the surface area heuristic sees single triangles.
//
// What is static and what is dynamic never share a node: the root's two children are 'static' and 'dynamic', each with
// its own box and a tree of its own. The static one is kept between frames; the other is rebuilt in frames in which
// something moved. Rays against dynamic objects alone stop at the static child.
//
// DEVIATION(Nah 2009, 2.4): there nodes are marked as free of dynamic primitives, and such traversal stops at them;
// with trees apart it stops at one child of the root.
//
// DEVIATION(Hunt 2007, 4): nothing is built lazily: the static tree is built once, and the dynamic objects' tree is
// small.
//
// All triangles are tested in world space, corners as RayScene::geometry() gives them. Equal distances: the smaller
// object, then the smaller triangle.

#include <cstdint>
#include <memory>

#include "ray/ray_scene.h"

namespace gnomon::ray {

/// What one class of rays (primary, shadow ...) cost so far. Transparent triangles are no tests for rays that ask what
/// blocks light. One node: the root, a child of it whose box was looked at, an inner node, or a leaf.
struct KdCounts {
    std::uint64_t nodes = 0;
    std::uint64_t tests = 0;
};

/// How one of the two trees is built. Costs are in units of one node's traversal. The defaults of the dynamic objects'
/// tree trade tests for time: it is built in every frame.
struct KdBuildOptions {
    bool from_hierarchy = true;      // false: single triangles from the root on, the slow twin
    int open_groups = 32;            // bounds that are looked at for one upper split
    int groups_above = 10000;        // triangles expected in a cell; fewer are looked at one by one
    float group_split_gain = 0.8f;   // an upper split must bring the expected cost down to this share; else triangles
    int exact_below = 256;           // triangles; above, splits are sought among `bins`, below at every bound
    int bins = 32;                   // an axis; 2 to 64
    bool clip = true;                // triangles to their cell: tighter, slower
    float test_cost = 1.5f;          // of one ray-triangle test
    float empty_bonus = 0.2f;        // share of the cost that cutting off empty space is worth
    int leaf = 2;                    // no split is sought for so few triangles
    float depth_base = 8;            // deepest leaf: base + slope * log2(triangles)
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
    /// Keeps the state's scene; of `rays` it keeps nothing.
    CountingKdTree(const scene::SceneState& state, const RayScene& rays, const KdOptions& options = {});
    ~CountingKdTree();
    CountingKdTree(const CountingKdTree&) = delete;
    CountingKdTree& operator=(const CountingKdTree&) = delete;

    /// Follows one advance() of the state, after RayScene::update. Cost: nothing if nothing moved, else the dynamic
    /// objects' tree; the static tree only if a static object was moved by hand (it is dynamic from then on).
    void update(const scene::SceneState& state, const RayScene& rays);

    /// Whether something that blocks light lies past tnear, up to and with tfar. Thread-safe.
    bool occluded(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Against against,
                  KdCounts& counts) const;
    /// The nearest surface, transparent ones included; t is tfar where there is none. Thread-safe.
    Hit closest(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Sides sides,
                KdCounts& counts, Against against = Against::everything) const;

    /// The same by asking every triangle: the trees' slow twins.
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
