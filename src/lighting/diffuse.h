// SPDX-License-Identifier: Apache-2.0
#pragma once
// The diffuse reflectance of a surface, for bounced light.

#include "ray/ray_scene.h"

namespace gnomon::lighting {

/// Ratio of radiant exitance to irradiance at a point of a triangle, by colour channel: the albedo, or pi times that
/// for AFF surfaces, whose convention has no pi (shading/shading.h). Textures are sampled at full resolution.
glm::vec3 exitance_per_irradiance(const scene::Scene& scene, const ray::ObjectGeometry& geometry,
                                  std::uint32_t triangle, float u, float v);

/// Ratio of radiant exitance to irradiance in radiometric units: what a surface reflects of light that has bounced
/// before, of lights with size and of the sky. The albedo for every material.
glm::vec3 albedo(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u,
                 float v);

}   // namespace gnomon::lighting
