// SPDX-License-Identifier: Apache-2.0
// Parts of triangles in the visible scheme: which speak for a point that no lattice reaches, where they lie, and how
// one level of their detail fades into the next.
#include <algorithm>
#include <cmath>

#include "base/micro_triangles.h"
#include "irradiance_cache/irradiance_cache.h"
#include "ray/origin.h"

namespace gnomon::irradiance_cache {

namespace {

float smoothstep(float t)
{
    return t * t * (3 - 2 * t);
}

}   // namespace

// What has no lattice point to be interpolated from gets parts of its triangle, or of those around.
void VisibleLight::shade_parts(Batch& batch, std::span<const IndirectPoint> points, glm::vec3* irradiance)
{
    batch.whole_parts.swap(batch.parts);
    batch.parts.clear();
    for (const Batch::Part& part : batch.whole_parts) {
        const IndirectPoint& point = points[part.point];
        // Near light is not asked for where pixels are wide.
        if (!batch.moving[part.point]) batch.near_share[part.point] -= part.rest * faded(point.width / near_width_ - 1);
        const PartAnchors anchors = far_parts(point);
        for (int i = 0; i < anchors.count; ++i)
            batch.parts.push_back({part.point, part.rest * anchors.share[i], anchors.key[i], nullptr, part.around});
    }
    for (const bool last : {false, true}) {
        if (batch.parts.empty()) return;
        batch.claimed.clear();
        batch.awaited.clear();
        for (Batch::Part& part : batch.parts) part.part = want(batch, part.key);
        serve(batch);
        batch.whole_parts.clear();
        for (const Batch::Part& part : batch.parts) {
            const IndirectPoint& point = points[part.point];
            if (part.part->waits) {
                batch.pending = true;
                continue;
            }
            glm::vec3 light = at_part(*part.part, point.normal);
            // The middle of a part may lie where other geometry covers it: then rather the light around, as it is, and
            // where there is none, once more from close by, than a black dot.
            if (light == glm::vec3(0)) light = part.around;
            if (light == glm::vec3(0) && part.part->version == 0) light = average_;   // put off
            if (light != glm::vec3(0) || last) {
                irradiance[part.point] += part.rest * light;
                continue;
            }
            const PartAnchors anchors = own_parts(point);
            for (int i = 0; i < anchors.count; ++i)
                batch.whole_parts.push_back(
                    {part.point, part.rest * anchors.share[i], anchors.key[i], nullptr, glm::vec3(0)});
        }
        batch.parts.swap(batch.whole_parts);
    }
}

// How far a level of detail has faded in: 0 where it begins, 1 `level_blend` beyond.
float VisibleLight::faded(float beyond) const
{
    return beyond >= options_.level_blend ? 1.0f : smoothstep(std::max(beyond, 0.0f) / options_.level_blend);
}

// The parts of its triangle that are about the pixel itself.
VisibleLight::PartAnchors VisibleLight::own_parts(const IndirectPoint& point) const
{
    glm::vec3 corner[3];
    rays_->geometry(point.object).corners(point.triangle, corner);
    PartAnchors parts;
    add_parts(parts, point, glm::cross(corner[1] - corner[0], corner[2] - corner[0]),
              options_.pixels_per_own * point.width);
    return parts;
}

// Parts of a point's own triangle, about as large as `spacing`. One level of detail fades into the other; but of what
// moves, whose points live for a frame.
// @param cross  of the triangle's sides
void VisibleLight::add_parts(PartAnchors& parts, const IndirectPoint& point, const glm::vec3& cross,
                             float spacing) const
{
    const std::uint32_t triangle = first_triangle_[point.object] + point.triangle;
    const bool front = glm::dot(cross, point.geometric_normal) > 0;
    const PartDetail detail = part_detail(0.5f * glm::length(cross), spacing);
    const float finer = rays_->moves(point.object) ? 1.0f : faded(detail.fraction);
    parts.add(part_key(triangle, front, detail.level, point.u, point.v), finer);
    if (finer < 1) parts.add(part_key(triangle, front, detail.level - 1, point.u, point.v), 1 - finer);
}

VisibleLight::PartAnchors VisibleLight::far_parts(const IndirectPoint& point)
{
    if (rays_->moves(point.object))
        return part_anchors(point, options_.pixels_per_part * point.width, options_.pixels_per_part * point.width);
    return part_anchors(point, options_.narrowest * point.width, options_.pixels_per_leaf * point.width);
}

void VisibleLight::PartAnchors::add(AnchorKey k, float s)
{
    if (!(s > 0)) return;
    const auto* const at = std::find(key, key + count, k);
    if (at != key + count) {
        share[at - key] += s;
        return;
    }
    key[count] = k, share[count] = s;
    ++count;
}

// Parts of a large triangle; or triangles that stand for the small ones around, faded as parts are.
VisibleLight::PartAnchors VisibleLight::part_anchors(const IndirectPoint& point, float spacing, float leaf_spacing)
{
    const ray::ObjectGeometry& geometry = rays_->geometry(point.object);
    const scene::Object& object = state_->scene().objects[point.object];
    const bool moves = rays_->moves(point.object);
    const std::uint32_t first = first_triangle_[point.object];
    glm::vec3 corner[3];
    const auto cross_of = [&](std::uint32_t triangle) {
        geometry.corners(triangle, corner);
        return glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    };
    const glm::vec3 own = cross_of(point.triangle);
    const float twice_area = glm::length(own);
    PartAnchors parts;
    if (!(twice_area < spacing * spacing)) {
        add_parts(parts, point, own, spacing);
        return parts;
    }
    const float scale = std::cbrt(std::abs(glm::determinant(glm::mat3(state_->object_matrix(point.object)))));
    const float in_mesh = scale > 0 ? leaf_spacing / scale : leaf_spacing;
    const bool clusters = in_mesh > 0 && std::isfinite(in_mesh);
    const float together = !clusters                  ? 0.0f
                           : moves || twice_area == 0 ? 1.0f
                                                      : faded(spacing / std::sqrt(twice_area) - 1);
    parts.add(part_key(first + point.triangle, glm::dot(own, point.geometric_normal) > 0, 0, point.u, point.v),
              1 - together);
    const auto add_cluster = [&](int level, float share) {
        if (!(share > 0)) return;
        const std::uint32_t triangle = clusters_.representatives(object.mesh, *geometry.mesh, level)[point.triangle];
        const glm::vec3 cross = cross_of(triangle);
        parts.add(part_key(first + triangle, glm::dot(cross, point.geometric_normal) > 0,
                           part_detail(0.5f * glm::length(cross), leaf_spacing).level, 1 / 3.0f, 1 / 3.0f),
                  share);
    };
    if (!(together > 0)) return parts;
    const Detail detail = detail_of(in_mesh);
    const float wider = moves ? 1.0f : faded(detail.fraction);
    add_cluster(detail.level, together * wider);
    add_cluster(detail.level - 1, together * (1 - wider));
    return parts;
}

glm::vec3 VisibleLight::at_part(const RememberedPoint& part, const glm::vec3& normal) const
{
    return glm::max(
        glm::vec3(glm::dot(part.light[0], normal), glm::dot(part.light[1], normal), glm::dot(part.light[2], normal)),
        glm::vec3(0));
}

void VisibleLight::place_part(RememberedPoint& point) const
{
    const Part part = part_of(point.key);
    const auto after = std::upper_bound(first_triangle_.begin(), first_triangle_.end(), part.triangle);
    const auto object = static_cast<scene::ObjectId>(after - first_triangle_.begin() - 1);
    const std::uint32_t triangle = part.triangle - first_triangle_[object];
    const ray::ObjectGeometry& geometry = rays_->geometry(object);
    glm::vec3 p[3];
    geometry.corners(triangle, p);
    glm::dvec2 corner[3];
    corners_of(micro_at(part.index, part.level), part.level, corner);
    const glm::vec2 uv((corner[0] + corner[1] + corner[2]) / 3.0);
    const float w = 1 - uv.x - uv.y;
    glm::vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const float length = glm::length(normal);
    point.exists = length > 0;
    if (!point.exists) return;
    normal /= part.front ? length : -length;
    point.position = w * p[0] + uv.x * p[1] + uv.y * p[2];
    point.lift = ray::origin_lift(p);
    point.geometric_normal = point.normal = normal;
    if (geometry.normals) {
        const glm::uvec3 index = geometry.mesh->triangles[triangle];
        glm::vec3 n =
            w * geometry.normals[index[0]] + uv.x * geometry.normals[index[1]] + uv.y * geometry.normals[index[2]];
        if (geometry.normal_to_world) n = *geometry.normal_to_world * n;
        if (glm::dot(n, normal) < 0) n = -n;
        if (glm::dot(n, n) > 0) point.normal = glm::normalize(n);
    }
    if (!rays_->moves(object)) return;
    point.version = 0;   // what it sees changes as it moves
    point.owner = emitters_.owner_of(object);
}

}   // namespace gnomon::irradiance_cache
