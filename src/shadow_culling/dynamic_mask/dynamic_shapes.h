// SPDX-License-Identifier: Apache-2.0
#pragma once
// What never changes about the shape of an object that moves: which of its triangles block light, which of them share
// an edge, and over which of them nothing of the object itself rises.
//
// Rigid objects' corners are the same place when their bits agree; of a deforming object, when they have one index.
// Built once; the cost is that of sorting the edges, and for small rigid objects triangles times corners.

#include <cstdint>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::shadow_culling {

struct DynamicShape {
    struct Edge {
        std::uint32_t a, b;           // corners, into `vertex`
        std::uint32_t first, count;   // of its triangles, into `sides`
    };
    struct Side {
        std::uint32_t triangle;   // into `triangle`
        bool forward;             // it goes round by way of a to b
    };
    std::vector<std::uint32_t> vertex;   // of the mesh, one for each place
    std::vector<glm::uvec3> triangle;    // opaque ones, into `vertex`
    std::vector<Edge> edge;
    std::vector<Side> sides;
    std::vector<std::uint32_t> masked_vertex;   // of alpha-tested triangles, into the mesh

    /// By triangle of the mesh and side (2 * triangle + (front ? 0 : 1)): how far the object rises above that side;
    /// empty where that is not known. Front by winding, both in the object's own space.
    std::vector<float> rise;

    bool blocks() const { return !triangle.empty() || !masked_vertex.empty(); }
};

DynamicShape shape_of(const scene::Scene& scene, const ray::ObjectGeometry& geometry, bool deforming);

}   // namespace gnomon::shadow_culling
