// SPDX-License-Identifier: Apache-2.0
#pragma once
// The plane that a light projects onto: its rays are points there, and what lies on one ray lies one behind the other.
//
// For a point or spot light six square faces around it, each seen under a right angle; for a directional light one face
// across its rays. On a face a place has (x, y) in [0, 1) and a depth that grows away from the light. Whole triangles
// project to triangles on the plane of any face they lie in front of, and depth is linear over them.
//
// Queries are projected in single precision, geometry in double. A query is off by less than 1e-6 of the largest
// coordinate in play: margins must be wider.

#include <array>
#include <cstdint>

#include "visibility/shaft.h"

namespace gnomon::shadow_culling {

/// A place as a light sees it.
struct Projected {
    std::uint32_t face = 0;
    float x = 0, y = 0;   // in [0, 1) on the face; outside it for directional lights alone
    float depth = 0;      // along the face's axis, scene units
};

/// A place on the plane of one face, wherever it lies.
struct OnFace {
    double x = 0, y = 0, depth = 0;
};

class LightSpace {
 public:
    static constexpr std::uint32_t k_faces = 6;

    LightSpace() = default;
    /// @param bounds  what a directional light's face must hold
    LightSpace(const visibility::LightPoint& light, const Box3& bounds);

    const visibility::LightPoint& light() const { return light_; }
    /// What `project` reckons with.
    struct Single {
        glm::vec3 to{0};        // the light's place, or the direction towards it
        glm::vec3 s{0}, t{0};   // across a directional light's rays
        float low_x = 0, low_y = 0, scale = 1;
    };
    const Single& single() const { return single_; }
    std::uint32_t faces() const { return light_.directional ? 1 : k_faces; }

    Projected project(const glm::vec3& p) const
    {
        Projected at;
        if (light_.directional) {
            at.x = (glm::dot(p, single_.s) - single_.low_x) * single_.scale;
            at.y = (glm::dot(p, single_.t) - single_.low_y) * single_.scale;
            at.depth = -glm::dot(p, single_.to);
            return at;
        }
        const glm::vec3 q = p - single_.to;
        const float ax = std::abs(q.x), ay = std::abs(q.y), az = std::abs(q.z);
        const int axis = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2;
        at.face = static_cast<std::uint32_t>(2 * axis + (q[axis] < 0 ? 1 : 0));
        at.depth = std::abs(q[axis]);
        const float half = 0.5f / at.depth;
        at.x = 0.5f + half * q[axis == 2 ? 0 : axis + 1];
        at.y = 0.5f + half * q[axis == 0 ? 2 : axis - 1];
        return at;
    }

    /// A place in a face's own axes, scene units: (x, y, depth). Affine in p.
    glm::dvec3 in_face(std::uint32_t face, const glm::dvec3& p) const;
    /// From there onto the plane. A lamp's face needs a positive depth.
    OnFace on_face(const glm::dvec3& in_face) const
    {
        const auto scale = static_cast<double>(single_.scale);
        if (light_.directional) return {scale * in_face.x, scale * in_face.y, in_face.z};
        return {0.5 + 0.5 * in_face.x / in_face.z, 0.5 + 0.5 * in_face.y / in_face.z, in_face.z};
    }
    /// The plane, in a face's axes, of all rays that pass x = at (axis 0) or y = at (axis 1); inside is where x or y is
    /// more (sign 1) or less (-1). Pushed outward by a margin.
    visibility::Plane side(int axis, double at, double sign, double margin) const;
    /// A plane given in a face's axes, in the world.
    visibility::Plane in_world(std::uint32_t face, const visibility::Plane& plane) const;
    /// The way that light goes at a place, both in a face's axes.
    glm::dvec3 outward(const glm::dvec3& in_face) const { return light_.directional ? glm::dvec3(0, 0, 1) : in_face; }

    /// How far on the plane, at most, what is moved by a distance moves inside a face, at this depth or deeper.
    double on_plane(double distance, double depth) const
    {
        return light_.directional ? distance * static_cast<double>(single_.scale) : distance / depth;
    }
    /// The width of a whole face at a depth, scene units.
    float face_width(float depth) const { return light_.directional ? 1 / single_.scale : 2 * depth; }

 private:
    visibility::LightPoint light_;
    Single single_;
};

}   // namespace gnomon::shadow_culling
