// SPDX-License-Identifier: Apache-2.0
#version 460
// The cut through the light tree for a surface point, by a work group. The reference implementation, which explains the
// formulas, is cut_tree() in src/irradiance_cache/light_tree/point_kernels.cpp.
//
// The group walks the tree from a shared stack, eight quads at a time, one node per invocation. Invocations append to
// lists in the order of their lanes, so lists have a fixed order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "irradiance_cache/vulkan/points_shared.h"

layout(local_size_x = GNOMON_POINT_LANES) in;
layout(binding = 0, scalar) readonly buffer Quads { GpuQuad at[]; } quads;
layout(binding = 1, scalar) readonly buffer Children { uint at[]; } children;   // by node: a quad, or none
layout(binding = 2, scalar) readonly buffer Roots { uint at[]; } roots;
layout(binding = 3, scalar) readonly buffer Places { vec4 at[]; } places;   // by node: for which visibility is tested
layout(binding = 4, scalar) readonly buffer Requests { GpuCutRequest at[]; } requests;
layout(binding = 5, scalar) writeonly buffer Cuts { GpuCut at[]; } cuts;
layout(binding = 6, scalar) buffer Count { uint nodes; } count_of;   // of all cuts
layout(binding = 7, scalar) writeonly buffer Nodes { GpuCutNode at[]; } nodes;
layout(binding = 8, scalar) coherent buffer Own { GpuCutNode at[]; } own;   // room for the cut of each point
layout(push_constant, scalar) uniform Push { PointCutPush push; };

const uint k_none = 0xffffffffu, k_lanes = GNOMON_POINT_LANES, k_quads = k_lanes / 4;
// A popped quad pushes at most four, and a tree has at most eight levels: 8 + 8 * 24 quads at a time. A node is not
// refined if there is no room.
const uint k_stack = 512;
// The same values as in point_kernels.cpp.
const float k_per_pi = 0.318309886183791, k_tiny = 1e-30, k_least_reach = 1e-6, k_second_order = 0.5, k_mixed = 0.1;
const float k_horizon = 0.1, k_likely = 0.05, k_most_lack = 1.25;

shared uint stack[k_stack];
shared uint top, next_root, group_count;
shared uint group[k_quads];
shared uint ballot;
shared uint kept[k_lanes];
shared uint kept_id[k_lanes];
shared uint kept_mixed[k_lanes];
shared float light_of[k_lanes];
shared float sums[k_lanes];
shared uint first;

#define lane gl_LocalInvocationID.x
vec3 origin, normal;

struct Node {
    float light, most, width, spread;
    bool there;
};

// The mean of max(x, 0) for x uniform within `reach` of its mean.
float rectified(float mean, float reach)
{
    reach = max(reach, k_least_reach);
    const float within = max(min(mean, reach) + reach, 0);
    return within * within / (4 * reach) + max(mean - reach, 0);
}

Node evaluate(uint id)
{
    const uint q = id >> 2, k = id & 3;
    const vec3 to = vec3(quads.at[q].x[k], quads.at[q].y[k], quads.at[q].z[k]) - origin;
    const vec3 n = vec3(quads.at[q].nx[k], quads.at[q].ny[k], quads.at[q].nz[k]);
    const float square = dot(to, to), inverse = 1 / sqrt(max(square, k_tiny));
    const float area = quads.at[q].area[k] * k_per_pi, flux = quads.at[q].flux[k];
    const float receiver = dot(to, normal) * inverse, source = -dot(to, n) * inverse;
    const float disk = k_per_pi / (square + area + k_tiny) * flux;
    Node node;
    node.width = quads.at[q].radius[k] * inverse;
    node.spread = max(1 - dot(n, n), 0);
    const float reach = sqrt(node.spread);
    const float r = max(receiver, 0), e = rectified(source, reach);
    node.most = min(r + node.width, 1) * clamp(source + node.width + reach, 0, 1) * disk;
    const float solid = area / max(square, k_tiny), near = min(solid, k_second_order), beyond = solid - near;
    const float change = near * (receiver * (1 - 3 * e * e) - dot(n, normal) * e);
    const float cosine = change > 0 ? max(receiver + change, 0) : r * r / max(r - change, k_tiny);
    node.light = cosine * e * (k_per_pi / max(square * (1 + beyond), k_tiny) * flux);
    node.there = flux > 0 && receiver + node.width > 0;
    return node;
}

// A bit for each invocation for which `yes` is true.
uint vote(bool yes)
{
    barrier();
    if (lane == 0) ballot = 0;
    barrier();
    if (yes) atomicOr(ballot, 1u << lane);
    barrier();
    return ballot;
}

uint before(uint votes)
{
    return bitCount(votes & ((1u << lane) - 1));
}

float sum_of_all(float mine)
{
    barrier();
    sums[lane] = mine;
    barrier();
    float sum = 0;
    for (uint i = 0; i < k_lanes; ++i) sum += sums[i];
    return sum;
}

void begin_walk()
{
    barrier();
    if (lane == 0) top = next_root = 0;
}

// Pops the next quads off the stack; false if there are none.
bool next_group()
{
    barrier();
    if (lane == 0) {
        while (top < k_quads && next_root < push.roots) stack[top++] = roots.at[next_root++];
        group_count = min(top, k_quads);
        for (uint i = 0; i < group_count; ++i) group[i] = stack[--top];
    }
    barrier();
    return group_count > 0;
}

bool has_room()
{
    return top + k_lanes <= k_stack;
}

