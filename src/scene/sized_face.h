// SPDX-License-Identifier: Apache-2.0
#pragma once
// The emissive triangles of a mesh as planar convex polygons.
//
// Two triangles that share an edge and lie in one plane become one quadrilateral if that is convex; parallelograms are
// joined first. Cost: a look-up per edge.

#include <array>

#include "scene/emission.h"
#include "scene/emission_cone.h"

namespace gnomon::scene {

/// A planar convex emitter: a triangle or a quadrilateral, in world space.
struct SizedFace {
    std::array<glm::vec3, 4> corner{};   // counter-clockwise seen from the front; of a triangle, the last two are equal
    int corners = 3;
    glm::vec3 normal{0};   // unit, the front
    float area = 0;
    glm::vec3 radiance{0};    // mean over the face
    bool two_sided = false;   // also emits at the back
    bool dynamic = false;     // its object may move or deform
    EmissionCone cone{};      // outside of which it emits nothing
    ObjectId object = none;
    std::uint32_t triangle[2] = {none, none};   // of the object's mesh; the second of a quadrilateral only

    /// The point at a place of the unit square: uniform in area over a triangle or a parallelogram.
    glm::vec3 at(float u, float v) const;
    /// The area of the face that a unit of the square's area stands for at a place.
    float area_at(float u, float v) const;
};

/// A triangle in world space, counter-clockwise seen from the front.
struct FaceTriangle {
    glm::vec3 p[3];
    bool swapped = false;   // p[1] and p[2] are the mesh's third and second corner
};

/// A face with what its emission is looked up by.
struct SourceFace {
    SizedFace face;
    FaceTriangle parts[2];
    const Emission* emission = nullptr;

    /// Radiance at a place of the unit square (SizedFace::at).
    /// @param step  the width of the look-up, as a fraction of the triangles' edges
    glm::vec3 radiance(float u, float v, float step) const;
    /// The mean over a rectangle of the unit square.
    glm::vec3 mean_radiance(const glm::vec2& low, const glm::vec2& high) const;
};

/// Appends the faces of one part of a mesh, without their radiance. Triangles without area are left out.
/// @param positions  of the mesh's vertices
/// @param like       what all faces have in common
/// @param emission   of the part's material; must outlive the faces
void collect_faces(const Mesh& mesh, const MeshPart& part, const std::vector<glm::vec3>& positions,
                   const glm::mat4& to_world, const SizedFace& like, const Emission& emission,
                   std::vector<SourceFace>& faces);

}   // namespace gnomon::scene
