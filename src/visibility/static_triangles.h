// SPDX-License-Identifier: Apache-2.0
#pragma once
// The static triangles for proofs: their adjacency, and a tree to find those that intersect a shaft.
//
// Built once per scene; promoted objects are removed. World positions are the floats that rays are tested against,
// except for static instances, where rays are transformed to the space of the mesh. Edges match if the bits of their
// end points agree, within one space. Where they do not match, the surface is not watertight, and no certificate passes
// over the edge.
//
// Where there are very many triangles, each has few points, and proofs would cost more time and memory than the rays
// that they save. Nothing is then listed: no triangle can be a receiver of proofs, and no shaft is known to be free.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ray/ray_scene.h"
#include "visibility/checks.h"
#include "visibility/shaft.h"

namespace gnomon::visibility {

using TriangleId = std::uint32_t;   // index among all static triangles
inline constexpr TriangleId no_triangle = 0xffffffffu;

struct StaticTriangle {
    glm::vec3 p[3];
};

inline float largest_coordinate(const StaticTriangle& t)
{
    const glm::vec3 reach = glm::max(glm::max(glm::abs(t.p[0]), glm::abs(t.p[1])), glm::abs(t.p[2]));
    return std::max({reach.x, reach.y, reach.z});
}

class StaticTriangles {
 public:
    /// How a triangle takes part in shadows.
    enum class Role : std::uint8_t { opaque, masked, transparent };

    static constexpr std::size_t k_most = std::size_t{1} << 21;   // triangles

    /// @param left_out  checks to leave out, for tests
    /// @param most      if there are more static triangles, none is listed
    StaticTriangles(const scene::SceneState& state, const ray::RayScene& rays, LeftOut left_out = {},
                    std::size_t most = k_most);
    /// Removes a promoted object. The rest is as if it had never been there, except for the bounds, and for edges that
    /// it shared with two other triangles. Cost: a tree descent per triangle of the object.
    void remove(scene::ObjectId object);

    /// Makes room for dynamic objects that were added to the scene.
    void follow(const scene::Scene& scene)
    {
        first_.resize(scene.objects.size(), no_triangle);
        count_.resize(scene.objects.size(), 0);
    }

    std::size_t size() const { return triangles_.size(); }
    /// Whether all static triangles are listed, rather than none.
    bool listed() const { return listed_; }
    const StaticTriangle& operator[](TriangleId id) const { return triangles_[id]; }
    Role role(TriangleId id) const { return roles_[id]; }
    /// First id of an object's triangles; no_triangle for dynamic or hidden objects, and where none is listed.
    TriangleId first_of(scene::ObjectId object) const { return first_[object]; }
    /// The other triangle at edge e (from corner e to e + 1); no_triangle at borders, where three or more triangles
    /// share the edge, and where the neighbour is not opaque.
    TriangleId across(TriangleId id, int edge) const { return across_[3 * static_cast<std::size_t>(id) + edge]; }
    /// [first, last) of an object's triangles; empty where first_of is no_triangle.
    std::pair<TriangleId, TriangleId> of(scene::ObjectId object) const
    {
        const TriangleId first = first_[object];
        return first == no_triangle ? std::pair(0u, 0u) : std::pair(first, first + count_[object]);
    }
    /// Of all static triangles, listed or not.
    const Box3& bounds() const { return bounds_; }
    float largest_coordinate() const { return largest_; }
    std::size_t bytes() const;

    /// Whether any triangle that can block light, opaque or masked, intersects the shaft. Conservative: may be true
    /// where none does, and is where none is listed.
    bool any_in(const Shaft& shaft) const;

    /// The least height over `plane` of all triangles that can block light, clipped to the four `sides`; infinite if
    /// none is left, and minus infinity where none is listed.
    double least_height(const std::array<Plane, 4>& sides, const Plane& plane) const;

    /// Finds opaque triangles that intersect the segment origin + [0, 1] * to_end, at most `most`, in no particular
    /// order.
    void along(const glm::dvec3& origin, const glm::dvec3& to_end, std::size_t most,
               std::vector<TriangleId>& found) const;

    /// The tree over triangles that block light, for walks of a user's own. The root is the first node.
    struct Node {
        glm::vec3 low, high;
        std::uint32_t first;   // leaf: of its triangles, see in_leaf(); inner: left child, followed by the right one
        std::uint32_t count;   // 0: inner
    };
    std::span<const Node> tree() const { return nodes_; }
    /// A triangle of a leaf; no_triangle: removed.
    TriangleId in_leaf(std::uint32_t at) const { return order_[at]; }

    /// Calls take(id) for every triangle, except for those in tree nodes for which meets(low, high) is false.
    template <class Meets, class Take>
    void visit(const Meets& meets, const Take& take) const;

 private:
    void match_edges(const std::vector<scene::ObjectId>& space);
    void remove_from_tree(TriangleId id);
    void build_tree();
    std::uint32_t build_range(std::uint32_t node, std::uint32_t begin, std::uint32_t end, std::vector<Box3>& boxes);

    std::vector<StaticTriangle> triangles_;
    std::vector<Role> roles_;
    std::vector<TriangleId> first_;   // by object
    std::vector<TriangleId> across_;
    std::vector<Node> nodes_;
    std::vector<TriangleId> order_;          // triangles that block light, leaf by leaf; no_triangle: removed
    std::vector<TriangleId> outside_tree_;   // those that do not block light
    std::vector<std::uint32_t> count_;       // by object: its triangles
    LeftOut left_out_;
    bool listed_ = true;
    Box3 bounds_;
    float largest_ = 0;
};

template <class Meets, class Take>
void StaticTriangles::visit(const Meets& meets, const Take& take) const
{
    for (const TriangleId id : outside_tree_) take(id);
    if (nodes_.empty()) return;
    std::vector<std::uint32_t> stack = {0};
    while (!stack.empty()) {
        const Node& node = nodes_[stack.back()];
        stack.pop_back();
        if (!meets(node.low, node.high)) continue;
        if (node.count == 0) {
            stack.push_back(node.first);
            stack.push_back(node.first + 1);
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            if (order_[i] != no_triangle) take(order_[i]);
    }
}

}   // namespace gnomon::visibility
