// SPDX-License-Identifier: Apache-2.0
#pragma once
// What points of a frame see of clusters of emitting polygons, as far as remembered shadows of the static scene tell
// (cluster_shadows.h). Rays decide the rest.
//
// The answer to a point does not depend on what was remembered, nor on the order of questions. If what is remembered
// grows beyond AreaOptions::most_bytes, all of it is forgotten.

#include <memory>
#include <span>
#include <vector>

#include "area_light/area_visibility.h"
#include "area_light/cluster_shadows.h"
#include "scene/sized_light.h"

namespace gnomon::area_light {

/// A cluster of lights with size that rests (SizedLight::is_flat is false).
Cluster cluster_of(const scene::SizedLight& light);

class ClusterVisibility {
 public:
    explicit ClusterVisibility(const AreaOptions& options = {}) : options_(options) {}

    /// All clusters that rest, in any order: what is remembered of one that has the same polygons as before is kept.
    /// Call when they change.
    /// @param occluders  kept by reference until the next call
    void set(const AreaVisibility& occluders, std::vector<Cluster> clusters);
    /// Follows a frame, after the occluders did.
    void follow();

    enum class Answer : std::uint8_t {
        dark,          // nothing of it is visible
        lit,           // all of it that faces the point is
        lit_at_rest,   // static objects hide nothing of it, dynamic ones may
        unknown,
    };
    /// Scratch memory of one thread.
    struct Scratch {
        std::vector<Answer> answer;     // by asked point
        std::vector<PartState> state;   // by asked point: of its part; open where none is remembered
        std::uint64_t points[5] = {};   // by PartState, of static points, of all calls

     private:
        friend class ClusterVisibility;
        std::vector<std::uint32_t> boxes;
        PartTree::LastPart last;
    };
    /// Finds what points see of a cluster. Thread-safe.
    /// @param asked  indices of points
    void find(Scratch& scratch, std::span<const visibility::ShadowPoint> points, std::span<const std::uint32_t> asked,
              std::size_t cluster) const;

    /// Sums over the clusters' remembered parts.
    AreaCounters parts() const;
    std::size_t bytes() const;

 private:
    struct Known {
        Cluster cluster;
        std::unique_ptr<ClusterShadows> shadows;
    };
    AreaOptions options_;
    const AreaVisibility* occluders_ = nullptr;
    std::uint64_t version_ = 0;   // of the static triangles
    std::vector<Known> known_;
};

}   // namespace gnomon::area_light
