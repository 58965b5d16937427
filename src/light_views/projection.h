// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a light sees the scene: one square view of a spot or directional light, six of a point light, and where a box
// falls in such a view.
//
// Depth is reversed, 1 near to 0 far (perspective: near / distance along the axis, without a far plane), so that a
// float keeps the same relative precision at every distance. Texel (0, 0) is at clip (-1, -1), as Vulkan has it. A
// projection depends on the light and on the bounds of the whole clip alone, never on where things are or were: views
// are stable while the light stands still, and the image of a frame does not depend on the frames before it.
// A directional light has a second view where most of the scene fills a small part of it (a courtyard in a landscape):
// the first is fitted to that part. It does not follow the camera, so that it stands still with the light. Cost: a few
// matrix products.

#include <vector>

#include "light_views/rect.h"
#include "scene/state.h"

namespace gnomon::light_views {

struct ProjectionOptions {
    double near_fraction = 1e-4;   // near plane of spot and point lights, of the scene's diagonal
    double widest_spot = 1.2;      // half-angle in radians; wider ones see through the six faces of a point light
    double dense_gain = 2;         // directional: a second view if it brings so many times the texels a metre
    int border = 4;   // texels around what the light shines on: filters look there, and faces of a cube overlap by it
};

struct ViewProjection {
    glm::mat4 clip_from_world{1};   // the matrix that draws; compared in bits to find out whether the view changed
    // The ray of a texel at clip (x, y): perspective from `origin` along forward + x across + y down; else from origin
    // + x across + y down along forward. Distances along it are in units of its direction.
    glm::vec3 origin{0}, forward{0, 0, -1}, across{1, 0, 0}, down{0, 1, 0};
    bool perspective = true;
    float reach = 0;   // perspective: the distance where depth is 1 (near); else the one where it is 0, from the origin
    int size = 0;      // texels a side

    Rect whole() const { return {0, 0, size, size}; }
    bool same_bits(const ViewProjection& other) const;
    /// How far along a texel's ray a depth lies; infinite where nothing was drawn.
    float distance_of(float depth) const
    {
        if (depth <= 0) return k_infinity;
        return perspective ? reach / depth : (1 - depth) * reach;
    }
};

/// Where a scene is over its whole clip.
struct SceneBounds {
    Box3 whole;
    Box3 dense;   // where most triangles are
};

/// How many views a light has: 1; a directional one in a wide landscape 2; a point light 6. Depends on the scene alone.
int view_count(const scene::Light& light, const SceneBounds& bounds, const ProjectionOptions& options);

/// The views of a light, all of `size` texels a side; view_count() of them. Point lights: faces +x -x +y -y +z -z; two
/// views of a directional light: the dense part, then everything.
std::vector<ViewProjection> project(const scene::Light& light, const scene::LightState& state,
                                    const SceneBounds& bounds, int size, const ProjectionOptions& options);

/// Texels that anything inside a box may touch when it is drawn: a little larger than the box's image, so that neither
/// the rounding of vertices nor the driver's snapping to its sub-pixel grid can leave it. Empty if the box is outside.
/// @param to_world  from the box's space to the world
Rect footprint(const ViewProjection& view, const glm::mat4& to_world, const Box3& box);

/// How far along a view's `forward` from its origin something lies. Where one's `nearest` is beyond another's
/// `farthest`, no rounding of either, drawn, lets it hide the other.
struct DistanceRange {
    float nearest = k_infinity, farthest = -k_infinity;
};
DistanceRange distance_range(const ViewProjection& view, const glm::mat4& to_world, const Box3& box);

/// Around everything at the times of the clip's frames (at most `most_times` of them, evenly spread), hidden or not; a
/// function of the scene alone. Deforming meshes: rest shape and vertex keys.
SceneBounds clip_bounds(const scene::Scene& scene, int most_times = 256);

}   // namespace gnomon::light_views
