// SPDX-License-Identifier: Apache-2.0
#pragma once
// A cache point: a place on a surface and the irradiance that arrives there.
//
// What a point holds is a function of its key, the scene and the frame, so it does not matter which thread evaluates
// it. Claims between threads: point_claims.h.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "irradiance_cache/light_tree/point_kernels.h"
#include "irradiance_cache/points/anchors.h"
#include "irradiance_cache/points/sky_light.h"

namespace gnomon::irradiance_cache {

inline constexpr std::uint32_t k_no_owner = scene::none;   // of points on static objects

struct CachePoint {
    AnchorKey key = 0;
    bool exists = false;        // the key's place lies on a surface
    bool queued = false;        // waits for evaluation by a PointDevice
    bool covered = false;       // parts of static objects: other geometry lies on it
    bool covered_now = false;   // of static objects: a dynamic one stands on it, or is close to it all around
    bool local = false;         // lattice points: their light holds for nothing around (StaticVisibility::find_local)
    bool steep = false;         // lattice points: their light changes within a spacing, as at the foot of a wall
    bool near_light = false;    // static_light includes light of a near field (near_field/near_of_points.h):
    glm::vec3 static_near{0}, near{0};   // its irradiance by colour, without dynamic objects and now
    float near_factor = 0;   // lattice and near-field points: the form factor of the surfaces of their near field
    float brightness = 0;    // lattice points: luminance of their static light, its near field aside;
    float sky_light = 0;     // and of this, the sky's
    float lift = 0;          // distance from the surface at which rays start
    glm::vec3 position{0};   // on the surface
    glm::vec3 normal{0};     // unit, shading
    glm::vec3 geometric_normal{0};
    glm::vec3 horizon{0};       // unit: light comes from above its plane (ray/smooth_surface.h)
    glm::vec3 smooth_lift{0};   // from the position to the smooth surface
    // Lattice points: free distance along the lattice's axes, -b +b -c +c; and how much shorter it gets per unit along
    // the other axis, because the surface that ends it stands at an angle. Near-field points: free[0] is the distance
    // to the nearest surface.
    float free[4] = {0, 0, 0, 0};
    std::int16_t slopes[4] = {0, 0, 0, 0};
    // By colour: a vector whose dot product with a normal close to the point's own is the irradiance. Without dynamic
    // objects, and now.
    glm::vec3 static_light[3] = {}, light[3] = {};
    // A vector whose dot product with such a normal is the form factor of the surfaces that this light comes from.
    glm::vec3 facing{0};
    // Colour of the light of nodes by surfaces that thin it, relative to its luminance, which the nodes' weights have.
    glm::vec3 tint{1};
    std::uint32_t owner = k_no_owner;    // of points on dynamic objects: LightTree::owner_of()
    std::uint32_t version = 0;           // LightTree::geometry_version() that `seen` belongs to; 0: not evaluated
    std::uint32_t dynamic_version = 0;   // CacheFrame::dynamic_version that `light` belongs to
    // Light-tree nodes that are visible past static geometry, padded to k_seen_step. A PointDevice keeps them itself.
    std::uint32_t count = 0;
    std::uint32_t kept = 0;      // the device's name for them, if count > 0
    std::uint32_t patches = 0;   // nodes over patches begin at this place, or up to k_seen_step before it
    std::unique_ptr<SeenNode[]> seen;
    SkyMask sky;                                 // directions of the sky that are visible past static geometry
    std::vector<DividedDirection> divided_sky;   // those that are visible in part; not in `sky`
    std::vector<std::uint8_t> near_reach;        // near-field points: how far lit surfaces are (near_reach.h)
    // The last frame in which a thread claimed the point, and the last one in which it was ready, or abandoned.
    std::atomic<std::uint32_t> claimed{0}, ready{0};

    glm::vec3 origin() const { return position + lift * geometric_normal + smooth_lift; }
    static constexpr float k_steepest = 4;   // slope
    float slope(int way) const { return static_cast<float>(slopes[way]) * (k_steepest / 32767); }
    void set_slope(int way, float s) { slopes[way] = static_cast<std::int16_t>(std::lround(s * (32767 / k_steepest))); }

    /// Irradiance on a surface at the point that faces `n`.
    glm::vec3 irradiance(const glm::vec3& n) const
    {
        return glm::max(glm::vec3(glm::dot(light[0], n), glm::dot(light[1], n), glm::dot(light[2], n)), glm::vec3(0));
    }
    /// The form factor of the static surfaces that light it.
    float form_factor(const glm::vec3& n) const { return std::max(glm::dot(facing, n), 0.0f); }
    /// Adds light that arrives from a direction.
    void add_light(const glm::vec3& flux, const glm::vec3& direction)
    {
        for (int colour = 0; colour < 3; ++colour) light[colour] += flux[colour] * direction;
    }
};

/// Whether those points of a lattice cell that exist have one normal.
inline bool have_one_normal(const CachePoint* const (&points)[4])
{
    const CachePoint* first = nullptr;
    for (const CachePoint* point : points) {
        if (!point->exists) continue;
        if (!first) first = point;
        if (point->normal != first->normal) return false;
    }
    return true;
}

/// What the near fields of a lattice cell's points bring, by colour, and the form factor of their surfaces.
/// @param weights  of the points
/// @param all      their sum, above 0
inline glm::vec4 near_between(const CachePoint* const (&points)[4], const float (&weights)[4], float all)
{
    const auto of = [&](int i) { return weights[i] * glm::vec4(points[i]->near, points[i]->near_factor); };
    return ((of(0) + of(1)) + (of(2) + of(3))) / all;
}

/// The `ready` of a point whose evaluation failed in a frame.
inline constexpr std::uint32_t abandoned_in(std::uint32_t frame)
{
    return frame | (1u << 31);
}

}   // namespace gnomon::irradiance_cache
