// SPDX-License-Identifier: Apache-2.0
#pragma once
// Is this point of this object in shadow? The look-up in shadow textures, as the shaders do it (lookup.glsl) and as its
// twin does it here.
//
// A shadow texture says where its object is the one nearest the light [Oh and Shin 2004, 2]; black elsewhere.
// DEVIATION(Oh and Shin 2004, 2): no object would shadow itself, and an object's rim would be black where the texel's
// centre just misses it. So distances are compared in either case: where the receiver is the nearest, only what lies
// nearer by a margin that a curved surface may need (`self_margin`) shadows it; where something else is, a small margin
// is enough (`other_margin`).
//
// Distances are compared at the texel's centre: the receiver's is that of its tangent plane there, so that no slope
// needs a bias. Cost: (N + 1)^2 texels for an edge filter of N texels, one for N = 0.

#include "light_views/software.h"

namespace gnomon::shadow_textures {

struct LookupOptions {
    float filter = 1;        // width of the box that softens edges, in texels; 0: hard
    float self_margin = 1;   // in widths of a texel at the receiver
    float other_margin = 0.5f;
};

/// Which of a light's views sees a point, and where in it.
/// @param views   of one light; of two that see the point the first is taken
/// @param border  of the projections: a filter at the rim of what a view shines on stays inside
const light_views::LightView* view_of(std::span<const light_views::LightView> views, const glm::vec3& point,
                                      int border = light_views::ProjectionOptions().border);

/// 1 lit, 0 in shadow, in between at a softened edge. A point outside the view is lit.
/// @param normal  unit, geometric, on the side that is looked at; a light behind it gives 0
float visibility(const light_views::ViewProjection& view, const light_views::SoftwareBuffer& buffer,
                 const glm::vec3& point, const glm::vec3& normal, scene::ObjectId object, const LookupOptions& options);

}   // namespace gnomon::shadow_textures
