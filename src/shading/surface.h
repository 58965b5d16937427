// SPDX-License-Identifier: Apache-2.0
#pragma once
// A hit made into a point to shade: position, normals, and the material with its textures looked up.
//
// Texture footprints follow ray cones [Akenine-Moller et al. 2021]: the ellipse in which the cone meets the surface.
// Cost: a vertex fetch per corner; per texture one trilinear look-up, or up to six where it is seen at a slant.

#include "ray/ray_scene.h"

namespace gnomon::shading {

/// The width a pixel's ray stands for, as it travels.
struct RayCone {
    float width = 0;    // scene units at the ray's origin
    float spread = 0;   // growth per unit of distance
};

struct SurfacePoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the side the ray came from
    glm::vec3 normal{0};             // unit, shading; on that side too
    glm::vec3 to_viewer{0};          // unit
    bool winding_front = true;   // that side is the world-space winding's front (differs from `front` under mirroring)
    bool front = true;           // the ray met the front
    float offset = 0;            // how far along the geometric normal a new ray must start (rounding of the position)
    RayCone cone;                // at the point

    // The material here. Diffuse: reflectance. Specular: mirror reflectance at normal incidence.
    scene::ShadingModel model = scene::ShadingModel::metallic_roughness;
    glm::vec3 diffuse{0};
    glm::vec3 specular{0};
    glm::vec3 ambient{0};   // whitted: ambient reflectance; else diffuse times occlusion
    glm::vec3 emissive{0};
    float roughness = 1;        // perceptual, metallic-roughness
    float shine = 0;            // Phong exponent, whitted
    float coverage = 1;         // alpha of BLEND surfaces: the rest passes straight on
    glm::vec3 transmitted{0};   // what refraction lets through, before Fresnel
    float ior = 1;              // inside over outside
};

/// @param direction  the ray's, unit
/// @param s          a fresh one; filled in place, since there is one for every hit
/// @param cone       at the ray's origin
void surface_at(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u,
                float v, float distance, const glm::vec3& direction, const RayCone& cone, SurfacePoint& s);

}   // namespace gnomon::shading
