// SPDX-License-Identifier: Apache-2.0
#include "scene/builtin/shapes.h"

#include <algorithm>
#include <numeric>

#include "base/check.h"

namespace gnomon::scene {

namespace {
constexpr float k_tau = static_cast<float>(2 * k_pi);
constexpr float k_no_area = 1e-12f;   // square metres

}   // namespace

std::uint32_t MeshBuilder::vertex(const glm::vec3& position, const glm::vec3& normal, const glm::vec2& uv)
{
    const glm::vec3 p = transform_point(matrix_, position);
    const glm::vec3 n = glm::normalize(normal_matrix_ * normal);
    mesh_.positions.push_back(p);
    mesh_.normals.push_back(n);
    mesh_.texcoords[0].push_back(uv + texture_offset_);
    mesh_.texcoords[1].emplace_back(sky_ ? std::clamp(sky_(p, n), 0.0f, 1.0f) : 1.0f, 0.5f);
    mesh_.colors.emplace_back(color_, 1.0f);
    return static_cast<std::uint32_t>(mesh_.positions.size() - 1);
}

void MeshBuilder::triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c)
{
    const glm::vec3 face = glm::cross(mesh_.positions[b] - mesh_.positions[a], mesh_.positions[c] - mesh_.positions[a]);
    if (!(glm::dot(face, face) > k_no_area * k_no_area)) return;
    // Orient the triangle by its normals.
    if (glm::dot(face, mesh_.normals[a] + mesh_.normals[b] + mesh_.normals[c]) < 0) std::swap(b, c);
    triangles_.emplace_back(a, b, c);
    materials_.push_back(material_);
}

void MeshBuilder::quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d)
{
    triangle(a, b, c);
    triangle(a, c, d);
}

void MeshBuilder::flat_quad(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d,
                            const glm::vec3& normal)
{
    const glm::vec3 size = glm::abs(normal);
    const auto project = [&](const glm::vec3& p) {
        if (size.y >= size.x && size.y >= size.z) return glm::vec2(p.x, p.z);
        return size.x >= size.z ? glm::vec2(p.z, -p.y) : glm::vec2(p.x, -p.y);
    };
    const std::uint32_t i = vertex(a, normal, project(a)), j = vertex(b, normal, project(b));
    const std::uint32_t k = vertex(c, normal, project(c)), l = vertex(d, normal, project(d));
    quad(i, j, k, l);
}

void MeshBuilder::sweep(const Outline& outline, std::span<const Frame> frames, bool caps)
{
    GNOMON_CHECK_LE(std::size_t{2}, frames.size());
    for (const Outline::Segment& segment : outline.segments) {
        std::uint32_t before[2] = {0, 0};
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const Frame& f = frames[i];
            const auto add = [&](const glm::vec2& p, const glm::vec2& n, float along) {
                return vertex(f.origin + f.x * p.x + f.y * p.y, f.x * n.x + f.y * n.y, {f.along, -along});
            };
            const std::uint32_t now[2] = {add(segment.from, segment.normal_from, segment.along_from),
                                          add(segment.to, segment.normal_to, segment.along_to)};
            if (i > 0) quad(before[0], now[0], now[1], before[1]);
            before[0] = now[0], before[1] = now[1];
        }
    }
    if (!caps) return;
    for (const bool first : {true, false}) {
        const Frame& f = first ? frames.front() : frames.back();
        const Frame& inner = first ? frames[1] : frames[frames.size() - 2];
        glm::vec3 normal = glm::normalize(glm::cross(f.x, f.y));
        if (glm::dot(normal, f.origin - inner.origin) < 0) normal = -normal;
        glm::vec2 centre(0);
        for (const Outline::Segment& s : outline.segments) centre += s.from;
        centre /= static_cast<float>(outline.segments.size());
        const auto add = [&](const glm::vec2& p) { return vertex(f.origin + f.x * p.x + f.y * p.y, normal, p); };
        const std::uint32_t hub = add(centre);
        for (const Outline::Segment& s : outline.segments) {
            const std::uint32_t a = add(s.from), b = add(s.to);
            triangle(hub, a, b);
        }
    }
}

void MeshBuilder::lathe(const Outline& outline, int segments)
{
    // Scale the texture around the axis by the largest radius.
    float radius = 0;
    for (const Outline::Segment& s : outline.segments) radius = std::max({radius, s.from.x, s.to.x});
    std::vector<Frame> frames;
    for (int i = 0; i <= segments; ++i) {
        const float angle = i == segments ? 0.0f : k_tau * static_cast<float>(i) / static_cast<float>(segments);
        Frame f;
        f.x = {std::cos(angle), 0, -std::sin(angle)};
        f.along = radius * k_tau * static_cast<float>(i) / static_cast<float>(segments);
        frames.push_back(f);
    }
    sweep(outline, frames);
}

