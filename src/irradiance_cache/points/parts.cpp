// SPDX-License-Identifier: Apache-2.0
#include "irradiance_cache/points/parts.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/micro_triangles.h"
#include "irradiance_cache/points/slices.h"

namespace gnomon::irradiance_cache {

namespace {

// Triangles of dynamic objects are small below these twice their areas, in squares of the spacing: flat ones that would
// not be divided, and those of smooth meshes that would be divided once.
constexpr float k_flat_small = 2, k_smooth_small = 4;
// Small ones are long from this many spacings on; and slices of these are as long as so many spacings of corners.
constexpr float k_long = 3, k_slice = 2;
// One level of their corners fades into the next faster than elsewhere: both are evaluated in each frame.
constexpr float k_faster = 2;

// The cross product of a triangle's sides.
glm::vec3 cross_of(const ray::ObjectGeometry& geometry, std::uint32_t triangle)
{
    glm::vec3 corner[3];
    geometry.corners(triangle, corner);
    return glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
}

// Adds parts of a point's own triangle of about `spacing`.
// @param cross  cross_of() the triangle
void add_own_parts(const CacheFrame& frame, PartWeights& parts, const IndirectPoint& point, const glm::vec3& cross,
                   float spacing)
{
    const std::uint32_t triangle = frame.triangles.first(point.object) + point.triangle;
    const bool front = glm::dot(cross, point.geometric_normal) > 0;
    const PartDetail detail = part_detail(0.5f * glm::length(cross), spacing);
    const float finer = frame.state->is_dynamic(point.object) ? 1.0f : frame.fade_in(detail.fraction);
    parts.add(part_key(triangle, front, detail.level, point.u, point.v), finer);
    if (finer < 1) parts.add(part_key(triangle, front, detail.level - 1, point.u, point.v), 1 - finer);
}

// Adds the parts of a level of a triangle between which a point lies, with so much weight in all. Those are the lower
// micro-triangles alone: their centres are the vertices of a regular grid, a third of a cell away from the triangle's
// sides.
// @param triangle  among all of the scene
void add_parts_around(PartWeights& parts, std::uint32_t triangle, bool front, std::uint32_t level, float u, float v,
                      float weight)
{
    const auto n = static_cast<std::int32_t>(1u << level);
    const auto add = [&](std::int32_t i, std::int32_t j, float w) {
        const MicroTriangle lower{static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), 0};
        parts.add(key_of({triangle, front, level, micro_index(lower, level)}), weight * w);
    };
    // Where the grid has no vertex, beyond the sides, take those that are closest.
    const auto add_vertex = [&](std::int32_t i, std::int32_t j, float w) {
        i = std::clamp(i, 0, n - 1), j = std::clamp(j, 0, n - 1);
        if (i + j < n) return add(i, j, w);
        add(i - 1, j, 0.5f * w);
        add(i, j - 1, 0.5f * w);
    };
    const float x = std::clamp(u, 0.0f, 1.0f) * static_cast<float>(n) - 1 / 3.0f;
    const float y = std::clamp(v, 0.0f, 1.0f) * static_cast<float>(n) - 1 / 3.0f;
    const auto i = static_cast<std::int32_t>(std::floor(x)), j = static_cast<std::int32_t>(std::floor(y));
    const float fx = x - std::floor(x), fy = y - std::floor(y);
    if (fx + fy <= 1) {
        add_vertex(i, j, 1 - fx - fy);
        add_vertex(i + 1, j, fx);
        add_vertex(i, j + 1, fy);
    } else {
        add_vertex(i + 1, j + 1, fx + fy - 1);
        add_vertex(i, j + 1, 1 - fx);
        add_vertex(i + 1, j, 1 - fy);
    }
}

// Adds slices of a point's own triangle of about `spacing`, with so much weight in all.
void add_slices(const CacheFrame& frame, PartWeights& parts, const IndirectPoint& point, const SlenderTriangle& slender,
                bool front, float spacing, float weight)
{
    const std::uint32_t triangle = frame.triangles.first(point.object) + point.triangle;
    const PartDetail detail = part_detail(slender.length * slender.length, spacing);
    const float finer = frame.state->is_dynamic(point.object) ? 1.0f : frame.fade_in(detail.fraction);
    parts.add(slice_key(slender, triangle, front, detail.level, point.u, point.v), weight * finer);
    if (finer < 1)
        parts.add(slice_key(slender, triangle, front, detail.level - 1, point.u, point.v), weight * (1 - finer));
}

// Adds the corners of the micro-triangle around a point of a dynamic object, with so much weight in all.
// @param triangle  among all of the scene
void add_corners_around(PartWeights& parts, std::uint32_t triangle, bool front, std::uint32_t level, float u, float v,
                        float weight)
{
    const auto n = static_cast<float>(1u << level);
    const float x = std::clamp(u, 0.0f, 1.0f), y = std::clamp(v, 0.0f, 1.0f), sum = std::max(x + y, 1.0f);
    const MicroTriangle part = micro_part_at(x / sum, y / sum, level);
    const float fx = std::clamp(n * x / sum - static_cast<float>(part.i), 0.0f, 1.0f),
                fy = std::clamp(n * y / sum - static_cast<float>(part.j), 0.0f, 1.0f);
    const auto add = [&](std::uint32_t i, std::uint32_t j, float w) {
        parts.add(corner_key(triangle, front, level, part.i + i, part.j + j), weight * w);
    };
    if (part.upper) {
        add(1, 1, std::max(fx + fy - 1, 0.0f));
        add(0, 1, 1 - fx);
        add(1, 0, 1 - fy);
    } else {
        add(0, 0, std::max(1 - fx - fy, 0.0f));
        add(1, 0, fx);
        add(0, 1, fy);
    }
}

// Adds the clusters around the corners of a small triangle, with so much weight in all.
void add_blend(const CacheFrame& frame, PartWeights& parts, const IndirectPoint& point, const ClusterBlends& blends,
               bool front, float weight)
{
    const std::uint32_t first = frame.triangles.first(point.object);
    const scene::Mesh& mesh = *frame.rays->geometry(point.object).mesh;
    const glm::uvec3 index = mesh.triangles[point.triangle];
    const float of_corner[3] = {std::max(1 - point.u - point.v, 0.0f), point.u, point.v};
    for (int corner = 0; corner < 3; ++corner) {
        const ClusterBlends::Blend blend = blends.of_vertex(mesh, index[corner]);
        if (!(blend.weight[0] > 0)) {   // nothing is around
            parts.add(part_key(first + point.triangle, front, 0, point.u, point.v), weight * of_corner[corner]);
            continue;
        }
        for (int i = 0; i < 4; ++i)
            parts.add(part_key(first + blend.triangle[i], front, 0, point.u, point.v),
                      weight * of_corner[corner] * blend.weight[i]);
    }
}

// Parts for a point of a dynamic object: interpolated, so that what moves has no facets but its own.
PartWeights select_moving_parts(const CacheFrame& frame, const IndirectPoint& point, float spacing)
{
    const ray::ObjectGeometry& geometry = frame.rays->geometry(point.object);
    const scene::Object& object = frame.state->scene().objects[point.object];
    const glm::vec3 own = cross_of(geometry, point.triangle);
    const float twice_area = glm::length(own);
    const bool smooth = geometry.normals && !geometry.mesh->normals.empty();
    const bool front = glm::dot(own, point.geometric_normal) > 0;
    PartWeights parts;
    // Interpolate along a long and narrow triangle.
    glm::vec3 corner[3];
    geometry.corners(point.triangle, corner);
    const SlenderTriangle slender = slender_triangle(corner);
    if (slender.height > 0 && slender.height < spacing && slender.length > k_long * spacing) {
        const float width = k_slice * frame.options.pixels_per_corner * point.width;
        const std::uint32_t level = part_detail(slender.length * slender.length, width).level;
        const SlicesAround around = slices_around(slender, frame.triangles.first(point.object) + point.triangle, front,
                                                  level, point.u, point.v);
        for (int i = 0; i < 2; ++i) parts.add(around.key[i], around.weight[i]);
        return parts;
    }
    if (!(twice_area < (smooth ? k_smooth_small : k_flat_small) * spacing * spacing)) {
        const std::uint32_t triangle = frame.triangles.first(point.object) + point.triangle;
        const PartDetail detail = part_detail(0.5f * twice_area, frame.options.pixels_per_corner * point.width);
        const std::uint32_t level = std::min(detail.level, k_corner_levels);
        const float finer = level == detail.level ? frame.fade_in(k_faster * detail.fraction) : 1.0f;
        add_corners_around(parts, triangle, front, level, point.u, point.v, finer);
        if (finer < 1) add_corners_around(parts, triangle, front, level - 1, point.u, point.v, 1 - finer);
        return parts;
    }
    // Blend clusters of small triangles where normals say that these stand for a smooth surface; not in mirrors, which
    // show few pixels of each object, and would ask for half as many clusters again.
    const float scale = std::cbrt(std::abs(glm::determinant(glm::mat3(frame.state->object_matrix(point.object)))));
    const float in_mesh = scale > 0 ? spacing / scale : spacing;
    if (!smooth || point.x < 0 || !(in_mesh > 0) || !std::isfinite(in_mesh))
        return select_parts(frame, point, spacing, spacing);
    const Detail detail = detail_of(in_mesh);
    const ClusterBlends& blends = frame.clusters.blends(object.mesh, *geometry.mesh, detail.level);
    if (blends.apart(point.triangle)) return select_parts(frame, point, spacing, spacing);
    const float wider = frame.fade_in(detail.fraction);
    add_blend(frame, parts, point, blends, front, wider);
    if (wider < 1)
        add_blend(frame, parts, point, frame.clusters.blends(object.mesh, *geometry.mesh, detail.level - 1), front,
                  1 - wider);
    return parts;
}

}   // namespace

