// SPDX-License-Identifier: Apache-2.0
#pragma once
// The specular lobe of rough glTF surfaces, evaluated and sampled: GGX with the height-correlated masking of Smith
// [Walter et al. 2007; Khronos glTF 2.0, appendix B], visible normals sampled [Heitz 2018], and the energy that is lost
// between microfacets given back [Turquin 2019].
//
// shading.h reflects the light of points with the same lobe, without the energy given back.

#include <span>

#include "shading/surface.h"

namespace gnomon::shading {

/// Whether a surface has a lobe that is not a mirror: a rough metallic-roughness surface that reflects and does not
/// refract.
bool has_glossy_lobe(const SurfacePoint& s);

/// Radiance towards the viewer by light from one direction, for an irradiance of 1 on a surface that faces it: the
/// specular part of reflect_light(), with the lost energy given back. @pre has_glossy_lobe()
glm::vec3 reflect_glossy(const SurfacePoint& s, const glm::vec3& to_light);
/// A direction distributed as the visible normals reflect the viewer's; it may lie below the surface. u, v in [0, 1).
glm::vec3 sample_glossy(const SurfacePoint& s, float u, float v);
/// The density per steradian with which sample_glossy() returns a direction.
float glossy_density(const SurfacePoint& s, const glm::vec3& direction);
/// The fraction of light from everywhere that the lobe reflects to the viewer, coverage left out. What it leaves
/// reaches the diffuse layer below.
glm::vec3 glossy_albedo(const SurfacePoint& s);
/// The mean reflectance of the microfacets by which the lobe reflects light from everywhere to the viewer: from that of
/// one that faces it to that at grazing angles.
glm::vec3 mean_reflectance(const SurfacePoint& s);
/// The table that glossy_albedo() interpolates, for shaders (lobe_shared.h): row by row of roughness, from 0 to 1, by
/// the cosine of the view, from 0 to 1. With a reflectance of f0 at normal incidence, the albedo is f0 * x + y, before
/// the lost energy is given back.
std::span<const glm::vec2> glossy_albedo_table();

}   // namespace gnomon::shading