void MeshBuilder::box(const glm::vec3& low, const glm::vec3& high, float bevel)
{
    const glm::vec3 centre = 0.5f * (low + high), half = 0.5f * (high - low);
    const float b = std::min({bevel, 0.49f * half.x * 2, 0.49f * half.y * 2, 0.49f * half.z * 2});
    const auto at = [&](int axis, float s, float u, float v) {   // a point of face `axis`, inset by the bevel
        glm::vec3 p;
        p[axis] = s * half[axis];
        p[(axis + 1) % 3] = u * (half[(axis + 1) % 3] - b);
        p[(axis + 2) % 3] = v * (half[(axis + 2) % 3] - b);
        return centre + p;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const float s : {-1.0f, 1.0f}) {
            glm::vec3 n(0);
            n[axis] = s;
            flat_quad(at(axis, s, -1, -1), at(axis, s, 1, -1), at(axis, s, 1, 1), at(axis, s, -1, 1), n);
            if (!(b > 0)) continue;
            // The edge towards the next axis.
            const int next = (axis + 1) % 3;
            for (const float t : {-1.0f, 1.0f}) {
                glm::vec3 m(0);
                m[axis] = s, m[next] = t;
                flat_quad(at(axis, s, t, -1), at(axis, s, t, 1), at(next, t, 1, s), at(next, t, -1, s),
                          glm::normalize(m));
            }
        }
    if (!(b > 0)) return;
    // Corners.
    for (const float x : {-1.0f, 1.0f})
        for (const float y : {-1.0f, 1.0f})
            for (const float z : {-1.0f, 1.0f}) {
                const glm::vec3 n = glm::normalize(glm::vec3(x, y, z));
                const std::uint32_t i = vertex(at(0, x, y, z), n, {0, 0}), j = vertex(at(1, y, z, x), n, {b, 0});
                triangle(i, j, vertex(at(2, z, x, y), n, {0, b}));
            }
}

void MeshBuilder::tube(std::span<const glm::vec3> path, float radius, int sides, bool caps)
{
    const std::vector<float> radii(path.size(), radius);
    tube(path, radii, sides, caps);
}

void MeshBuilder::tube(std::span<const glm::vec3> path, std::span<const float> radii, int sides, bool caps)
{
    GNOMON_CHECK_LE(std::size_t{2}, path.size());
    GNOMON_CHECK_EQ(path.size(), radii.size());
    const std::size_t n = path.size();
    glm::vec3 side(0);
    std::uint32_t before = 0;
    float along = 0;
    const auto ring = [&](const glm::vec3& centre, const glm::vec3& x, const glm::vec3& y, float radius,
                          const glm::vec3& lean) {
        std::uint32_t first = 0;
        for (int i = 0; i <= sides; ++i) {
            const float angle = i == sides ? 0.0f : k_tau * static_cast<float>(i) / static_cast<float>(sides);
            const glm::vec3 out = x * std::cos(angle) + y * std::sin(angle);
            const std::uint32_t v = vertex(centre + radius * out, glm::normalize(out + lean),
                                           {along, radius * k_tau * static_cast<float>(i) / static_cast<float>(sides)});
            if (i == 0) first = v;
        }
        return first;
    };
    for (std::size_t i = 0; i < n; ++i) {
        const glm::vec3 tangent = glm::normalize(path[std::min(i + 1, n - 1)] - path[i > 0 ? i - 1 : 0]);
        // Transport one perpendicular along the path, so that the tube does not twist.
        if (i == 0) {
            glm::vec3 unused;
            make_basis(tangent, side, unused);
        } else {
            along += glm::length(path[i] - path[i - 1]);
        }
        side = glm::normalize(side - tangent * glm::dot(side, tangent));
        const glm::vec3 other = glm::cross(tangent, side);
        const std::uint32_t now = ring(path[i], side, other, radii[i], glm::vec3(0));
        if (i > 0)
            for (int s = 0; s < sides; ++s) {
                const auto k = static_cast<std::uint32_t>(s);
                quad(before + k, before + k + 1, now + k + 1, now + k);
            }
        before = now;
        if (!caps || (i != 0 && i + 1 != n)) continue;
        // Close the end with a flat disc.
        const glm::vec3 out = i == 0 ? -tangent : tangent;
        const std::uint32_t hub = vertex(path[i], out, {0, 0});
        std::uint32_t last = 0;
        for (int s = 0; s <= sides; ++s) {
            const float angle = s == sides ? 0.0f : k_tau * static_cast<float>(s) / static_cast<float>(sides);
            const glm::vec3 p = path[i] + radii[i] * (side * std::cos(angle) + other * std::sin(angle));
            const std::uint32_t v = vertex(p, out, {radii[i], 0});
            if (s > 0) triangle(hub, last, v);
            last = v;
        }
    }
}

