// SPDX-License-Identifier: Apache-2.0
#pragma once
// A k-d tree that counts traversed nodes and ray-triangle tests. These figures do not depend on the machine, and papers
// on culling report them [Nah, Park and Han 2009, 5]. RayScene gives the same results far faster.
//
// Built from the scene's hierarchy [Hunt, Mark and Fussell 2007, 'Fast and Lazy Build of Acceleration Structures from
// Scene Hierarchies']: the upper splits lie at bounds of scene-graph nodes and objects, a few of which are open at a
// time. Below, where bounds gain little, the surface area heuristic is applied to single triangles.
//
// KdLayout::separate: static and dynamic triangles never share a node. The root has three children, each with a box and
// a tree of its own: what cannot change in the clip; what may, and rests now; and what is dynamic now
// (scene/mobility.h). The first tree is kept between frames, the second is rebuilt when an object starts or stops, the
// third in frames in which something changed. Rays against dynamic objects only enter the last child, or the last two.
//
// DEVIATION(Nah 2009, 2.4): there nodes are marked as free of dynamic primitives, and such traversal stops at them;
// with separate trees it stops at children of the root. KdLayout::hierarchy and mixed are one tree with such marks, as
// in Fig. 4 (a) and (b), and are built again in every frame in which something changed.
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

/// `hierarchy`: one tree over everything, split at bounds of the scene's hierarchy as long as a split reduces the cost.
/// `mixed`: one tree over everything, split by the surface area heuristic over triangles alone.
enum class KdLayout : std::uint8_t { separate, hierarchy, mixed };

struct KdOptions {
    KdLayout layout = KdLayout::separate;
    bool mobility_by_frame = false;   // false: every object that may change in the clip is dynamic in all frames
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

/// Of one tree over everything: `still` alone.
struct KdStatistics {
    KdTreeStatistics still, resting, moving;
};

class CountingKdTree {
 public:
    /// Keeps a reference to the state's scene, none to `rays`.
    CountingKdTree(const scene::SceneState& state, const RayScene& rays, const KdOptions& options = {});
    ~CountingKdTree();
    CountingKdTree(const CountingKdTree&) = delete;
    CountingKdTree& operator=(const CountingKdTree&) = delete;

    /// Follows one advance() of the state, after RayScene::update. Cost: nothing if nothing changed, else a build of
    /// the dynamic tree; of the static trees only after a promotion, or when an object started or stopped.
    void update(const scene::SceneState& state, const RayScene& rays)
    {
        follow(state);
        build(state, rays);
    }
    /// The two steps of update(). follow() must be called after every advance(), build() before the next ray.
    void follow(const scene::SceneState& state);
    void build(const scene::SceneState& state, const RayScene& rays);

    /// Whether an object is dynamic in this frame. With KdOptions::mobility_by_frame: it changes, or did recently.
    bool is_dynamic(scene::ObjectId object) const;

    /// Whether a surface that blocks light lies at a distance in (tnear, tfar]. Thread-safe.
    /// @param against  dynamic_only: those that may change in the clip
    /// @param occluder  optional; receives the object and triangle that was found, if its surface is opaque
    bool occluded(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar, Against against,
                  KdCounts& counts, Hit* occluder = nullptr) const;
    /// The same against those that are dynamic in this frame.
    bool occluded_by_dynamic(const glm::vec3& origin, float tnear, const glm::vec3& direction, float tfar,
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
