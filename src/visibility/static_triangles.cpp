// SPDX-License-Identifier: Apache-2.0
#include "visibility/static_triangles.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

#include "base/check.h"
#include "base/interruption.h"
#include "visibility/shaft.h"

namespace gnomon::visibility {

namespace {

constexpr int k_leaf = 4;   // triangles; with fewer, a split does not pay off
constexpr int k_bins = 16;
// Between interruption points: triangles or comparisons; and triangles of a node.
constexpr std::uint32_t k_step = 1 << 16, k_many = 1 << 10;

StaticTriangles::Role role_of(scene::SurfaceClass surface)
{
    switch (surface) {
        case scene::SurfaceClass::opaque:
            return StaticTriangles::Role::opaque;
        case scene::SurfaceClass::masked:
            return StaticTriangles::Role::masked;
        case scene::SurfaceClass::transparent:
            break;
    }
    return StaticTriangles::Role::transparent;
}

// An undirected edge, identified by the bits of its ends.
struct EdgeKey {
    std::array<std::uint32_t, 6> bits;
    std::uint32_t slot;   // 3 * triangle + edge
    bool operator<(const EdgeKey& other) const { return bits != other.bits ? bits < other.bits : slot < other.slot; }
};

std::array<std::uint32_t, 3> bits_of(const glm::vec3& p)
{
    const glm::vec3 q = p + glm::vec3(0.0f);   // -0 and 0 are the same position
    std::array<std::uint32_t, 3> bits;
    std::memcpy(bits.data(), &q, sizeof q);
    return bits;
}

double half_area(const Box3& box)
{
    if (box.empty()) return 0;
    const glm::dvec3 s(box.size());
    return s.x * s.y + s.y * s.z + s.z * s.x;
}

}   // namespace

StaticTriangles::StaticTriangles(const scene::SceneState& state, const ray::RayScene& rays, LeftOut left_out,
                                 std::size_t most)
    : left_out_(left_out)
{
    const scene::Scene& scene = state.scene();
    first_.assign(scene.objects.size(), no_triangle);
    count_.assign(scene.objects.size(), 0);
    std::vector<scene::ObjectId> objects;
    std::size_t count = 0;
    for (scene::ObjectId o = 0; o < scene.objects.size(); ++o) {
        if (state.is_dynamic(o) || !state.object_visible(o) || rays.meeting(o) == ray::Meeting::never) continue;
        objects.push_back(o);
        for (const scene::MeshPart& part : rays.geometry(o).mesh->parts) count += part.triangle_count;
    }
    listed_ = count <= most;
    std::vector<scene::ObjectId> space;   // by triangle: none for world space, else the object whose space it is
    if (listed_) triangles_.reserve(count), roles_.reserve(count), space.reserve(count);
    for (const scene::ObjectId o : objects) {
        interruption_point();
        const ray::ObjectGeometry& geometry = rays.geometry(o);
        if (listed_) first_[o] = static_cast<TriangleId>(triangles_.size());
        for (const scene::MeshPart& part : geometry.mesh->parts) {
            const Role role = role_of(scene.materials[part.material].surface_class());
            for (std::uint32_t t = 0; t < part.triangle_count; ++t) {
                StaticTriangle triangle;
                geometry.corners(part.first_triangle + t, triangle.p);
                for (const glm::vec3& p : triangle.p) bounds_.add(p);
                if (!listed_) continue;
                triangles_.push_back(triangle);
                roles_.push_back(role);
                space.push_back(geometry.to_world ? o : scene::none);
            }
        }
        if (listed_) count_[o] = static_cast<std::uint32_t>(triangles_.size()) - first_[o];
    }
    for (int axis = 0; axis < 3 && !bounds_.empty(); ++axis)
        largest_ = std::max({largest_, std::abs(bounds_.low[axis]), std::abs(bounds_.high[axis])});
    if (!listed_) return;
    match_edges(space);
    build_tree();
}

void StaticTriangles::match_edges(const std::vector<scene::ObjectId>& space)
{
    const auto leads_on = [&](TriangleId t) {
        return roles_[t] == Role::opaque || (left_out_.has(Check::opaque_neighbour) && roles_[t] == Role::masked);
    };
    const auto ends = [&](const glm::vec3& p) {
        auto bits = bits_of(p);
        if (left_out_.has(Check::same_bits))
            for (std::uint32_t& b : bits) b &= 0xffff0000u;
        return bits;
    };
    std::vector<EdgeKey> edges;
    edges.reserve(3 * triangles_.size());
    for (TriangleId t = 0; t < triangles_.size(); ++t) {
        if (t % k_step == 0) interruption_point();
        if (!leads_on(t)) continue;
        for (int e = 0; e < 3; ++e) {
            auto a = ends(triangles_[t].p[e]), b = ends(triangles_[t].p[(e + 1) % 3]);
            if (b < a) std::swap(a, b);
            edges.push_back({{a[0], a[1], a[2], b[0], b[1], b[2]}, 3 * t + static_cast<std::uint32_t>(e)});
        }
    }
    std::uint32_t compared = 0;
    std::sort(edges.begin(), edges.end(), [&](const EdgeKey& a, const EdgeKey& b) {
        if (++compared % k_step == 0) interruption_point();
        return a < b;
    });

    // Connect the triangles at edges that exactly two of them share.
    across_.assign(3 * triangles_.size(), no_triangle);
    for (std::size_t begin = 0; begin < edges.size();) {
        std::size_t end = begin + 1;
        while (end < edges.size() && edges[end].bits == edges[begin].bits) ++end;
        if (end - begin == 2) {
            const std::uint32_t a = edges[begin].slot, b = edges[begin + 1].slot;
            const bool one_space = space[a / 3] == space[b / 3];
            if (a / 3 != b / 3 && one_space) {
                across_[a] = b / 3;
                across_[b] = a / 3;
            }
        }
        begin = end;
    }
}

void StaticTriangles::build_tree()
{
    std::vector<Box3> boxes(triangles_.size());
    for (TriangleId t = 0; t < triangles_.size(); ++t) {
        for (const glm::vec3& p : triangles_[t].p) boxes[t].add(p);
        const bool blocks =
            roles_[t] == Role::opaque || (roles_[t] == Role::masked && !left_out_.has(Check::masked_blocks));
        (blocks ? order_ : outside_tree_).push_back(t);
    }
    if (order_.empty()) return;
    nodes_.reserve(order_.size());
    nodes_.emplace_back();
    build_range(0, 0, static_cast<std::uint32_t>(order_.size()), boxes);
}

// Splits by the surface area heuristic over bins along the longest axis of the centroids.
std::uint32_t StaticTriangles::build_range(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
                                           std::vector<Box3>& boxes)
{
    if (end - begin > k_many) interruption_point();
    Box3 box, centres;
    for (std::uint32_t i = begin; i < end; ++i) {
        box.add(boxes[order_[i]]);
        centres.add(boxes[order_[i]].centre());
    }
    nodes_[node].low = box.low;
    nodes_[node].high = box.high;
    nodes_[node].first = begin;
    nodes_[node].count = end - begin;
    const glm::vec3 extent = centres.size();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    if (end - begin <= k_leaf) return node;

    std::uint32_t middle = begin;
    if (extent[axis] > 0) {
        const float scale = static_cast<float>(k_bins) / extent[axis];
        // Put what is too far away for a float into the first bin: no ray hits it.
        const auto bin_of = [&](TriangleId t) {
            const float at = (boxes[t].centre()[axis] - centres.low[axis]) * scale;
            return at > 0 ? static_cast<int>(std::min(at, static_cast<float>(k_bins - 1))) : 0;
        };
        std::array<Box3, k_bins> bin_box;
        std::array<std::uint32_t, k_bins> bin_count{};
        for (std::uint32_t i = begin; i < end; ++i) {
            const auto b = static_cast<std::size_t>(bin_of(order_[i]));
            bin_box[b].add(boxes[order_[i]]);
            ++bin_count[b];
        }
        std::array<double, k_bins> right_cost{};
        Box3 sweep;
        std::uint32_t count = 0;
        for (std::size_t b = k_bins - 1; b > 0; --b) {
            sweep.add(bin_box[b]);
            count += bin_count[b];
            right_cost[b] = half_area(sweep) * count;
        }
        double best = std::numeric_limits<double>::infinity();
        std::size_t split = 0;
        sweep = Box3{};
        count = 0;
        for (std::size_t b = 0; b + 1 < k_bins; ++b) {
            sweep.add(bin_box[b]);
            count += bin_count[b];
            const double cost = half_area(sweep) * count + right_cost[b + 1];
            if (cost < best) best = cost, split = b;
        }
        middle = static_cast<std::uint32_t>(
            std::partition(order_.begin() + begin, order_.begin() + end,
                           [&](TriangleId t) { return bin_of(t) <= static_cast<int>(split); }) -
            order_.begin());
    }
    if (middle == begin || middle == end) middle = begin + (end - begin) / 2;

    const auto left = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    nodes_.emplace_back();
    nodes_[node].first = left;
    nodes_[node].count = 0;
    build_range(left, begin, middle, boxes);
    build_range(left + 1, middle, end, boxes);
    return node;
}

void StaticTriangles::remove(scene::ObjectId object)
{
    const auto [begin, end] = of(object);
    if (!left_out_.has(Check::promoted_not_receiver)) first_[object] = no_triangle;
    if (left_out_.has(Check::promoted_not_occluder)) return;
    for (TriangleId id = begin; id < end; ++id) {
        remove_from_tree(id);
        for (std::size_t e = 0; e < 3; ++e) {
            TriangleId& next = across_[3 * static_cast<std::size_t>(id) + e];
            if (next == no_triangle) continue;
            for (std::size_t back = 0; back < 3; ++back)
                if (TriangleId& own = across_[3 * static_cast<std::size_t>(next) + back]; own == id) own = no_triangle;
            next = no_triangle;
        }
    }
    std::erase_if(outside_tree_, [begin = begin, end = end](TriangleId id) { return id >= begin && id < end; });
}

// Descends wherever the triangle may be, and replaces it by no_triangle in its leaf.
void StaticTriangles::remove_from_tree(TriangleId id)
{
    Box3 box;
    for (const glm::vec3& p : triangles_[id].p) box.add(p);
    std::vector<std::uint32_t> stack;
    if (!nodes_.empty()) stack.push_back(0);
    while (!stack.empty()) {
        const Node& node = nodes_[stack.back()];
        stack.pop_back();
        bool holds = true;
        for (int axis = 0; axis < 3; ++axis)
            holds = holds && node.low[axis] <= box.low[axis] && node.high[axis] >= box.high[axis];
        if (!holds) continue;
        if (node.count == 0) {
            stack.push_back(node.first);
            stack.push_back(node.first + 1);
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            if (order_[i] == id) {
                order_[i] = no_triangle;
                return;
            }
    }
}

bool StaticTriangles::any_in(const Shaft& shaft) const
{
    if (!listed_) return true;
    if (nodes_.empty() || !shaft.may_meet(nodes_[0].low, nodes_[0].high)) return false;
    std::array<std::uint32_t, 128> stack;
    std::size_t top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const Node& node = nodes_[stack[--top]];
        if (node.count == 0) {
            GNOMON_CHECK_LE(top + 2, stack.size());
            for (std::uint32_t c = node.first; c < node.first + 2; ++c)
                if (shaft.may_meet(nodes_[c].low, nodes_[c].high)) stack[top++] = c;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            if (order_[i] == no_triangle) continue;
            const StaticTriangle& t = triangles_[order_[i]];
            const glm::dvec3 p[3] = {glm::dvec3(t.p[0]), glm::dvec3(t.p[1]), glm::dvec3(t.p[2])};
            ClippedPolygon clipped;
            if (shaft.clip(p, shaft.room_for(visibility::largest_coordinate(t)), clipped)) return true;
        }
    }
    return false;
}

double StaticTriangles::least_height(const std::array<Plane, 4>& sides, const Plane& plane) const
{
    if (!listed_) return -std::numeric_limits<double>::infinity();
    double least = std::numeric_limits<double>::infinity();
    // The corner of a box that is lowest or highest over a plane.
    const auto corner = [](const Node& node, const glm::dvec3& direction, bool furthest) {
        glm::dvec3 p;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = static_cast<double>((direction[axis] > 0) == furthest ? node.high[axis] : node.low[axis]);
        return p;
    };
    const auto may_matter = [&](const Node& node) {
        for (const Plane& side : sides)
            if (side.at(corner(node, side.normal, true)) < 0) return false;
        return plane.at(corner(node, plane.normal, false)) < least;
    };
    std::array<std::uint32_t, 128> stack;
    std::size_t top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
        const Node& node = nodes_[stack[--top]];
        if (!may_matter(node)) continue;
        if (node.count == 0) {
            GNOMON_CHECK_LE(top + 2, stack.size());
            // Visit the lower child first.
            const bool swap = plane.at(corner(nodes_[node.first], plane.normal, false)) >
                              plane.at(corner(nodes_[node.first + 1], plane.normal, false));
            stack[top++] = node.first + (swap ? 0 : 1);
            stack[top++] = node.first + (swap ? 1 : 0);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            if (order_[i] == no_triangle) continue;
            const StaticTriangle& t = triangles_[order_[i]];
            const glm::dvec3 p[3] = {glm::dvec3(t.p[0]), glm::dvec3(t.p[1]), glm::dvec3(t.p[2])};
            ClippedPolygon clipped;
            if (!clip_triangle(sides, p, clipped)) continue;
            for (int c = 0; c < clipped.count; ++c)
                least = std::min(least, plane.at(clipped.corner[static_cast<std::size_t>(c)]));
        }
    }
    return least;
}