void PartWeights::add(AnchorKey k, float w)
{
    if (!(w > 0)) return;
    const auto* const at = std::find(key, key + count, k);
    if (at != key + count) {
        weight[at - key] += w;
        return;
    }
    GNOMON_CHECK(count < k_most);
    key[count] = k, weight[count] = w;
    ++count;
}

PartWeights select_parts(const CacheFrame& frame, const IndirectPoint& point, float spacing, float cluster_spacing)
{
    const ray::ObjectGeometry& geometry = frame.rays->geometry(point.object);
    const scene::Object& object = frame.state->scene().objects[point.object];
    const bool moves = frame.state->is_dynamic(point.object);
    const std::uint32_t first = frame.triangles.first(point.object);
    const glm::vec3 own = cross_of(geometry, point.triangle);
    const float twice_area = glm::length(own);
    PartWeights parts;
    if (!(twice_area < spacing * spacing)) {
        add_own_parts(frame, parts, point, own, spacing);
        return parts;
    }
    // Fade from the small triangle itself to its clusters.
    const float scale = std::cbrt(std::abs(glm::determinant(glm::mat3(frame.state->object_matrix(point.object)))));
    const float in_mesh = scale > 0 ? cluster_spacing / scale : cluster_spacing;
    const bool clusters = in_mesh > 0 && std::isfinite(in_mesh);
    const float together = !clusters                  ? 0.0f
                           : moves || twice_area == 0 ? 1.0f
                                                      : frame.fade_in(spacing / std::sqrt(twice_area) - 1);
    parts.add(part_key(first + point.triangle, glm::dot(own, point.geometric_normal) > 0, 0, point.u, point.v),
              1 - together);
    if (!(together > 0)) return parts;
    // Fade from one size of clusters to the next.
    const auto add_cluster = [&](int level, float weight) {
        if (!(weight > 0)) return;
        const std::uint32_t triangle =
            frame.clusters.representatives(object.mesh, *geometry.mesh, level)[point.triangle];
        const glm::vec3 cross = cross_of(geometry, triangle);
        parts.add(part_key(first + triangle, glm::dot(cross, point.geometric_normal) > 0,
                           part_detail(0.5f * glm::length(cross), cluster_spacing).level, 1 / 3.0f, 1 / 3.0f),
                  weight);
    };
    const Detail detail = detail_of(in_mesh);
    const float wider = moves ? 1.0f : frame.fade_in(detail.fraction);
    add_cluster(detail.level, together * wider);
    add_cluster(detail.level - 1, together * (1 - wider));
    return parts;
}

