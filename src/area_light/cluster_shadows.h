// SPDX-License-Identifier: Apache-2.0
#pragma once
// Remembered shadows of a cluster of emitting polygons that rests (a sphere's side, the leaves of a light tree), for
// parts of static triangles:
//
//   unlit     the cluster lies behind the part
//   lit       no static triangle meets the shaft from the part to the box around the cluster, but for those that lie
//             behind all of its polygons: of each polygon that faces a point, all is visible
//   dark      one closed patch of static triangles lies between them: nothing of it is visible
//   open      anything else: rays decide
//
// An emitter's own triangles are occluders like others. Of a convex one, they lie behind all polygons of a cluster, so
// that the cluster is lit wherever nothing else is near. Masked triangles spoil a proof of light, and never prove a
// shadow. Dynamic objects are not regarded here.

#include <span>

#include "area_light/area_shadows.h"
#include "area_light/cluster_shaft.h"

namespace gnomon::area_light {

/// A static cluster of a frame.
struct Cluster {
    std::vector<LightPolygon> faces;
    bool two_sided = false;   // some face also emits at the back
};

/// The checks that the proofs rest on, one by one, so that tests can leave one out and see the errors.
enum class ClusterCheck : std::uint8_t {
    none,         // all are made
    behind_all,   // a triangle is left out only if it lies behind all faces, not just one
    clear_of_part,
    clear_of_cluster,
    no_open_edge,
    crosses,
};

class ClusterShadows final : public PartTree {
 public:
    /// @param triangles  kept by reference
    ClusterShadows(const visibility::StaticTriangles& triangles, const Cluster& cluster,
                   const AreaOptions& options = {}, ClusterCheck left_out = ClusterCheck::none);

    const Box3& box() const { return box_; }

 private:
    Verdict judge(visibility::TriangleId triangle, bool front, const MicroTriangle& part, std::uint32_t level,
                  const std::vector<visibility::TriangleId>* from) const override;
    bool makes(ClusterCheck check) const { return left_out_ != check; }
    bool is_dark(const Piece& piece, const ClusterShaft& shaft, std::span<const visibility::TriangleId> list) const;
    void find_behind(const Cluster& cluster);

    AreaOptions options_;
    ClusterCheck left_out_;
    Box3 box_;
    ClusterBox bounds_;
    std::vector<visibility::TriangleId> behind_;   // ascending: of triangles around the cluster, those behind all faces
};

}   // namespace gnomon::area_light