void StaticTriangles::along(const glm::dvec3& origin, const glm::dvec3& to_end, std::size_t most,
                            std::vector<TriangleId>& found) const
{
    found.clear();
    if (nodes_.empty()) return;
    const glm::dvec3 inverse = 1.0 / to_end;
    const auto meets = [&](const Node& node) {
        double first = 0, last = 1;
        for (int axis = 0; axis < 3; ++axis) {
            const double a = (static_cast<double>(node.low[axis]) - origin[axis]) * inverse[axis];
            const double b = (static_cast<double>(node.high[axis]) - origin[axis]) * inverse[axis];
            // The comparison accepts the box for 0 * infinity, that is, for a ray in the plane of a face.
            first = std::max(first, std::min(a, b));
            last = std::min(last, std::max(a, b));
        }
        return !(first > last);
    };
    std::array<std::uint32_t, 128> stack;
    std::size_t top = 0;
    if (meets(nodes_[0])) stack[top++] = 0;
    while (top > 0) {
        const Node& node = nodes_[stack[--top]];
        if (node.count == 0) {
            GNOMON_CHECK_LE(top + 2, stack.size());
            for (std::uint32_t c = node.first; c < node.first + 2; ++c)
                if (meets(nodes_[c])) stack[top++] = c;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            if (order_[i] == no_triangle) continue;
            if (roles_[order_[i]] != Role::opaque && !left_out_.has(Check::opaque_occluder)) continue;
            const StaticTriangle& t = triangles_[order_[i]];
            // [Moeller and Trumbore 1997]
            const glm::dvec3 a(t.p[0]), e1 = glm::dvec3(t.p[1]) - a, e2 = glm::dvec3(t.p[2]) - a;
            const glm::dvec3 h = glm::cross(to_end, e2);
            const double determinant = glm::dot(e1, h);
            if (determinant == 0) continue;
            const glm::dvec3 s = origin - a;
            const double u = glm::dot(s, h) / determinant;
            if (!(u >= 0 && u <= 1)) continue;
            const glm::dvec3 q = glm::cross(s, e1);
            const double v = glm::dot(to_end, q) / determinant;
            if (!(v >= 0 && u + v <= 1)) continue;
            const double distance = glm::dot(e2, q) / determinant;
            if (!(distance > 0 && distance < 1)) continue;
            found.push_back(order_[i]);
            if (found.size() >= most) return;
        }
    }
}

std::size_t StaticTriangles::bytes() const
{
    return triangles_.size() * (sizeof(StaticTriangle) + sizeof(Role) + 3 * sizeof(TriangleId)) +
           nodes_.size() * sizeof(Node) + order_.size() * sizeof(TriangleId);
}

}   // namespace gnomon::visibility
