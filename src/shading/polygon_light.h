// SPDX-License-Identifier: Apache-2.0
#pragma once
// Light with size at a surface point, without occlusion: in closed form for planar polygons, and point by point for the
// sample places of a light (scene/sized_light.h).
//
// Diffuse: the polygon is clipped at the horizons of the geometric and of the shading normal; its irradiance is
// Lambert's sum over the edges of what is left [Lambert 1760; Baum et al. 1989], cell by cell where the emission is
// textured. Glossy: the same sum after the transform of a linearly transformed cosine (transformed_cosines.h), times
// the reflectance towards what the lobe sees of the polygon, by its mean: a dielectric seen at a slant reflects ten
// times as much of what is low as of what is high. A polygon that is all that the lobe sees has the mean. Of a
// light with many faces, groups that are far for their size count as one small disc (scene/face_tree.h), for a lobe
// those that are so in the space in which it is a cosine.
//
// How much of the light is visible is a ratio of sums: the weights of the visible places over those of all places. The
// ratio estimator has no error where all or nothing is visible, whatever the places.
//
// In double precision, because a form factor below 1e-4 loses its last digits in single precision.
// Cost: some 20 ns for each edge of a face or cell.

#include "scene/sized_light.h"
#include "shading/surface.h"

namespace gnomon::shading {

struct PolygonLightOptions {
    // A light that is farther away than this many radii is summed over its sample places, if it has fewer of them than
    // faces, or than cells of a texture.
    float far = 4;
    // Groups of the faces of a light that has many of them are larger, and single faces count as discs: for points of
    // which many are averaged.
    bool coarse = false;
    // Lobes are widened to this roughness at least for the ratio of visible weights, because the places of a light
    // cannot resolve a sharper one.
    float least_roughness = 0.25f;
};

/// A light as a point sees it, without occlusion.
struct UnshadowedLight {
    glm::vec3 irradiance{0};   // on the shading normal's plane
    glm::vec3 lobe{0};         // radiance that the glossy lobe reflects to the viewer, for has_glossy_lobe() surfaces
};

/// The lobe of a surface point in world space, for unshadowed(): it is the same for all lights.
struct PolygonLobe {
    glm::dmat3 to_cosine{1};
    glm::dmat3 areas_to_cosine{1};   // of vectors of area
    double stretch = 1;              // no vector becomes longer than that many times
    double rise = 1;                 // nor does its height above the horizon by more than that many of its lengths
    double scale = 1;
    glm::vec3 albedo{0};             // coverage included
    glm::dmat3 from_cosine{1};       // the inverse of the first
    glm::vec3 to_viewer{0}, f0{0};   // of the point, with the reflectance of what faces the viewer
    float f90 = 1;                   // and at grazing angles
    glm::dvec3 mean{1};              // reflectance of all of the lobe

    /// Reflectance of light from a direction of any length by the mean of what the lobe reflects.
    /// @param share  of the lobe that comes from around there
    glm::dvec3 by_mean(const glm::dvec3& direction, double share) const;

    /// @pre has_glossy_lobe(s)
    explicit PolygonLobe(const SurfacePoint& s);
};

/// Light that reaches a point if nothing occludes it.
/// @param lobe  of the surface, if it is asked for as well; else null
UnshadowedLight unshadowed(const SurfacePoint& s, const scene::SizedLight& light, const PolygonLobe* lobe,
                           const PolygonLightOptions& options = {});
/// @param lobe  whether the surface's lobe is asked for as well
UnshadowedLight unshadowed(const SurfacePoint& s, const scene::SizedLight& light, bool lobe,
                           const PolygonLightOptions& options = {});

/// The same as the sum over some places of the light, each with its area: for light from afar, and lobes that are wide
/// beside the distances of the places.
UnshadowedLight unshadowed_by_places(const SurfacePoint& s, const scene::SizedLight& light,
                                     std::span<const scene::SizedPlace> places, bool lobe);

/// How much of a light's contributions is left if only some of its places are visible.
struct VisibleShare {
    glm::vec3 irradiance{0}, lobe{0};   // fractions, 0 to 1
};
/// @param places  of the light, by which visibility is known; `seen` says how much of each is visible, up to `whole`
VisibleShare visible_share(const SurfacePoint& s, const scene::SizedLight& light,
                           std::span<const scene::SizedPlace> places, std::span<const std::uint8_t> seen, int whole,
                           bool lobe, const PolygonLightOptions& options = {});

}   // namespace gnomon::shading
