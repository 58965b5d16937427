// SPDX-License-Identifier: Apache-2.0
#pragma once
// Groups of small triangles of a mesh, for scenes with so many triangles that patches cannot look at each of them.
//
// The triangles of a group are of one part of the mesh, face the same way, and lie close together: they are sorted by
// these, the last along a Morton curve, and cut into runs. One of a group represents it. All instances of a mesh share
// its groups.
//
// Cost: a sort of the triangles of each mesh. Memory: four bytes for each of them, twelve for each group.

#include <cstdint>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::patches {

struct TriangleGroups {
    struct Group {
        std::uint32_t triangle = 0;   // the one that represents it: in the middle of the run
        float area = 0;               // of all, in areas of this one
        float radius = 0;             // of a sphere around its centre that encloses all, in its longest edges
    };
    std::vector<Group> groups;
    std::vector<std::uint32_t> group_of;   // by triangle; none: it has no area, or does not block light
};

struct GroupOptions {
    std::uint32_t triangles = 8;   // of a group, at most
    float area = 0;                // of a group, in the space of the mesh, at most; unless it is one triangle
};

/// @param geometry  of one object that has the mesh; the groups are those of every other one at the same positions
TriangleGroups group_triangles(const scene::Scene& scene, const ray::ObjectGeometry& geometry,
                               const GroupOptions& options);

}   // namespace gnomon::patches
