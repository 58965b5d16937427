// SPDX-License-Identifier: Apache-2.0
#pragma once
// Layers of metallic-roughness surfaces: clearcoat, sheen, thin films, brushed metal, and transmission through rough
// and thin surfaces (scene/material_layers.h). Formulas: Khronos glTF 2.0, extensions KHR_materials_clearcoat, sheen,
// iridescence, anisotropy, transmission, volume and dispersion.
//
// What a layer takes from those below depends on the view alone, so that it is one factor, SurfacePoint::coverage, for
// light of every kind. Directional albedos are at most 1: no energy is gained.

#include <vector>

#include "shading/shading.h"

namespace gnomon::shading {

/// What the layers of a surface reflect towards the viewer, per irradiance on a surface that faces the light: the lobes
/// of coat and sheen, their weights and the cosine included.
glm::vec3 reflect_layers(const SurfacePoint& s, const glm::vec3& to_light);

/// Distribution times visibility of the anisotropic GGX lobe, in place of the isotropic one's.
float anisotropic_lobe(const SurfacePoint& s, const glm::vec3& to_light);

/// The normal about which a layered surface mirrors: that of the base, bent across the grain of brushed surfaces.
glm::vec3 mirror_normal(const SurfacePoint& s);

/// The coat of a layered surface as a surface of its own, whose glossy lobe (glossy.h) is the coat's: it mirrors
/// LayerPoint::coat of the light from everywhere, and has nothing below.
SurfacePoint coat_surface(const SurfacePoint& s);

/// Fresnel reflectance of a coat of index 1.5.
float coat_fresnel(float cosine);

/// The fraction of light from everywhere that white fibres reflect towards the viewer; integrated numerically, at most
/// 1. The sheen lobe is scaled so that it reflects just that.
float sheen_albedo(float cosine, float roughness);

/// Reflectance of a surface below a thin film [Belcour and Barla 2017], per channel, 0 to 1.
/// @param f0          of the surface, at normal incidence
/// @param cosine      of the view
/// @param nanometres  the thin film's thickness
glm::vec3 thin_film_reflectance(const glm::vec3& f0, float cosine, float thin_film_ior, float nanometres);

/// A ray through a layered surface, and the part of Continuation::refracted_weight that it carries.
struct TransmittedRay {
    glm::vec3 direction;
    glm::vec3 part;
    float spread = 0;   // added to the growth of its cone
};
/// Finds the rays that continue through a layered surface. One for a sharp surface; three, one per channel, with
/// dispersion; a fixed set of directions, the same at every point, where the surface is rough, because random ones
/// would be noise.
/// @param split  the path was split before, by a rough surface: it continues as through a sharp one
void find_transmitted(const SurfacePoint& s, const Continuation& next, bool split, std::vector<TransmittedRay>& rays);

/// The part of light that is left after a distance inside a body of which a ray meets the surface from inside.
glm::vec3 attenuation(const SurfacePoint& s, float distance);

}   // namespace gnomon::shading
