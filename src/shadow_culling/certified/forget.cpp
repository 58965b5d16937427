// SPDX-License-Identifier: Apache-2.0
#include "shadow_culling/certified/forget.h"

#include <algorithm>

#include "visibility/dynamic_bounds.h"

namespace gnomon::shadow_culling {

namespace {

// A shaft is one margin wider than its rays. Twice that covers the rounding of single precision here.
constexpr double k_widen_margins = 2;

Box3 box_of(const StaticTriangle& t)
{
    Box3 box;
    for (const glm::vec3& p : t.p) box.add(p);
    return box;
}

}   // namespace

Forgotten forget_object(scene::ObjectId object, std::span<const RememberedLight> lights,
                        const CertificateOptions& options, StaticTriangles& triangles, ShadowMemory& memory)
{
    Forgotten result;

    // Find the bounds of the triangles that could occlude.
    Box3 footprint;
    const auto [begin, end] = triangles.of(object);
    for (TriangleId id = begin; id < end; ++id)
        if (triangles.role(id) != StaticTriangles::Role::transparent)
            for (const glm::vec3& p : triangles[id].p) footprint.add(p);

    // Drop the object's own records.
    if (!options.left_out.has(Check::promoted_not_receiver))
        for (RecordId record = 2 * begin; record < 2 * end; ++record) result.records += memory.drop(record);
    triangles.remove(object);
    if (footprint.empty() || options.left_out.has(Check::promoted_shadow_gone)) return result;

    // Reopen the records that it may have shadowed.
    for (const RememberedLight& light : lights) {
        float coordinate = triangles.largest_coordinate();
        if (!light.directional)
            coordinate = std::max({coordinate, std::abs(light.to.x), std::abs(light.to.y), std::abs(light.to.z)});
        const auto widen = static_cast<float>(k_widen_margins * options.shaft.margin) * coordinate;
        const Box3 blocker{footprint.low - widen, footprint.high + widen};
        triangles.visit(
            [&](const glm::vec3& low, const glm::vec3& high) {
                return visibility::may_shadow(blocker, Box3{low, high}, light.to, light.directional);
            },
            [&](TriangleId id) {
                if (!visibility::may_shadow(blocker, box_of(triangles[id]), light.to, light.directional)) return;
                ++result.visited;
                for (const RecordId record : {2 * id, 2 * id + 1}) memory.reopen(record, light.index);
            });
    }
    return result;
}

}   // namespace gnomon::shadow_culling
