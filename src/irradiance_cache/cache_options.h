// SPDX-License-Identifier: Apache-2.0
#pragma once
// Options and counters of the irradiance cache (irradiance_cache.h).

#include <cstddef>
#include <cstdint>

#include "irradiance_cache/light_tree/point_kernels.h"

namespace gnomon::irradiance_cache {

struct CacheOptions {
    LightTreeOptions light_tree;
    // Spacing of cache points on the screen, in pixels: the first where neighbours can be interpolated, down to the
    // second where they are separated by corners.
    float widest = 24, narrowest = 12;
    // Replaces the second where small triangles stand for a surface that curves.
    float narrowest_of_curve = 6;

    float level_blend = 0.3f;      // fraction of a level of detail over which it fades into the next
    float pixels_per_part = 6;     // size of small triangles of dynamic objects that are not divided, and of clusters
    float pixels_per_corner = 8;   // spacing of points on larger ones
    float pixels_per_leaf = 4;     // spacing of points on small triangles that no lattice fits: foliage, rods
    float pixels_per_finer = 4;    // the same where those do not represent the pixel: slices of slender triangles
    float pixels_per_own = 1;      // size of the part around the pixel itself, used where all other points are dark
    float pixels_per_closest = 0.125f;   // and of the part that takes its place where it is dark
    float pixels_per_mean = 2;           // spacing of the finest parts for points of which a mean is shown
    CutOptions cut;                      // of lattice points
    // Replace cut.error and cut.estimate for parts of static objects, which light a few pixels each,
    float part_error = 0.04f, part_estimate = 0.03f;
    // and for points on dynamic objects, because their cut is made again in every frame.
    float moving_error = 0.08f, moving_estimate = 0.05f;
    // Nodes of a longer cut whose visibility is tested (light_tree/tested_nodes.h): of lattice points, and of parts.
    // All of points on dynamic objects are.
    std::uint32_t tested = 512, tested_of_part = 128;
    std::size_t sky_parts = 8;        // of a direction of the sky at the edge of an opening (points/point_light.cpp)
    std::size_t sky_of_parts = 256;   // directions of the sky for parts of static objects (points/sky_light.h)
    // Near field (near_field/near_light.h): its radius, in mean widths of leaves of the light tree; how far it reaches
    // to wider leaves, in radii, and to any, in widths of the leaf at the lit place; and the spacing of lattice points,
    // in radii, up to which near-field points are between them.
    float near_radius = 2.8f, near_reach = 4, near_widths = 4, near_spacing = 1;
    float pixels_per_near = 2;           // spacing of near-field points,
    float pixels_per_near_cluster = 4;   // and of those that represent smaller triangles
    int near_rays = 64;
    float untested = 0.02f;   // light of dynamic objects below this fraction of a point's light is added without a ray
    // Bytes for cache points, or twice those of the last frame's points if that is more; and four times, where that is
    // no more than `ample_memory`. The points that were unused for longest are dropped first.
    std::size_t memory = 16u << 20, ample_memory = 1u << 30;
};

/// The options for so many diffuse bounces. More than one asks for a finer first bounce, too, or its errors would be
/// the largest: finer cuts, and most texels of light maps for suns.
/// @param emission  bounced light of emissive surfaces starts from patches, not from points that approximate them
inline CacheOptions options_for_bounces(int bounces, bool emission)
{
    CacheOptions options;
    options.light_tree.patches.bounces = bounces;
    options.light_tree.patches.emission = emission;
    options.light_tree.leaves = 3u << 16;
    if (bounces == 1) return options;
    options.light_tree.directional = 2.0f / 3;
    options.cut.error = 0.004f;
    options.part_error = 0.0125f;
    return options;
}

struct CacheCounters {
    std::uint64_t rays = 0;           // all visibility rays
    std::uint64_t rays_dynamic = 0;   // those cast for dynamic objects
    std::uint64_t new_points = 0, summed_points = 0;
    std::uint64_t near_points = 0;   // new near-field points; not counted in new_points
    std::uint64_t nodes = 0;         // visible nodes of new points
    void add(const CacheCounters& other)
    {
        rays += other.rays, rays_dynamic += other.rays_dynamic;
        new_points += other.new_points, summed_points += other.summed_points;
        near_points += other.near_points;
        nodes += other.nodes;
    }
};

}   // namespace gnomon::irradiance_cache
