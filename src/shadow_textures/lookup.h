// SPDX-License-Identifier: Apache-2.0
#pragma once
// Determines whether a point of an object is in shadow, by a look-up in shadow textures: the CPU version of the
// shaders' lookup.glsl.
//
// A shadow texture marks the texels where its object is the nearest to the light [Oh and Shin 2004, 2].
// DEVIATION(Oh and Shin 2004, 2): with this test alone, no object would shadow itself, and an object would be dark
// along its rim where a texel's centre just misses it. So distances are compared in either case. Where the receiver is
// the nearest, only a surface that is nearer by a margin that a curved surface may need (`self_margin`) shadows it;
// where another object is the nearest, a small margin is enough (`other_margin`).
//
// Distances are compared at the texel's centre: the receiver's is that of its tangent plane there, so that no
// slope-dependent bias is needed. Cost: (N + 1)^2 texels for an edge filter of N texels, one for N = 0.
//
// With `as_printed`, the texture's colour alone decides, as in the paper: a point is lit by the part of the filter that
// is white. Where another object, or another part of the same one, lies within a texel, that is wrong; the device
// counts in how many results.

#include <optional>

#include "shadow_textures/software_textures.h"

namespace gnomon::shadow_textures {

struct LookupOptions {
    float filter = 1;        // width of the box filter for edges, in texels; 0: hard
    float self_margin = 1;   // in texel widths at the receiver
    float other_margin = 0.5f;
    bool as_printed = false;   // the colour of the receiver's texture decides, without comparing distances
};

/// The view of a light that contains a point; of two, the first.
/// @param views   of one light
/// @param border  of the projections, so that a filter at the edge of the lit part stays inside the view
const light_views::LightView* view_of(std::span<const light_views::LightView> views, const glm::vec3& point,
                                      int border = light_views::ProjectionOptions().border);

/// The place of a point in a view, in texels.
struct ViewPlace {
    glm::vec2 at{0};
    float own = 0;                // distance of the point along the view
    std::optional<float> known;   // its visibility where no texel is needed: behind its surface, or outside the view
};
ViewPlace place_in_view(const light_views::ViewProjection& view, const glm::vec3& point, const glm::vec3& normal);

/// The tangent plane of a point as the texels of a view meet it.
class SurfaceInView {
 public:
    SurfaceInView(const light_views::ViewProjection& view, const ViewPlace& place, const glm::vec3& point,
                  const glm::vec3& normal);
    /// The plane's distance along the view at a texel's centre, or the point's if that is nearer.
    float distance_at(int x, int y) const;
    /// The width of a texel at the point.
    float texel() const { return texel_; }

 private:
    const light_views::ViewProjection& view_;
    glm::vec3 normal_;
    float own_, texel_, above_;
};

/// Returns 1 if lit, 0 in shadow, values between them at a filtered edge. A point outside the view is lit.
/// @param normal  unit, geometric, on the visible side; a light behind it gives 0
float visibility(const light_views::ViewProjection& view, const light_views::SoftwareBuffer& buffer,
                 const glm::vec3& point, const glm::vec3& normal, scene::ObjectId object, const LookupOptions& options);

/// The same by the receiver's texture alone [Oh and Shin 2004, 2]: what LookupOptions::as_printed asks for.
float visibility_as_printed(const light_views::ViewProjection& view, const ReceiverTexture& texture,
                            const glm::vec3& point, const glm::vec3& normal, const LookupOptions& options);

}   // namespace gnomon::shadow_textures
