// SPDX-License-Identifier: Apache-2.0
#pragma once
// Triangulates the round shapes of AFF with smooth normals [BART AFF, `s`, `c`].

#include "scene/mesh.h"

namespace gnomon::io {

/// The tessellation of round shapes.
struct AffShapeOptions {
    int sphere_segments = 48;   // around; at least 3
    int sphere_rings = 24;      // from pole to pole; at least 2
    int cone_segments = 48;     // around; at least 3
};

/// A sphere of radius 1 about the origin.
/// @param inside  front faces and normals point inwards
scene::Mesh make_unit_sphere(const AffShapeOptions& options, bool inside);

/// A cone or cylinder between two points, open at both ends. The points must differ; the radii must be at least 0 and
/// not both 0.
scene::Mesh make_cone(const AffShapeOptions& options, const glm::dvec3& base, double base_radius,
                      const glm::dvec3& apex, double apex_radius, bool inside);

}   // namespace gnomon::io
