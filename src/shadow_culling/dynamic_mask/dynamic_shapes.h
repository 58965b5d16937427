// SPDX-License-Identifier: Apache-2.0
#pragma once
// The constant properties of a dynamic object's shape: which triangles block light, which of them share an edge, and
// how far the object rises above each triangle's plane.
//
// Two corners of a rigid object are the same vertex if their bits agree; of a deforming one, if their indices do. Built
// once. Cost: sorting the edges, and for small rigid objects triangles times corners.

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
        bool forward;             // its winding goes from a to b
    };
    std::vector<std::uint32_t> vertex;   // of the mesh, one for each position
    std::vector<glm::uvec3> triangle;    // opaque ones, into `vertex`
    std::vector<Edge> edge;
    std::vector<Side> sides;
    std::vector<std::uint32_t> masked_vertex;   // of alpha-tested triangles, into the mesh

    /// How far the object rises above each side of each triangle of the mesh (2 * triangle + (front ? 0 : 1)); empty if
    /// not known. Heights and the front, which is that of the winding, are in the object's own space.
    std::vector<float> rise;

    bool blocks() const { return !triangle.empty() || !masked_vertex.empty(); }
};

DynamicShape shape_of(const scene::Scene& scene, const ray::ObjectGeometry& geometry, bool deforming);

}   // namespace gnomon::shadow_culling
