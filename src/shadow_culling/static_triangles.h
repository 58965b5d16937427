// SPDX-License-Identifier: Apache-2.0
#pragma once
// The static triangles as certificates need them: who borders whom, and which of them a shaft may meet.
//
// Built once a scene (again only if a static object is moved by hand). World positions are the very floats that rays
// are tested against. Edges are matched by the bits of their end points: what does not match to the bit is not
// watertight, and no certificate may pass over it.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ray/ray_scene.h"

namespace gnomon::shadow_culling {

using TriangleId = std::uint32_t;   // among all static triangles
inline constexpr TriangleId no_triangle = 0xffffffffu;

struct StaticTriangle {
    glm::vec3 p[3];
};

class Shaft;
struct Plane;

class StaticTriangles {
 public:
    /// How a triangle takes part in shadows.
    enum class Role : std::uint8_t { opaque, masked, transparent };

    /// @param lifted  by object: not static any more, since it was moved by hand
    StaticTriangles(const scene::SceneState& state, const ray::RayScene& rays, const std::vector<char>& lifted);

    std::size_t size() const { return triangles_.size(); }
    const StaticTriangle& operator[](TriangleId id) const { return triangles_[id]; }
    Role role(TriangleId id) const { return roles_[id]; }
    /// First id of an object's triangles; no_triangle for dynamic or hidden objects.
    TriangleId first_of(scene::ObjectId object) const { return first_[object]; }
    /// The one other triangle across edge e (from corner e to e + 1); no_triangle at borders, where three or more meet,
    /// and where the neighbour does not block light.
    TriangleId across(TriangleId id, int edge) const { return across_[3 * static_cast<std::size_t>(id) + edge]; }
    const Box3& bounds() const { return bounds_; }
    float largest_coordinate() const { return largest_; }
    std::size_t bytes() const;

    /// Whether any triangle that can block light, opaque or masked, other than `receiver`, meets the shaft.
    /// Conservative: may say yes where none does.
    bool any_in(const Shaft& shaft, TriangleId receiver) const;

    /// The least height over a plane of what lies inside four others, of triangles that can block light; infinite if
    /// nothing does.
    double least_height(const std::array<Plane, 4>& sides, const Plane& plane) const;

    /// Opaque triangles that the segment origin + [0, 1] * to_end passes through, at most `most`, in no particular
    /// order.
    void along(const glm::dvec3& origin, const glm::dvec3& to_end, std::size_t most,
               std::vector<TriangleId>& found) const;

 private:
    struct Node {
        glm::vec3 low, high;
        std::uint32_t first;   // of its triangles in order_ (leaf), or its left child; the right one follows
        std::uint32_t count;   // 0: inner
    };
    void match_edges();
    void build_tree();
    std::uint32_t build_range(std::uint32_t node, std::uint32_t begin, std::uint32_t end, std::vector<Box3>& boxes);

    std::vector<StaticTriangle> triangles_;
    std::vector<Role> roles_;
    std::vector<TriangleId> first_;   // by object
    std::vector<TriangleId> across_;
    std::vector<Node> nodes_;
    std::vector<TriangleId> order_;   // blocking triangles, leaf by leaf
    Box3 bounds_;
    float largest_ = 0;
};

}   // namespace gnomon::shadow_culling