PartWeights select_near_parts(const CacheFrame& frame, const IndirectPoint& point)
{
    const float spacing = frame.options.pixels_per_near * point.width;
    const glm::vec3 cross = cross_of(frame.rays->geometry(point.object), point.triangle);
    const float twice_area = glm::length(cross);
    if (twice_area < spacing * spacing)
        return select_parts(frame, point, spacing, frame.options.pixels_per_near_cluster * point.width);
    const std::uint32_t triangle = frame.triangles.first(point.object) + point.triangle;
    const bool front = glm::dot(cross, point.geometric_normal) > 0;
    const PartDetail detail = part_detail(0.5f * twice_area, spacing);
    const float finer = frame.fade_in(detail.fraction);
    PartWeights parts;
    add_parts_around(parts, triangle, front, detail.level, point.u, point.v, finer);
    if (finer < 1) add_parts_around(parts, triangle, front, detail.level - 1, point.u, point.v, 1 - finer);
    return parts;
}

PartWeights select_far_parts(const CacheFrame& frame, const IndirectPoint& point)
{
    const CacheOptions& options = frame.options;
    if (frame.state->is_dynamic(point.object))
        return select_moving_parts(frame, point, options.pixels_per_part * point.width);
    return select_parts(frame, point, options.narrowest * point.width, options.pixels_per_leaf * point.width);
}

