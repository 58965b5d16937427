// SPDX-License-Identifier: Apache-2.0
// Hard shadows with the edges of triangles: tests whether any triangle lies between a point and the light. All
// candidates are in the list of the cell that contains the point (light_views/vulkan/caster_cells.h). The ray and the
// intersection test are those of the traced frame, so both frames have the same shadows up to rounding.
//
// Cost: a word for each block of one cell's triangles, a comparison of bounds for those near the point's part of the
// cell, an intersection test for those near the point, up to the first hit.

#include "ray/limits_shared.h"

const float k_along_slack = 1e-5;   // of coordinates: more than the lift of origins and the rounding of distances

// Same computation as ray::meets. `at`: barycentric coordinates of b and c at the hit.
bool meets(CellTriangle triangle, vec3 origin, vec3 direction, float end, out vec2 at)
{
    vec3 p0 = triangle.a - origin, p1 = triangle.b - origin, p2 = triangle.c - origin;
    vec3 e0 = p2 - p0, e1 = p0 - p1, e2 = p1 - p2;
    float u = dot(cross(e0, p2 + p0), direction);
    float v = dot(cross(e1, p0 + p1), direction);
    float w = dot(cross(e2, p1 + p2), direction);
    float sum = u + v + w, slack = GNOMON_EDGE_SLACK * abs(sum);
    at = vec2(u, v) / sum;
    if (!(min(min(u, v), w) >= -slack || max(max(u, v), w) <= slack)) return false;
    vec3 normal = cross(e2, e0);
    float slope = dot(normal, direction);
    if (slope == 0.0 || sum == 0.0) return false;
    float t = dot(p0, normal) / slope;
    return t > 0.0 && t <= end;
}

bool occludes(uint number, vec3 origin, vec3 direction, float end)
{
    vec2 at;
    return meets(cell_triangles[number], origin, direction, end, at);
}

// Tests an alpha-tested triangle; it occludes where its material's alpha does.
bool occludes_masked(uint number, vec3 origin, vec3 direction, float end)
{
    CellTriangle triangle = cell_triangles[number];
    vec2 at;
    if (!meets(triangle, origin, direction, end, at)) return false;
    int offset = caster_offsets[triangle.object];
    vec2 uv[3];
    for (uint i = 0u; i < 3u; ++i) uv[i] = caster_texcoords[int(caster_indices[3u * triangle.triangle + i]) + offset];
    return passes_alpha_test(alpha_materials[triangle.material], (1.0 - at.x - at.y) * uv[0] + at.x * uv[1] + at.y * uv[2]);
}

bool is_around(uint bounds, uvec2 at)
{
    return at.x >= (bounds & 255u) && at.y >= (bounds >> 8u & 255u) && at.x <= (bounds >> 16u & 255u) && at.y <= bounds >> 24u;
}

// Searches one list; a macro, because buffers cannot be arguments. `word`: remaining entries of the block that contains
// `next`.
#define OCCLUDED_BY(list, first, blocks_of, entries, test)                                                             \
    {                                                                                                                  \
        uint next = first[list], last = first[list + 1u], block = next / GNOMON_BLOCK_ENTRIES, word = 0u;              \
        uint skip = next % GNOMON_BLOCK_ENTRIES;                                                                       \
        while (!occluded) {                                                                                            \
            bool found = false;                                                                                        \
            while (!found && (word != 0u || block * GNOMON_BLOCK_ENTRIES < last)) {                                    \
                if (word == 0u) {                                                                                      \
                    if (blocks_of[block].nearest <= far) word = blocks_of[block].around[part] & ~0u << skip;           \
                    skip = 0u, ++block;                                                                                \
                } else {                                                                                               \
                    next = (block - 1u) * GNOMON_BLOCK_ENTRIES + uint(findLSB(word));                                  \
                    word &= word - 1u;                                                                                 \
                    found = next < last && is_around(entries[next].bounds, here);                                      \
                }                                                                                                      \
            }                                                                                                          \
            if (!found) break;                                                                                         \
            occluded = test(entries[next].triangle, origin, to_light, end);                                            \
        }                                                                                                              \
    }

float hard_visibility(uint light_number, vec3 point, vec3 normal)
{
    LightRecord light = light_records[light_number];
    if (light.view_count == 0u) return 0.0;
    uint number = view_of_light(light, point);
    ViewRecord view = view_records[number];
    bool perspective = view.perspective != 0u;
    vec3 coordinates = abs(point);
    float largest = max(max(coordinates.x, coordinates.y), coordinates.z);
    vec3 origin = point + GNOMON_LIFT_PER_COORDINATE * largest * normal;
    vec3 to_light = perspective ? view.origin - origin : -view.forward;
    if (dot(normal, to_light) <= 0.0) return 0.0;
    vec4 clip = view.clip_from_world * vec4(point, 1);
    if (clip.w <= 0.0) return 1.0;
    vec2 at = 0.5 * clip.xy / clip.w + 0.5;
    if (any(lessThan(at, vec2(0))) || any(greaterThanEqual(at, vec2(1)))) return 1.0;

    uint side = max(view.size / GNOMON_CELL_TEXELS, 1u);
    uvec2 column = min(uvec2(at * float(side)), uvec2(side - 1u));
    uvec2 here = min(uvec2(256.0 * (at * float(side) - vec2(column))), uvec2(255u));
    uint list = cell_bases[number] + 2u * (column.y * side + column.x);
    float end = perspective ? GNOMON_SHADOW_RAY_END : 3.0e38;
    uint part = (here.y * GNOMON_BLOCK_PARTS / 256u) * GNOMON_BLOCK_PARTS + here.x * GNOMON_BLOCK_PARTS / 256u;
    vec3 eye = abs(view.origin);
    float far = dot(point - view.origin, view.forward) + k_along_slack * (largest + max(max(eye.x, eye.y), eye.z));

    // Let each invocation advance to its next candidate, then test all of them together. A device that runs invocations
    // in lock-step would otherwise test whenever any of them has a candidate.
    bool occluded = false;
    OCCLUDED_BY(list, static_first, static_blocks, static_entries, occludes)
    OCCLUDED_BY(list, moving_first, moving_blocks, moving_entries, occludes)
    OCCLUDED_BY(list + 1u, static_first, static_blocks, static_entries, occludes_masked)
    OCCLUDED_BY(list + 1u, moving_first, moving_blocks, moving_entries, occludes_masked)
    return occluded ? 0.0 : 1.0;
}
