// SPDX-License-Identifier: Apache-2.0
#pragma once
// How a surface answers light: Phong for AFF [Whitted 1980], GGX for glTF [Walter et al. 2007; Khronos glTF 2.0,
// appendix B], and what goes on as mirror and refracted rays.
//
// AFF's convention has no pi: radiance = diffuse * irradiance. Its images are pi times brighter than radiometry says,
// in all parts alike.

#include "shading/surface.h"

namespace gnomon::shading {

/// Radiance towards the viewer from light that arrives from one direction.
/// @param to_light    unit
/// @param irradiance  on a surface that faces the light
/// Black where the light is behind the geometric surface. Near the geometric horizon of a smooth-shaded surface the
/// light fades out, so that its facets do not show as a jagged terminator [Chiang et al. 2019].
glm::vec3 reflect_light(const SurfacePoint& s, const glm::vec3& to_light, const glm::vec3& irradiance);

/// The same from a light that stands for a part of the surroundings: diffuse alone, since mirror rays and
/// Continuation::unresolved_share bring the rest. With pi for AFF surfaces too: the surroundings are radiance.
glm::vec3 reflect_surroundings(const SurfacePoint& s, const glm::vec3& to_light, const glm::vec3& irradiance);

/// What stands in for light from everywhere: the sky's, unoccluded, and the scene's own for bounced light (AFF `am`).
/// @param stand_in  false where both are computed; then only AFF surfaces that answer no other light at all have any
glm::vec3 ambient_light(const SurfacePoint& s, const scene::Scene& scene, bool stand_in);

/// Rays that go on from a surface, each with the share of what it brings. A share of zero: no such ray.
struct Continuation {
    glm::vec3 reflected_share{0}, reflected{0};
    glm::vec3 refracted_share{0}, refracted{0};
    glm::vec3 straight_share{0};     // through the uncovered part of a BLEND surface
    glm::vec3 unresolved_share{0};   // mirror light of rough surfaces, taken from the background alone
};
Continuation continue_from(const SurfacePoint& s);

/// Radiance towards the viewer from light that comes from many directions, reflected diffusely.
/// @param indirect      irradiance from other surfaces
/// @param surroundings  irradiance from what lies behind everything, or shines by itself
/// What mirror rays and Continuation::unresolved_share bring is not given back again, for glTF surfaces. With pi for
/// AFF surfaces too: it is radiance that arrives.
glm::vec3 reflect_irradiance(const SurfacePoint& s, const Continuation& next, const glm::vec3& indirect,
                             const glm::vec3& surroundings);

/// Fresnel reflectance of unpolarised light at a dielectric boundary.
/// @param cosine  of the angle of incidence, 0 to 1
/// @param eta     index behind over index before; 1 on total reflection
float fresnel_dielectric(float cosine, float eta);

}   // namespace gnomon::shading