PartWeights select_finer_parts(const CacheFrame& frame, const IndirectPoint& point)
{
    const float spacing = frame.options.pixels_per_finer * point.width;
    // Small triangles that are slender have slices of their own where they are longer than the spacing: the largest
    // triangle around, or the middle of a long one, may lie far away.
    glm::vec3 p[3];
    frame.rays->geometry(point.object).corners(point.triangle, p);
    const SlenderTriangle slender = slender_triangle(p);
    const float sliced = is_slender(slender) ? frame.fade_in(slender.length / spacing - 1) : 0;
    PartWeights parts;
    if (sliced < 1) {
        parts = select_parts(frame, point, spacing, spacing);
        for (int i = 0; i < parts.count; ++i) parts.weight[i] *= 1 - sliced;
    }
    if (sliced > 0) {
        const bool front = glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), point.geometric_normal) > 0;
        add_slices(frame, parts, point, slender, front, spacing, sliced);
    }
    return parts;
}

PartWeights select_parts_of_mean(const CacheFrame& frame, const IndirectPoint& point)
{
    const float spacing = frame.options.pixels_per_mean * point.width;
    return select_parts(frame, point, spacing, spacing);
}

PartWeights select_pixel_parts(const CacheFrame& frame, const IndirectPoint& point, float pixels)
{
    glm::vec3 p[3];
    frame.rays->geometry(point.object).corners(point.triangle, p);
    const glm::vec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float spacing = pixels * point.width;
    const SlenderTriangle slender = slender_triangle(p);
    PartWeights parts;
    // The middle of a long part may lie far from the pixel, behind other geometry.
    if (is_slender(slender))
        add_slices(frame, parts, point, slender, glm::dot(cross, point.geometric_normal) > 0, spacing, 1);
    else
        add_own_parts(frame, parts, point, cross, spacing);
    return parts;
}

}   // namespace gnomon::irradiance_cache
