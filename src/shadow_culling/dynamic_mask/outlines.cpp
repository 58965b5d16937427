// SPDX-License-Identifier: Apache-2.0
// Computes the outline of a dynamic object on a light's plane.
#include <cmath>

#include "shadow_culling/dynamic_mask/parts.h"

namespace gnomon::shadow_culling {

// Finds the outline of a unit, and the depths at which it begins and ends.
void DynamicMask::find_outline(LightMask& mask, Print& print)
{
    std::vector<Piece>& outline = mask.outlines[&print - mask.prints.data()];
    outline.clear();
    const Unit& unit = *units_[print.unit];
    const ray::ObjectGeometry& geometry = rays_->geometry(unit.object);
    if (geometry.to_world) {
        const glm::mat3 linear(*geometry.to_world);
        print.stretch =
            std::sqrt(glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) + glm::dot(linear[2], linear[2]));
        print.mirrored = glm::determinant(linear) < 0;
    }
    if (rays_->meeting(unit.object) == ray::Meeting::roughly) print.stretch = k_infinity;   // any part of it may rise
    const DynamicShape& shape = *unit.shape;
    if (print.blind) return;
    const LightSpace& space = mask.space;

    // Project the corners.
    static thread_local std::vector<glm::dvec3> in_face;
    static thread_local std::vector<OnFace> on_face;
    static thread_local std::vector<std::int8_t>
        turn;   // by triangle: winding seen from the light, 1 or -1; 0: edge-on
    const glm::dmat4 to_world = geometry.to_world ? glm::dmat4(*geometry.to_world) : glm::dmat4(1);
    const auto placed = [&](std::uint32_t vertex) {
        const glm::dvec3 p(geometry.positions[vertex]);
        return space.in_face(print.face, geometry.to_world ? transform_point(to_world, p) : p);
    };
    in_face.resize(shape.vertex.size());
    on_face.resize(shape.vertex.size());
    double near = k_infinity, far = -near;
    for (std::size_t v = 0; v < shape.vertex.size(); ++v) {
        in_face[v] = placed(shape.vertex[v]);
        on_face[v] = space.on_face(in_face[v]);
        near = std::min(near, in_face[v].z), far = std::max(far, in_face[v].z);
    }
    for (const std::uint32_t v : shape.masked_vertex) {
        const double depth = placed(v).z;
        near = std::min(near, depth), far = std::max(far, depth);
    }
    print.masked = !shape.masked_vertex.empty();
    if (!shape.blocks()) {
        print.begins = k_infinity;
        return;
    }
    print.begins = std::nextafter(static_cast<float>(near) - print.between, -k_infinity);
    print.ends = std::nextafter(static_cast<float>(far) + print.between, k_infinity);
    const float widen = static_cast<float>(space.on_plane(mask.margin, near));

    // Find the winding of every triangle seen from the light.
    turn.resize(shape.triangle.size());
    for (std::size_t t = 0; t < shape.triangle.size(); ++t) {
        const glm::uvec3& c = shape.triangle[t];
        const glm::dvec3 n = glm::cross(in_face[c.y] - in_face[c.x], in_face[c.z] - in_face[c.x]);
        const glm::dvec3 out = space.outward(in_face[c.x]);
        const double facing = glm::dot(n, out);
        const double least = options_.min_facing * options_.min_facing * glm::dot(n, n) * glm::dot(out, out);
        if (facing * facing > least) {
            turn[t] = facing > 0 ? 1 : -1;
            continue;
        }
        // Near an edge-on triangle nothing is known: add its longest edge to the outline, as wide as the triangle is
        // high.
        turn[t] = 0;
        Piece longest{};
        double longest_squared = -1, area = 0;
        for (int e = 0; e < 3; ++e) {
            const OnFace &a = on_face[c[e]], &b = on_face[c[(e + 1) % 3]], &d = on_face[c[(e + 2) % 3]];
            const double dx = b.x - a.x, dy = b.y - a.y;
            if (dx * dx + dy * dy <= longest_squared) continue;
            longest_squared = dx * dx + dy * dy;
            area = std::abs(dx * (d.y - a.y) - dy * (d.x - a.x));
            longest = {static_cast<float>(a.x),
                       static_cast<float>(a.y),
                       static_cast<float>(b.x),
                       static_cast<float>(b.y),
                       0,
                       0};
        }
        longest.widen = widen + (longest_squared > 0 ? static_cast<float>(area / std::sqrt(longest_squared)) : 0.0f);
        outline.push_back(longest);
    }

    // An edge belongs to the outline unless it has two triangles, one on either side.
    for (const DynamicShape::Edge& edge : shape.edge) {
        std::int32_t layers = 0;   // to the left of it, minus those to the right
        bool edge_on = false;
        for (std::uint32_t s = edge.first; s < edge.first + edge.count; ++s) {
            const DynamicShape::Side& side = shape.sides[s];
            layers += side.forward ? turn[side.triangle] : -turn[side.triangle];
            edge_on = edge_on || turn[side.triangle] == 0;
        }
        if (edge.count == 2 && layers == 0 && !edge_on) continue;
        const OnFace &a = on_face[edge.a], &b = on_face[edge.b];
        outline.push_back({static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(b.x),
                           static_cast<float>(b.y), widen, -layers});
    }
}

}   // namespace gnomon::shadow_culling
