// SPDX-License-Identifier: Apache-2.0
#ifndef GNOMON_LIGHT_QUADTREE_MAP_SHARED_H
#define GNOMON_LIGHT_QUADTREE_MAP_SHARED_H
// Structures for light maps, their trees and cuts in shaders. Layout: scalar.

#include "vk/shared_types.h"

GNOMON_SHARED_BEGIN(light_quadtree)

/// One view of a light (MapView), and its part to update.
struct GpuMapView {
    mat4 clip_from_world;
    mat4 near_clip;   // of the view whose part this one skips
    vec3 origin;
    uint light;
    vec3 forward;
    uint first;   // index of the first node
    vec3 across;
    uint levels;
    vec3 down;
    float depth_range;
    float cell;   // area of a texel, perpendicular to the ray, on the plane at `forward`
    uint perspective;
    uint leaves_out;
    uint on;
    uint dirty[4];   // texels x0, y0, x1, y1; empty if nothing changed
};

/// Like LightNode.
struct GpuNode {
    vec3 position, normal;
    float depth, area;
    vec3 flux;
    uint members;
};

/// One light of the cut, like Clusters.
struct GpuCluster {
    vec3 position;
    float disk;
    vec3 normal;
    float red, green, blue;
    uint node, grid;
};

/// For drawing a view's ids.
struct MapDrawPush {
    mat4 clip_from_world;
};

/// For computing texels from ids.
struct TexelPush {
    uint view;
    float least_cosine;
};

/// For computing one level of nodes.
struct NodePush {
    uint level;
    float depth_threshold, normal_threshold, margin;
};

// A node's whole share of the light: k_whole_share.
#define GNOMON_WHOLE_SHARE 255u

/// For the levels of the cut as an image, for the gather as printed.
struct LevelsPush {
    uint views, start, limit;
};

/// For the cut: a work group for each level and view.
struct CutPush {
    uint views, start, limit;
    uint write;   // 0: count
};

// Nodes per row of the image of the cut's levels, three texels each.
#define GNOMON_NODES_A_ROW 1024u

// Clusters per row of the image that the gather reads, three texels each.
#define GNOMON_CLUSTERS_A_ROW 1024u

// Pixels per invocation of gathering clusters.
#define GNOMON_CLUSTERS_ACROSS 4
#define GNOMON_CLUSTERS_DOWN 2

// Samples per row of the pattern's image.
#define GNOMON_SAMPLES_A_ROW 1024u

// Pixels per invocation of sampling.
#define GNOMON_SAMPLES_ACROSS 4
#define GNOMON_SAMPLES_DOWN 2

/// For copying the map's texels to an image.
struct MapImagePush {
    uint all;   // 0: only the changed part
};

/// For gathering.
struct GatherPush {
    vec3 eye;
    float pixel_width, pixel_spread;
    uint width, height;         // of the image
    uint step, columns, rows;   // of the grid; step 0: none
    uint fill_grid;             // 0: light the points
    uint listed;   // 1: points are a list, and position.w is a point's pixel, from 1; 0: they are the image
    float grid_normals, grid_off_plane;
    uint grid_neighbours;
    uint views, samples;        // samples: per view
    uint total;                 // of the cut: index of the number of clusters
    uint level, start, limit;   // as printed: the level of this pass, and those of the cut
};

#ifdef __cplusplus
GNOMON_MEMBERS(GpuMapView, clip_from_world, near_clip, origin, light, forward, first, across, levels, down, depth_range,
               cell, perspective, leaves_out, on, dirty)
GNOMON_MEMBERS(GpuNode, position, normal, depth, area, flux, members)
GNOMON_MEMBERS(GpuCluster, position, disk, normal, red, green, blue, node, grid)
GNOMON_MEMBERS(MapDrawPush, clip_from_world)
GNOMON_MEMBERS(TexelPush, view, least_cosine)
GNOMON_MEMBERS(NodePush, level, depth_threshold, normal_threshold, margin)
GNOMON_MEMBERS(LevelsPush, views, start, limit)
GNOMON_MEMBERS(CutPush, views, start, limit, write)
GNOMON_MEMBERS(MapImagePush, all)
GNOMON_MEMBERS(GatherPush, eye, pixel_width, pixel_spread, width, height, step, columns, rows, fill_grid, listed,
               grid_normals, grid_off_plane, grid_neighbours, views, samples, total, level, start, limit)
#endif

GNOMON_SHARED_END
#endif
