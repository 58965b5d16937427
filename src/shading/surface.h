// SPDX-License-Identifier: Apache-2.0
#pragma once
// Converts a hit to a shading point: position, normals, and the material with its textures sampled.
//
// Texture footprints follow ray cones [Akenine-Moller et al. 2021]: the ellipse in which the cone intersects the
// surface. Cost: a vertex fetch per corner; per texture one trilinear look-up, or up to six where the surface is seen
// at a slant.

#include "ray/ray_scene.h"

namespace gnomon::shading {

/// The width of a pixel's ray cone.
struct RayCone {
    float width = 0;    // scene units at the ray's origin
    float spread = 0;   // growth per unit of distance
};

/// The layers of a material at a point (scene/material_layers.h).
struct LayerPoint {
    float coat = 0;   // the fraction of light that the coat mirrors towards the viewer
    float coat_roughness = 0;
    glm::vec3 coat_normal{0};
    glm::vec3 sheen{0};   // colour of the fibres, above the base and below the coat
    float sheen_roughness = 0;
    float sheen_albedo = 0;   // what white fibres reflect towards the viewer of light from everywhere
    glm::vec3 grain{0};       // unit, on the surface: the lobe is wider along it. Of no use without the next
    float anisotropy = 0;
    bool thin = false;         // transmitted light passes straight
    glm::vec3 absorption{0};   // per metre inside
    float thickness = 0;       // metres: see MaterialLayers
    float dispersion = 0;
};

struct SurfacePoint {
    glm::vec3 position{0};
    glm::vec3 geometric_normal{0};   // unit, on the side the ray came from
    glm::vec3 normal{0};             // unit, shading; on that side too
    // Unit: the normal of the smooth horizon (ray/smooth_surface.h), without a normal map; on that side too. Without
    // vertex normals, the geometric one.
    glm::vec3 smooth_normal{0};
    glm::vec3 to_viewer{0};      // unit
    bool winding_front = true;   // that side is the front by world-space winding (differs from `front` under mirroring)
    bool front = true;           // the ray hit the front
    bool catches_shadows = false;   // see scene::Material
    float offset = 0;               // distance along the geometric normal at which new rays start (rounding)
    RayCone cone;                   // at the point

    // The material at the point. Diffuse: reflectance. Specular: mirror reflectance at normal incidence.
    scene::ShadingModel model = scene::ShadingModel::metallic_roughness;
    glm::vec3 diffuse{0};
    glm::vec3 specular{0};
    glm::vec3 ambient{0};   // whitted: ambient reflectance; else diffuse times occlusion
    glm::vec3 emissive{0};
    float roughness = 1;   // perceptual, metallic-roughness
    float shine = 0;       // Phong exponent, whitted
    // The fraction of its own light that the surface shows: alpha of BLEND surfaces, less what layers above take.
    float coverage = 1;
    float uncovered = 0;        // 1 - alpha of BLEND surfaces: of light that passes straight through
    float f90 = 1;              // specular reflectance at grazing incidence
    bool layered = false;       // `layers` counts
    glm::vec3 transmitted{0};   // transmittance of refraction, before Fresnel
    float ior = 1;              // inside over outside
    LayerPoint layers;
};

/// @param direction  the ray's, unit
/// @param s          default-constructed; filled in place to avoid a copy per hit
/// @param cone       at the ray's origin
void surface_at(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u,
                float v, float distance, const glm::vec3& direction, const RayCone& cone, SurfacePoint& s);

/// The reflectance of a triangle at several places, as surface_at() finds it there, without the rest of the surface.
/// Its material has no layers.
class TriangleReflectance {
 public:
    TriangleReflectance(const scene::Scene& scene, const ray::ObjectGeometry& geometry, std::uint32_t triangle);
    const glm::vec3 (&corners() const)[3] { return corners_; }
    /// @param s  `model`, `diffuse` and `specular` are filled in; what else changes is undefined
    void find(float u, float v, float distance, const glm::vec3& direction, const RayCone& cone, SurfacePoint& s) const;

 private:
    const scene::Scene& scene_;
    const ray::ObjectGeometry& geometry_;
    const scene::Material& material_;
    glm::uvec3 index_;
    glm::vec3 corners_[3];
    float double_area_;
    glm::vec3 outward_;
};

/// Where rays to directions between the horizon of the triangle and the smooth one start (ray/smooth_surface.h). Other
/// rays start at the surface, at SurfacePoint::offset.
/// @param s  the surface at the hit
glm::vec3 smooth_origin(const ray::ObjectGeometry& geometry, std::uint32_t triangle, float u, float v,
                        const SurfacePoint& s);

/// Whether a direction is above the smooth horizon and below the triangle's.
inline bool between_horizons(const SurfacePoint& s, const glm::vec3& direction)
{
    return glm::dot(s.smooth_normal, direction) > 0 && !(glm::dot(s.geometric_normal, direction) > 0);
}

}   // namespace gnomon::shading
