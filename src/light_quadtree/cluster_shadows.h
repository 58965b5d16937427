// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sum over clusters with shadows: each cluster is a light, occluded by a ray from the receiver to its mean
// position. The published method ignores visibility [Ki and Oh 2007, 7], which its error against a reference consists
// of.
//
// Clusters stay where they are while the light and what it shines on rest. For receivers that stay as well (the sparse
// ones, while the view rests), what static geometry does to the path from receiver to cluster is remembered, as shadow
// culling remembers it for a light [Nah et al. 2009, 2.3]: NON_SHADOW, after which only dynamic objects are tested, or
// FULL_SHADOW, after which nothing is. Both are proven, because neither end of the path has moved by a bit.
//
// Known flaw: a cluster is visible as a whole or not at all, so the edges of its shadow are hard. Cost: a ray per
// receiver and cluster that faces it; a byte per remembered pair.

#include <unordered_map>

#include "light_quadtree/gather.h"
#include "ray/ray_scene.h"

namespace gnomon::light_quadtree {

/// Pairs of a receiver and a cluster that face each other.
struct ShadowCounters {
    std::uint64_t rays = 0;                // pairs
    std::uint64_t rays_skipped = 0;        // of these, known to be occluded by static geometry
    std::uint64_t rays_dynamic_only = 0;   // of these, traced against dynamic objects alone
};

enum class PathMode : std::uint8_t { unknown, non_shadow, full_shadow };

/// The modes of the paths from a set of receivers to the clusters of a cut.
class PathModes {
 public:
    /// Carries over the modes of paths of which neither end has moved; all others become unknown.
    void follow(const Clusters& clusters, const Receivers& receivers);
    void clear() { *this = PathModes(); }
    PathMode& mode(std::size_t cluster, std::size_t receiver) { return modes_[cluster * receivers_ + receiver]; }
    std::size_t bytes() const { return modes_.size(); }

 private:
    std::vector<PathMode> modes_;   // by cluster and receiver
    std::size_t receivers_ = 0;
    std::vector<glm::vec3> position_, normal_;             // of the receivers
    std::unordered_map<std::size_t, std::size_t> found_;   // node of the tree to cluster
    std::vector<glm::vec3> cluster_position_;
};

struct ShadowScratch {
    ray::RayQueue queue;
    std::vector<std::uint32_t> receiver;   // by ray
    std::vector<std::uint8_t> occluded;
    ShadowCounters counters;
};

/// Whether a receiver sees a cluster that it faces: the reference of a single pair, and false if they face away.
bool cluster_visible(const Clusters& clusters, std::size_t cluster, const glm::vec3& position, const glm::vec3& normal,
                     const ray::RayScene& rays);

/// As gather(), with shadows. @param modes  of these receivers; null: nothing is remembered
void gather_with_shadows(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end,
                         const ray::RayScene& rays, PathModes* modes, ShadowScratch& scratch);

}   // namespace gnomon::light_quadtree