void MeshBuilder::sphere(const glm::vec3& centre, float radius, int segments, int rings)
{
    const auto at = [&](int ring, int segment) {
        const float polar = static_cast<float>(k_pi) * static_cast<float>(ring) / static_cast<float>(rings + 1);
        const float angle = k_tau * static_cast<float>(segment) / static_cast<float>(segments);
        const float s = std::sin(polar);
        const glm::vec3 n(s * std::cos(angle), std::cos(polar), -s * std::sin(angle));
        return vertex(centre + radius * n, n, {radius * angle, radius * polar});
    };
    const std::uint32_t top = vertex(centre + glm::vec3(0, radius, 0), {0, 1, 0}, {0, 0});
    std::uint32_t first = top + 1;
    for (int ring = 1; ring <= rings; ++ring)
        for (int s = 0; s < segments; ++s) at(ring, s);
    const std::uint32_t bottom = vertex(centre - glm::vec3(0, radius, 0), {0, -1, 0}, {0, radius * 3.14159f});
    const auto id = [&](int ring, int s) {
        return first + static_cast<std::uint32_t>((ring - 1) * segments + s % segments);
    };
    for (int s = 0; s < segments; ++s) {
        triangle(top, id(1, s), id(1, s + 1));
        for (int ring = 1; ring < rings; ++ring)
            quad(id(ring, s), id(ring + 1, s), id(ring + 1, s + 1), id(ring, s + 1));
        triangle(bottom, id(rings, s + 1), id(rings, s));
    }
}

void MeshBuilder::plate(std::span<const glm::vec2> points, const glm::vec2& hub, float thickness, float bevel)
{
    const Outline outline = make_outline(points, true);
    const float h = 0.5f * thickness, b = std::min(bevel, h);
    const std::size_t n = outline.segments.size();
    // Where the bevel's inner edges meet: mitred at every corner, but not beyond twice its width.
    std::vector<glm::vec2> inset(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Outline::Segment &before = outline.segments[(i + n - 1) % n], &after = outline.segments[i];
        const glm::vec2 u = right_of(before.to - before.from), v = right_of(after.to - after.from);
        inset[i] = after.from - (u + v) * (b / std::max(1 + glm::dot(u, v), 0.5f));
    }
    for (std::size_t i = 0; i < n; ++i) {
        const Outline::Segment& s = outline.segments[i];
        const glm::vec2 inner[2] = {inset[i], inset[(i + 1) % n]}, rim[2] = {s.from, s.to};
        const glm::vec3 out[2] = {glm::vec3(s.normal_from, 0), glm::vec3(s.normal_to, 0)};
        for (const float side : {-1.0f, 1.0f}) {
            const glm::vec3 up(0, 0, side);
            const auto add = [&](const glm::vec2& p, float z, const glm::vec3& normal) {
                return vertex({p, side * z}, glm::normalize(normal), p);
            };
            // Face, bevel, and half of the rim.
            const std::uint32_t face[3] = {add(hub, h, up), add(inner[0], h, up), add(inner[1], h, up)};
            triangle(face[0], face[1], face[2]);
            const std::uint32_t edge[2] = {add(inner[0], h, up + 0.4f * out[0]), add(inner[1], h, up + 0.4f * out[1])};
            const std::uint32_t side_of[2] = {add(rim[0], h - b, 0.4f * up + out[0]),
                                              add(rim[1], h - b, 0.4f * up + out[1])};
            quad(edge[0], edge[1], side_of[1], side_of[0]);
            const std::uint32_t middle[2] = {add(rim[0], 0, out[0]), add(rim[1], 0, out[1])};
            quad(side_of[0], side_of[1], middle[1], middle[0]);
        }
    }
}

Mesh MeshBuilder::finish(std::string name)
{
    Mesh mesh = std::move(mesh_);
    mesh.name = std::move(name);
    std::vector<std::uint32_t> order(triangles_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return materials_[a] < materials_[b]; });
    for (const std::uint32_t t : order) {
        if (mesh.parts.empty() || mesh.parts.back().material != materials_[t])
            mesh.parts.push_back({materials_[t], static_cast<std::uint32_t>(mesh.triangles.size()), 0});
        mesh.triangles.push_back(triangles_[t]);
        ++mesh.parts.back().triangle_count;
    }
    mesh_ = {};
    triangles_.clear();
    materials_.clear();
    return mesh;
}

}   // namespace gnomon::scene
