// SPDX-License-Identifier: Apache-2.0
// Hard shadows with the edges of triangles: is there one between a point and the light? All that can be are in the list
// of the cell that the point falls into (light_views/vulkan/caster_cells.h). The ray is the traced frame's, and so is
// the test of it; so both frames have the same shadows, but for rounding.
//
// Cost: a word for each block of one cell's triangles, a comparison of bounds for those around the point's part of the
// cell, a test for those around the point, up to the first that blocks.

const float k_shadow_end = 0.9999;            // a shadow ray ends this fraction short of its lamp ...
const float k_lift_per_coordinate = 2e-6;     // ... and starts so far off its surface, as src/ray/origin.h has it
const float k_edge_slack = 1.1920929e-7;      // as src/ray/triangle_test.h
const float k_along_slack = 1e-5;              // of coordinates: more than that lift and the rounding of distances
const uint k_opaque = 0xffffffffu;

// The twin of ray::meets; alpha-tested triangles block where their material does.
bool blocks(CellEntry entry, vec3 origin, vec3 direction, float end)
{
    int offset = caster_offsets[entry.object];
    uvec3 corner;
    for (uint i = 0u; i < 3u; ++i) corner[i] = uint(int(caster_indices[3u * entry.triangle + i]) + offset);
    mat4 to_world = matrices[entry.object];
    vec3 p[3];
    for (uint i = 0u; i < 3u; ++i) {
        uint v = 3u * corner[i];
        p[i] = vec3(to_world * vec4(caster_positions[v], caster_positions[v + 1u], caster_positions[v + 2u], 1)) - origin;
    }
    vec3 e0 = p[2] - p[0], e1 = p[0] - p[1], e2 = p[1] - p[2];
    float u = dot(cross(e0, p[2] + p[0]), direction);
    float v = dot(cross(e1, p[0] + p[1]), direction);
    float w = dot(cross(e2, p[1] + p[2]), direction);
    float sum = u + v + w, slack = k_edge_slack * abs(sum);
    if (!(min(min(u, v), w) >= -slack || max(max(u, v), w) <= slack)) return false;
    vec3 normal = cross(e2, e0);
    float slope = dot(normal, direction);
    if (slope == 0.0 || sum == 0.0) return false;
    float t = dot(p[0], normal) / slope;
    if (!(t > 0.0 && t <= end)) return false;
    if (entry.material == k_opaque) return true;
    u /= sum, v /= sum;
    vec2 uv = (1.0 - u - v) * caster_texcoords[corner.x] + u * caster_texcoords[corner.y] + v * caster_texcoords[corner.z];
    return passes_alpha_test(alpha_materials[entry.material], uv);
}

bool is_around(uint bounds, uvec2 at)
{
    return at.x >= (bounds & 255u) && at.y >= (bounds >> 8u & 255u) && at.x <= (bounds >> 16u & 255u) && at.y <= bounds >> 24u;
}

// Goes through one set's list of the cell; a macro, for buffers are no arguments. `word`: entries of the block at
// `next`'s that are still to be looked at.
#define BLOCKED_BY(first, blocks_of, entries)                                                                          \
    {                                                                                                                  \
        uint next = first[cell], last = first[cell + 1u], block = next / GNOMON_BLOCK_ENTRIES, word = 0u;              \
        uint skip = next % GNOMON_BLOCK_ENTRIES;                                                                       \
        while (!blocked) {                                                                                             \
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
            blocked = blocks(entries[next], origin, to_light, end);                                                    \
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
    vec3 origin = point + k_lift_per_coordinate * largest * normal;
    vec3 to_light = perspective ? view.origin - origin : -view.forward;
    if (dot(normal, to_light) <= 0.0) return 0.0;
    vec4 clip = view.clip_from_world * vec4(point, 1);
    if (clip.w <= 0.0) return 1.0;
    vec2 at = 0.5 * clip.xy / clip.w + 0.5;
    if (any(lessThan(at, vec2(0))) || any(greaterThanEqual(at, vec2(1)))) return 1.0;

    uint side = max(view.size / GNOMON_CELL_TEXELS, 1u);
    uvec2 column = min(uvec2(at * float(side)), uvec2(side - 1u));
    uvec2 here = min(uvec2(256.0 * (at * float(side) - vec2(column))), uvec2(255u));
    uint cell = cell_bases[number] + column.y * side + column.x;
    float end = perspective ? k_shadow_end : 3.0e38;
    uint part = (here.y * GNOMON_BLOCK_PARTS / 256u) * GNOMON_BLOCK_PARTS + here.x * GNOMON_BLOCK_PARTS / 256u;
    vec3 eye = abs(view.origin);
    float far = dot(point - view.origin, view.forward) + k_along_slack * (largest + max(max(eye.x, eye.y), eye.z));

    // Each invocation goes on to its next triangle around the point, then all test theirs at once: a device that runs
    // them in step would else test whenever one of them has to.
    bool blocked = false;
    BLOCKED_BY(static_first, static_blocks, static_entries)
    BLOCKED_BY(moving_first, moving_blocks, moving_entries)
    return blocked ? 0.0 : 1.0;
}
