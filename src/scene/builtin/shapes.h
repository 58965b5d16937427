// SPDX-License-Identifier: Apache-2.0
#pragma once
// A kit for building meshes in code: swept outlines, surfaces of revolution, bevelled boxes, tubes, plates, spheres.
//
// Every shape is a set of faces with outward normals. Triangles are oriented by the normals of their corners, so a
// shape cannot be inside out, and triangles without area are omitted. Texture coordinates are metres along the surface.
// The second set of texture coordinates encodes unshadowed sky light without rays: its u is the fraction of the sky
// that the point sees, an index into a ramp texture (kinetic_materials.cpp). Cost: linear in the number of triangles.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "scene/mesh.h"

namespace gnomon::scene {

/// A planar curve with one normal on each side of every point: equal where the curve is smooth, different at an edge.
/// Outside is to the right of the direction of travel.
struct Outline {
    struct Segment {
        glm::vec2 from, to;
        glm::vec2 normal_from, normal_to;
        float along_from, along_to;   // arc length
    };
    std::vector<Segment> segments;
};

/// The normal to the right of a direction.
glm::vec2 right_of(const glm::vec2& direction);

/// @param points  at least two
/// @param crease  angle in radians from which on a corner stays sharp
Outline make_outline(std::span<const glm::vec2> points, bool closed, float crease = 0.7f);

/// A plane in space that carries an outline: point = origin + p.x * x + p.y * y.
struct Frame {
    glm::vec3 origin{0};
    glm::vec3 x{1, 0, 0}, y{0, 1, 0};
    float along = 0;   // texture coordinate in the direction of the sweep
};

class MeshBuilder {
 public:
    /// The material of all triangles added from now on.
    void use(MaterialId material) { material_ = material; }
    void tint(const glm::vec3& color) { color_ = color; }
    void place(const glm::mat4& matrix)
    {
        matrix_ = matrix, normal_matrix_ = glm::transpose(glm::inverse(glm::mat3(matrix)));
    }
    const glm::mat4& placement() const { return matrix_; }
    /// Sets the function for the fraction of the sky (0 to 1) that a point with this normal sees, in the space of the
    /// mesh. Empty: 1.
    void open_sky(std::function<float(const glm::vec3& point, const glm::vec3& normal)> seen)
    {
        sky_ = std::move(seen);
    }
    /// Offsets the texture of shapes added from now on, so that equal shapes do not look alike.
    void shift_texture(const glm::vec2& offset) { texture_offset_ = offset; }

    std::uint32_t vertex(const glm::vec3& position, const glm::vec3& normal, const glm::vec2& uv);
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
    /// Adds a quad; corners in order around it.
    void quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);
    /// Adds a flat quad with one normal; texture coordinates are projected along the normal's largest axis.
    void flat_quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
                   const glm::vec3& normal);

    /// Sweeps the outline through the frames in order. `caps` closes a closed outline at both ends (convex, or
    /// star-shaped around its centroid).
    void sweep(const Outline& outline, std::span<const Frame> frames, bool caps = false);
    /// Revolves an outline of (radius, height), bottom to top, around +Y.
    void lathe(const Outline& outline, int segments);
    /// Adds a box with all edges bevelled by one width at 45 degrees.
    void box(const glm::vec3& low, const glm::vec3& high, float bevel);
    /// Adds a round tube along a path, with open or round ends.
    void tube(std::span<const glm::vec3> path, float radius, int sides, bool caps = true);
    /// The same with a radius for each point.
    void tube(std::span<const glm::vec3> path, std::span<const float> radii, int sides, bool caps = true);
    /// Adds a sphere of two poles and `rings` rings of `segments` vertices.
    void sphere(const glm::vec3& centre, float radius, int segments, int rings);
    /// Adds a plate in the plane z = 0 with a rounded rim. `points` are counter-clockwise seen from +Z and star-shaped
    /// around `hub`.
    void plate(std::span<const glm::vec2> points, const glm::vec2& hub, float thickness, float bevel);

    std::size_t triangle_count() const { return triangles_.size(); }
    /// Sorts triangles by material and returns the mesh; the builder is empty afterwards.
    Mesh finish(std::string name);

 private:
    MaterialId material_ = 0;
    glm::vec3 color_{1};
    glm::mat4 matrix_{1};
    glm::mat3 normal_matrix_{1};
    glm::vec2 texture_offset_{0};
    std::function<float(const glm::vec3&, const glm::vec3&)> sky_;
    Mesh mesh_;
    std::vector<glm::uvec3> triangles_;
    std::vector<MaterialId> materials_;   // one per triangle
};

/// Points on an arc of a circle, from angle a to b (radians), both included.
std::vector<glm::vec2> arc(const glm::vec2& centre, float radius, float a, float b, int steps);

/// A smooth curve through points [Catmull and Rom 1974] with `steps` segments between two of them.
std::vector<glm::vec3> smooth_path(std::span<const glm::vec3> points, int steps);

}   // namespace gnomon::scene
