// SPDX-License-Identifier: Apache-2.0
#pragma once
// Selects the parts of triangles from which a surface point is interpolated where no lattice point reaches it.
//
// A triangle wider than the spacing is divided into parts (micro-triangles) of about that size. Smaller triangles share
// the points of the largest triangle of their cluster (triangle_clusters.h). One level of detail fades into the next.
// On dynamic objects, whose points live for one frame, a surface point is interpolated between the corners of parts, or
// between the points of the clusters around.

#include "irradiance_cache/cache_frame.h"

namespace gnomon::irradiance_cache {

/// Parts with their weights: four around a point, of two sizes; or a small triangle, two sizes of clusters, and two
/// sizes of slices; or two sizes of the clusters around the corners of a triangle, four each.
struct PartWeights {
    static constexpr int k_most = 24;
    AnchorKey key[k_most];
    float weight[k_most];
    int count = 0;
    void add(AnchorKey k, float w);
};

/// Parts of the point's triangle of about `spacing`, or those that represent the small triangles around it.
/// @param cluster_spacing  between the triangles that represent smaller ones
PartWeights select_parts(const CacheFrame& frame, const IndirectPoint& point, float spacing, float cluster_spacing);
/// The parts of near-field points: of a large triangle, those between which the point lies.
PartWeights select_near_parts(const CacheFrame& frame, const IndirectPoint& point);
/// select_parts() with the spacing for light from afar.
PartWeights select_far_parts(const CacheFrame& frame, const IndirectPoint& point);
/// Finer ones, for where those do not represent the pixel.
PartWeights select_finer_parts(const CacheFrame& frame, const IndirectPoint& point);
/// The finest ones, for a point of many whose mean is shown: of small triangles, those that represent the ones around.
PartWeights select_parts_of_mean(const CacheFrame& frame, const IndirectPoint& point);
/// Parts of the point's triangle around the pixel itself, so many pixels wide.
PartWeights select_pixel_parts(const CacheFrame& frame, const IndirectPoint& point, float pixels);

}   // namespace gnomon::irradiance_cache
