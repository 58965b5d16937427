// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a light sees the scene: one square view of a spot or directional light, six of a point light, and where a box
// falls in such a view.
//
// Depth is reversed, 1 near to 0 far (perspective: near / distance along the axis, without a far plane), so that a
// float keeps the same relative precision at every distance. Texel (0, 0) is at clip (-1, -1), as Vulkan has it. A
// projection depends on the light and on the bounds of the whole clip alone, never on where things are or were: views
// are stable while the light stands still, and the picture of a frame does not depend on the frames before it.
// Cost: a few matrix products.

#include <vector>

#include "light_views/rect.h"
#include "scene/state.h"

namespace gnomon::light_views {

struct ProjectionOptions {
    double near_fraction = 1e-4;   // near plane of spot and point lights, of the scene's diagonal
    double widest_spot = 1.2;      // half-angle in radians; wider ones see through the six faces of a point light
    int border = 4;   // texels around what the light shines on: filters look there, and faces of a cube overlap by it
};

struct ViewProjection {
    glm::mat4 clip_from_world{1};   // the matrix that draws; compared in bits to find out whether the view changed
    glm::vec3 eye{0};               // perspective: the light's place; else the direction towards the light
    bool perspective = true;
    float near = 0;   // perspective: distance along the axis where depth is 1
    int size = 0;     // texels a side

    Rect whole() const { return {0, 0, size, size}; }
    bool same_bits(const ViewProjection& other) const;
};

/// How many views a light has: 1 or 6. Depends on the light alone.
int view_count(const scene::Light& light, const ProjectionOptions& options);

/// The views of a light, all of `size` texels a side; view_count() of them, point faces in order +x -x +y -y +z -z.
/// @param bounds  what directional lights must see: see clip_bounds()
std::vector<ViewProjection> project(const scene::Light& light, const scene::LightState& state, const Box3& bounds,
                                    int size, const ProjectionOptions& options);

/// Texels that anything inside a box may touch when it is drawn: a little larger than the box's image, so that neither
/// the rounding of vertices nor the driver's snapping to its sub-pixel grid can leave it. Empty if the box is outside.
/// @param to_world  from the box's space to the world
Rect footprint(const ViewProjection& view, const glm::mat4& to_world, const Box3& box);

/// Around everything at the times of the clip's frames (at most `most_times` of them, evenly spread), hidden or not; a
/// function of the scene alone. Deforming meshes: rest shape and vertex keys.
Box3 clip_bounds(const scene::Scene& scene, int most_times = 256);

}   // namespace gnomon::light_views
