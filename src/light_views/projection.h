// SPDX-License-Identifier: Apache-2.0
#pragma once
// Projections of light views: one square view for a spot or directional light, six for a point light, five for the half
// of a cube that a place on a surface lights; and the texels of a view that a box covers.
//
// Depth is reversed, from 1 near to 0 far (perspective: near / distance along the axis, without a far plane), so floats
// keep the same relative precision at every distance. Texel (0, 0) is at clip (-1, -1), as in Vulkan. A projection
// depends only on the light and on the bounds of the scene (scene/scene_bounds.h), which follow the positions of
// objects only where overrides take them outside. So views are stable while the light rests, and a frame does not
// depend on earlier frames.
//
// A directional light has a second view if most of the scene fills a small part of the first (a courtyard in a
// landscape); that view is fitted to this part. Views do not follow the camera, so they rest while the light does.
// Cost: a few matrix products.

#include <vector>

#include "light_views/rect.h"
#include "scene/state.h"

namespace gnomon::light_views {

struct ProjectionOptions {
    double near_fraction = 1e-4;   // near plane of spot and point lights, as a fraction of the scene's diagonal
    double widest_spot = 1.2;      // half-angle in radians; wider spots use the six faces of a point light
    bool half_cubes = false;       // wider spots use five views of the half space before them instead
    double dense_gain = 2;         // directional: use a second view if it has this many times the texels per metre
    double widening = 0;           // directional: each view is at most so many times as wide as the one before; 0: any
    int border = 4;                // texels around the lit part: filters read them, and faces of a cube overlap by them
};

struct ViewProjection {
    glm::mat4 clip_from_world{1};   // the matrix for drawing; compared bitwise to detect changes of the view
    // The ray of a texel at clip (x, y). Perspective: from `origin` along forward + x across + y down. Orthographic:
    // from origin + x across + y down along forward. Distances along it are in units of its direction.
    glm::vec3 origin{0}, forward{0, 0, -1}, across{1, 0, 0}, down{0, 1, 0};
    bool perspective = true;
    float reach = 0;   // perspective: the distance of depth 1 (near); otherwise the distance of depth 0 from the origin
    int size = 0;      // texels a side

    Rect whole() const { return {0, 0, size, size}; }
    bool same_bits(const ViewProjection& other) const;
    /// The distance along a texel's ray of a depth; infinite where nothing was drawn.
    float distance_of(float depth) const
    {
        if (depth <= 0) return k_infinity;
        return perspective ? reach / depth : (1 - depth) * reach;
    }
};

using scene::SceneBounds;

/// The number of views of a light: 1; 2 for a directional one in a wide landscape, or more (widening); 5 or 6 for a
/// wide spot (half_cubes), 6 for a point light.
int view_count(const scene::Light& light, const SceneBounds& bounds, const ProjectionOptions& options);

/// The view_count() views of a light, all with `size` texels a side. Point lights: faces +x -x +y -y +z -z; two or
/// more views of a directional light: the dense part, then wider ones that contain the one before, then everything;
/// half cubes: the top, whose `across` and `down` are the axes s and t, then the sides +s -s +t -t.
std::vector<ViewProjection> project(const scene::Light& light, const scene::LightState& state,
                                    const SceneBounds& bounds, int size, const ProjectionOptions& options);

/// The texels that drawing anything inside a box may touch: slightly larger than its projection, to allow for rounding
/// of vertices and for the driver's snapping to its sub-pixel grid. Empty if the box is outside the view.
/// @param to_world  transforms the box to world space
Rect footprint(const ViewProjection& view, const glm::mat4& to_world, const Box3& box);

/// Range of distances of an object along a view's `forward` from its origin. If `nearest` of one object exceeds
/// `farthest` of another, it cannot hide the other in a drawn buffer, whatever the rounding.
struct DistanceRange {
    float nearest = k_infinity, farthest = -k_infinity;
};
DistanceRange distance_range(const ViewProjection& view, const glm::mat4& to_world, const Box3& box);

}   // namespace gnomon::light_views
