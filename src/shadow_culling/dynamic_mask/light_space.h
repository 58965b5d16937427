// SPDX-License-Identifier: Apache-2.0
#pragma once
// Projects points onto a light's plane, on which each ray of the light is one point.
//
// A point or spot light has six square faces around it, each with a field of view of 90 degrees; a directional light
// has one face perpendicular to its rays. On a face, a position has (x, y) in [0, 1) and a depth that increases away
// from the light. A triangle projects to a triangle on the plane of any face that it lies in front of.
//
// Queries are projected in single precision, geometry in double. The error of a query is below 1e-6 of the largest
// coordinate in play; margins must be wider.

#include <array>
#include <cstdint>

#include "visibility/shaft.h"

namespace gnomon::shadow_culling {

/// A position projected onto a face.
struct Projected {
    std::uint32_t face = 0;
    float x = 0, y = 0;   // in [0, 1) on the face; may be outside for directional lights only
    float depth = 0;      // along the face's axis, scene units
};

/// A position projected onto the plane of one face, inside the face or not.
struct OnFace {
    double x = 0, y = 0, depth = 0;
};

class LightSpace {
 public:
    static constexpr std::uint32_t k_faces = 6;

    LightSpace() = default;
    /// @param bounds  that the face of a directional light must contain
    LightSpace(const visibility::LightPoint& light, const Box3& bounds);

    const visibility::LightPoint& light() const { return light_; }
    /// The constants of `project`, in single precision.
    struct Single {
        glm::vec3 to{0};        // the light's position, or the direction towards it
        glm::vec3 s{0}, t{0};   // axes of a directional light's face
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

    /// A position in a face's own axes, scene units: (x, y, depth). Affine in p.
    glm::dvec3 in_face(std::uint32_t face, const glm::dvec3& p) const;
    /// Projects from a face's axes onto its plane. Except for directional lights, the depth must be positive.
    OnFace on_face(const glm::dvec3& in_face) const
    {
        const auto scale = static_cast<double>(single_.scale);
        if (light_.directional) return {scale * in_face.x, scale * in_face.y, in_face.z};
        return {0.5 + 0.5 * in_face.x / in_face.z, 0.5 + 0.5 * in_face.y / in_face.z, in_face.z};
    }
    /// The plane, in a face's axes, of all rays through x = at (axis 0) or y = at (axis 1). The inside is where x or y
    /// is more (sign 1) or less (-1). Moved outward by a margin.
    visibility::Plane side(int axis, double at, double sign, double margin) const;
    /// Transforms a plane from a face's axes to world space.
    visibility::Plane in_world(std::uint32_t face, const visibility::Plane& plane) const;
    /// The direction of light at a position, both in a face's axes.
    glm::dvec3 outward(const glm::dvec3& in_face) const { return light_.directional ? glm::dvec3(0, 0, 1) : in_face; }

    /// Upper bound of the displacement on the plane for a displacement by `distance` at this depth or deeper.
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
