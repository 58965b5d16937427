// SPDX-License-Identifier: Apache-2.0
#include "scene/sized_face.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace gnomon::scene {

namespace {

constexpr int k_looks = 4;                         // a side of a rectangle, at which a mean emission is looked up
constexpr std::uint32_t k_most_joined = 1 << 14;   // triangles of a part, beyond which none are joined
constexpr double k_flat = 2e-6;                    // joined triangles: largest distance from their plane, per diameter
constexpr double k_least_turn = 1e-4;              // least sine at a corner of a quadrilateral
constexpr double k_parallel = 1e-4;                // sides of a parallelogram: largest difference, per diameter

// Barycentric coordinates (of p[1] and p[2]) of a point in the plane of a triangle.
glm::vec2 barycentric(const glm::vec3 (&p)[3], const glm::vec3& x)
{
    const glm::dvec3 a(p[1] - p[0]), b(p[2] - p[0]), c(x - p[0]);
    const double aa = glm::dot(a, a), ab = glm::dot(a, b), bb = glm::dot(b, b), ca = glm::dot(c, a),
                 cb = glm::dot(c, b);
    const double determinant = aa * bb - ab * ab;
    if (!(determinant > 0)) return glm::vec2(0);
    return glm::vec2((bb * ca - ab * cb) / determinant, (aa * cb - ab * ca) / determinant);
}

void make_triangle(SizedFace& face, const FaceTriangle& corners)
{
    face.corners = 3;
    face.corner = {corners.p[0], corners.p[1], corners.p[2], corners.p[2]};
    const glm::dvec3 cross = glm::cross(glm::dvec3(corners.p[1]) - glm::dvec3(corners.p[0]),
                                        glm::dvec3(corners.p[2]) - glm::dvec3(corners.p[0]));
    face.area = static_cast<float>(0.5 * glm::length(cross));
    face.normal = face.area > 0 ? glm::vec3(glm::normalize(cross)) : glm::vec3(0);
}

// Joins two triangles of which b's corner `apex` lies beyond a's edge `edge`.
// @return  false if they are not in one plane, or if the result would not be convex
bool join(const FaceTriangle& a, int edge, const FaceTriangle& b, int apex, SizedFace& face, bool& parallelogram)
{
    const std::array<glm::vec3, 4> q{a.p[edge], b.p[apex], a.p[(edge + 1) % 3], a.p[(edge + 2) % 3]};
    const glm::dvec3 normal_a = glm::cross(glm::dvec3(a.p[1] - a.p[0]), glm::dvec3(a.p[2] - a.p[0]));
    const double length = glm::length(normal_a);
    const double diameter = std::max(glm::length(q[2] - q[0]), glm::length(q[3] - q[1]));
    if (!(length > 0)) return false;
    const glm::dvec3 normal = normal_a / length;
    double largest = 0;
    for (const glm::vec3& p : q)
        for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(static_cast<double>(p[axis])));
    const double room = std::max(diameter, largest) * k_flat;
    if (std::abs(glm::dot(normal, glm::dvec3(q[1] - q[0]))) > room) return false;
    double area = 0;
    for (int i = 0; i < 4; ++i) {
        const glm::dvec3 in(q[static_cast<std::size_t>((i + 1) % 4)] - q[static_cast<std::size_t>(i)]),
            out(q[static_cast<std::size_t>((i + 2) % 4)] - q[static_cast<std::size_t>((i + 1) % 4)]);
        const double turn = glm::dot(normal, glm::cross(in, out));
        if (!(turn > k_least_turn * glm::length(in) * glm::length(out))) return false;
    }
    for (int i = 1; i < 3; ++i)
        area += 0.5 * glm::dot(normal, glm::cross(glm::dvec3(q[static_cast<std::size_t>(i)] - q[0]),
                                                  glm::dvec3(q[static_cast<std::size_t>(i + 1)] - q[0])));
    face.corner = q;
    face.corners = 4;
    face.normal = glm::vec3(normal);
    face.area = static_cast<float>(area);
    parallelogram = static_cast<double>(glm::length(q[0] + q[2] - q[1] - q[3])) <= k_parallel * diameter;
    return true;
}

using Key = std::tuple<float, float, float>;

}   // namespace

glm::vec3 SizedFace::at(float u, float v) const
{
    if (corners == 3) {
        const float root = std::sqrt(u);
        return corner[0] + root * ((corner[1] - corner[0]) + v * (corner[2] - corner[1]));
    }
    return (1 - u) * (1 - v) * corner[0] + u * (1 - v) * corner[1] + u * v * corner[2] + (1 - u) * v * corner[3];
}