void refine_into(bool refines, uint below)
{
    const uint votes = vote(refines);
    if (refines) stack[top + before(votes)] = below;
    barrier();
    if (lane == 0) top += bitCount(votes);
}

bool matters(Node node, float wrong)
{
    const float width = max(node.width, node.spread);
    return node.most * (width > push.nearest ? 1 : width) > wrong;
}

// Estimates the light of all nodes, visibility ignored, from a cut whose nodes have error bounds of at most `wrong`.
// With 0, the cut is the roots, and the estimate is above 0 wherever any light might arrive.
float estimate(float wrong)
{
    float total = 0, most = 0;
    begin_walk();
    while (next_group()) {
        bool refines = false, keeps = false;
        uint below = k_none;
        if (lane < 4 * group_count) {
            const uint id = 4 * group[lane / 4] + lane % 4;
            const Node node = evaluate(id);
            if (node.there) {
                below = children.at[id];
                refines = wrong > 0 && below != k_none && matters(node, wrong) && has_room();
                if (!refines) {
                    most += node.most;
                    if (below == k_none) total += node.light;
                    keeps = below != k_none;
                }
            }
        }
        refine_into(refines, below);
        // The light of a kept node is that of its children.
        const uint votes = vote(keeps), count = bitCount(votes);
        if (keeps) kept[before(votes)] = below;
        barrier();
        for (uint k = lane / 4; k < count; k += k_quads) total += evaluate(4 * kept[k] + lane % 4).light;
    }
    total = sum_of_all(total), most = sum_of_all(most);
    return wrong > 0 ? total : max(total, k_likely * most);
}

void main()
{
    const uint point = gl_WorkGroupID.x;
    origin = requests.at[point].origin, normal = requests.at[point].normal;
    // Estimate the light of all nodes by coarse cuts, each of which gives the error threshold of the next.
    float total = estimate(0);
    if (total > 0) total = estimate(0.3 * total);
    if (total > 0) total = estimate(requests.at[point].estimate * total);

    // Refine each node whose error bound exceeds the threshold [Walter et al. 2005, Section 4].
    const float wrong = requests.at[point].error * total, negligible = push.negligible * total;
    const uint own_first = point * GNOMON_CUT_ROOM;
    uint cut_length = 0;
    float arrives = 0;   // of this invocation
    begin_walk();
    while (next_group()) {
        bool leaf = false, refines = false, waits = false;
        uint id = 0, below = k_none;
        float light = 0, flux = 1;
        bool mixed = false;
        if (lane < 4 * group_count) {
            id = 4 * group[lane / 4] + lane % 4;
            const Node node = evaluate(id);
            if (node.there) {
                below = children.at[id];
                leaf = below == k_none;
                refines = !leaf && matters(node, wrong) && has_room();
                waits = !leaf && !refines;
                light = node.light, flux = quads.at[id >> 2].flux[id & 3];
                // One place must represent the whole node.
                const vec3 to = places.at[id].xyz - origin;
                mixed = node.spread > k_mixed || dot(to, normal) < k_horizon * length(to);
            }
        }
        refine_into(refines, below);

        const bool keeps_leaf = leaf && light > negligible;
        uint votes = vote(keeps_leaf);
        if (keeps_leaf) {
            const uint at = cut_length + before(votes);
            if (at < GNOMON_CUT_ROOM) own.at[own_first + at] = GpuCutNode(id, light / flux);
            arrives += light;
        }
        cut_length += bitCount(votes);

        // Keep the others with the light of their children, or their children one by one.
        votes = vote(waits);
        const uint count = bitCount(votes);
        if (waits) {
            kept[before(votes)] = below;
            kept_id[before(votes)] = id;
            kept_mixed[before(votes)] = mixed ? 1 : 0;
        }
        barrier();
        for (uint base = 0; base < count; base += k_quads) {
            const uint k = base + lane / 4, part = lane % 4;
            bool there = false;
            light = 0;
            if (k < count) {
                const Node node = evaluate(4 * kept[k] + part);
                light = node.light;
                there = node.there && kept_mixed[k] != 0;
            }
            barrier();
            light_of[lane] = light;
            barrier();
            id = 0, flux = 1;
            if (k < count) {
                if (there) {
                    id = 4 * kept[k] + part;
                } else if (kept_mixed[k] == 0 && part == 0) {
                    id = kept_id[k];
                    light = light_of[lane] + light_of[lane + 1] + (light_of[lane + 2] + light_of[lane + 3]);
                    there = true;
                }
            }
            there = there && light > negligible;
            const uint keeping = vote(there);
            if (there) {
                const uint at = cut_length + before(keeping);
                flux = quads.at[id >> 2].flux[id & 3];
                if (at < GNOMON_CUT_ROOM) own.at[own_first + at] = GpuCutNode(id, light / flux);
                arrives += light;
            }
            cut_length += bitCount(keeping);
        }
    }
    // Coarse nodes are too dark because the kernel is convex. Scale all weights to make up for it.
    arrives = sum_of_all(arrives);
    const float factor = arrives > 0 ? clamp(total / arrives, 1, k_most_lack) : 1;
    const uint kept_count = min(cut_length, GNOMON_CUT_ROOM);
    // Append the cut to those of other groups.
    memoryBarrierBuffer();
    if (lane == 0) {
        first = atomicAdd(count_of.nodes, kept_count);
        cuts.at[point] = GpuCut(first, cut_length);
    }
    barrier();
    for (uint k = lane; k < kept_count; k += k_lanes)
        nodes.at[first + k] = GpuCutNode(own.at[own_first + k].node, factor * own.at[own_first + k].weight);
}