float SizedFace::area_at(float u, float v) const
{
    if (corners == 3) return area;
    const glm::vec3 along_u = (1 - v) * (corner[1] - corner[0]) + v * (corner[2] - corner[3]);
    const glm::vec3 along_v = (1 - u) * (corner[3] - corner[0]) + u * (corner[2] - corner[1]);
    return glm::length(glm::cross(along_u, along_v));
}

glm::vec3 SourceFace::radiance(float u, float v, float step) const
{
    const glm::vec3 position = face.at(u, v);
    glm::vec2 at = barycentric(parts[0].p, position);
    int part = 0;
    if (face.corners == 4 && std::min({at.x, at.y, 1 - at.x - at.y}) < 0) {
        const glm::vec2 other = barycentric(parts[1].p, position);
        if (std::min({other.x, other.y, 1 - other.x - other.y}) > std::min({at.x, at.y, 1 - at.x - at.y}))
            at = other, part = 1;
    }
    at = glm::clamp(at, glm::vec2(0), glm::vec2(1));
    if (at.x + at.y > 1) at /= at.x + at.y;
    if (parts[part].swapped) std::swap(at.x, at.y);
    return emission->at(face.triangle[part], at.x, at.y, step);
}

glm::vec3 SourceFace::mean_radiance(const glm::vec2& low, const glm::vec2& high) const
{
    glm::vec3 sum(0);
    float areas = 0;
    const float step = (high.x - low.x) / k_looks;
    for (int j = 0; j < k_looks; ++j)
        for (int i = 0; i < k_looks; ++i) {
            const glm::vec2 at = low + (high - low) * (glm::vec2(static_cast<float>(i), static_cast<float>(j)) + 0.5f) /
                                           static_cast<float>(k_looks);
            const float area = face.area_at(at.x, at.y);
            sum += area * radiance(at.x, at.y, step);
            areas += area;
        }
    return areas > 0 ? sum / areas : glm::vec3(0);
}

void collect_faces(const Mesh& mesh, const MeshPart& part, const std::vector<glm::vec3>& positions,
                   const glm::mat4& to_world, const SizedFace& like, const Emission& emission,
                   std::vector<SourceFace>& faces)
{
    const bool mirrored = glm::determinant(glm::mat3(to_world)) < 0;
    std::vector<FaceTriangle> corners(part.triangle_count);
    std::vector<char> done(part.triangle_count, 0);
    for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
        const glm::uvec3 index = mesh.triangles[part.first_triangle + i];
        FaceTriangle& c = corners[i];
        for (int k = 0; k < 3; ++k) c.p[k] = transform_point(to_world, positions[index[k]]);
        if (mirrored) std::swap(c.p[1], c.p[2]), c.swapped = true;
        const glm::vec3 cross = glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]);
        done[i] = !(glm::dot(cross, cross) > 0) || !is_finite(cross);
    }
    if (part.triangle_count >= 2 && part.triangle_count <= k_most_joined) {
        // Look for the triangle that has an edge in the other direction.
        const auto key = [](const glm::vec3& p) { return Key{p.x, p.y, p.z}; };
        std::map<std::pair<Key, Key>, std::pair<std::uint32_t, int>> edges;
        for (std::uint32_t i = 0; i < part.triangle_count; ++i)
            for (int e = 0; e < 3 && !done[i]; ++e)
                edges.try_emplace({key(corners[i].p[e]), key(corners[i].p[(e + 1) % 3])}, i, e);
        for (const bool wants_parallelogram : {true, false})
            for (std::uint32_t i = 0; i < part.triangle_count; ++i)
                for (int e = 0; e < 3 && !done[i]; ++e) {
                    const auto at = edges.find({key(corners[i].p[(e + 1) % 3]), key(corners[i].p[e])});
                    if (at == edges.end()) continue;
                    const auto [j, edge] = at->second;
                    if (j == i || done[j]) continue;
                    SourceFace source{like, {corners[i], corners[j]}, &emission};
                    bool parallelogram = false;
                    if (!join(corners[i], e, corners[j], (edge + 2) % 3, source.face, parallelogram)) continue;
                    if (wants_parallelogram && !parallelogram) continue;
                    source.face.triangle[0] = part.first_triangle + i,
                    source.face.triangle[1] = part.first_triangle + j;
                    done[i] = done[j] = 1;
                    faces.push_back(source);
                }
    }
    for (std::uint32_t i = 0; i < part.triangle_count; ++i) {
        if (done[i]) continue;
        SourceFace source{like, {corners[i], {}}, &emission};
        make_triangle(source.face, corners[i]);
        source.face.triangle[0] = part.first_triangle + i;
        if (source.face.area > 0) faces.push_back(source);
    }
}

}   // namespace gnomon::scene
