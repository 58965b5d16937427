// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
// LONG: boxes, triangles and both traversals stay in registers together, and in one dispatch.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ray/portable/kernels.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "ray/portable/judge.h"
#include "ray/portable/kernels.h"
#include "ray/triangle_test.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::ray::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_HAVE_SCALABLE
constexpr std::size_t k_lanes = 4;
#else
constexpr std::size_t k_lanes = std::min<std::size_t>(k_packet_rays, HWY_MAX_BYTES / sizeof(float));
#endif
using Wide = hn::FixedTag<float, k_lanes>;
using Four = hn::FixedTag<float, 4>;
constexpr std::size_t k_boxes = std::min(k_lanes, TreeNode::k_width);   // of a node that are tested at once
using Boxes = hn::FixedTag<float, k_boxes>;
using VB = hn::Vec<Boxes>;
using V = hn::Vec<Wide>;
using V4 = hn::Vec<Four>;

// With fewer rays in a node, they go on singly.
constexpr int k_least_together = 4;
constexpr std::size_t k_stack = 256;   // seven for each level of the deepest tree
// The inverse of a direction, where it is 0: finite, so that no product with a difference of coordinates is NaN.
constexpr float k_largest_slope = 1e37f;
// Boxes are entered up to this fraction behind the nearest hit, because distances of hits are rounded.
constexpr float k_hit_slack = 1e-5f;

// The rays of a packet in the space of one tree.
struct Rays {
    alignas(64) float origin[3][k_packet_rays];
    // The origin with the margin that boxes get: for their low sides and for their high sides.
    alignas(64) float for_low[3][k_packet_rays], for_high[3][k_packet_rays];
    alignas(64) float inverse[3][k_packet_rays];
    // With the axis of the largest component last: the direction, and its first two over the last.
    alignas(64) float turned[3][k_packet_rays], shear[2][k_packet_rays];
    // Bits of lanes: whose component of the direction is negative; with the largest component along x, along y.
    unsigned negative[3], along_x, along_y;
    unsigned backward;            // whose largest component is negative
    bool same_axis, same_signs;   // of all lanes in use
    // With the same signs: the least and largest values of all lanes.
    float least_for_low[3], most_for_low[3], least_for_high[3], most_for_high[3], least_inverse[3], most_inverse[3];
    float least_near;

    bool down(int axis, std::size_t lane) const { return ((negative[axis] >> lane) & 1) != 0; }
    // The axis with the largest component, and whether that is negative.
    int along(std::size_t lane) const { return (along_x >> lane) & 1 ? 0 : (along_y >> lane) & 1 ? 1 : 2; }
    unsigned first;   // lane in use
};

template <class D>
HWY_INLINE unsigned bits_of(D d, hn::Mask<D> mask)
{
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return (bytes[0] | static_cast<unsigned>(bytes[1]) << 8) & ((1u << hn::MaxLanes(d)) - 1);
}

template <class D>
HWY_INLINE hn::Mask<D> mask_of(D d, unsigned bits)
{
    bits &= (1u << hn::MaxLanes(d)) - 1;
    const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8)};
    return hn::LoadMaskBits(d, bytes);
}

// @pre origin and `direction` are set
HWY_INLINE float least_of(const float* values)
{
    const Wide d;
    V v = hn::Load(d, values);
    for (std::size_t at = k_lanes; at < k_packet_rays; at += k_lanes) v = hn::Min(v, hn::Load(d, values + at));
    return hn::GetLane(hn::MinOfLanes(d, v));
}
HWY_INLINE float most_of(const float* values)
{
    const Wide d;
    V v = hn::Load(d, values);
    for (std::size_t at = k_lanes; at < k_packet_rays; at += k_lanes) v = hn::Max(v, hn::Load(d, values + at));
    return hn::GetLane(hn::MaxOfLanes(d, v));
}

HWY_INLINE void prepare(Rays& rays, const float (&direction)[3][k_packet_rays], const float* tnear, unsigned lanes)
{
    const Wide d;
    const V one = hn::Set(d, 1.0f), margin = hn::Set(d, k_box_margin);
    const V steepest = hn::Set(d, k_largest_slope), flattest = hn::Set(d, -k_largest_slope);
    for (std::size_t at = 0; at < k_packet_rays; at += k_lanes) {
        V largest = hn::Zero(d);
        for (int a = 0; a < 3; ++a) largest = hn::Max(largest, hn::Abs(hn::Load(d, rays.origin[a] + at)));
        const V room = hn::Mul(margin, largest);
        for (int a = 0; a < 3; ++a) {
            const V o = hn::Load(d, rays.origin[a] + at);
            hn::Store(hn::Add(o, room), d, rays.for_low[a] + at);
            hn::Store(hn::Sub(o, room), d, rays.for_high[a] + at);
            const V slope = hn::Div(one, hn::Load(d, direction[a] + at));
            hn::Store(hn::Max(hn::Min(slope, steepest), flattest), d, rays.inverse[a] + at);
        }
    }
    rays.negative[0] = rays.negative[1] = rays.negative[2] = rays.along_x = rays.along_y = 0;
    for (std::size_t at = 0; at < k_packet_rays; at += k_lanes) {
        V along[3], slope[3];
        for (int a = 0; a < 3; ++a) {
            along[a] = hn::Load(d, direction[a] + at), slope[a] = hn::Load(d, rays.inverse[a] + at);
            rays.negative[a] |= bits_of(d, hn::Lt(slope[a], hn::Zero(d))) << at;
        }
        const V x = hn::Abs(along[0]), y = hn::Abs(along[1]), z = hn::Abs(along[2]);
        const auto by_x = hn::And(hn::Gt(x, y), hn::Gt(x, z)), by_y = hn::AndNot(hn::Gt(x, y), hn::Gt(y, z));
        const auto choose = [&](V if_x, V if_y, V if_z)
                                HWY_ATTR { return hn::IfThenElse(by_x, if_x, hn::IfThenElse(by_y, if_y, if_z)); };
        const V scale = choose(slope[0], slope[1], slope[2]);
        const V turned[3] = {choose(along[1], along[2], along[0]), choose(along[2], along[0], along[1]),
                             choose(along[0], along[1], along[2])};
        for (int a = 0; a < 3; ++a) hn::Store(turned[a], d, rays.turned[a] + at);
        for (int a = 0; a < 2; ++a) hn::Store(hn::Mul(turned[a], scale), d, rays.shear[a] + at);
        rays.along_x |= bits_of(d, by_x) << at, rays.along_y |= bits_of(d, by_y) << at;
    }
    rays.backward = (rays.along_x & rays.negative[0]) | (rays.along_y & rays.negative[1]) |
                    (~(rays.along_x | rays.along_y) & rays.negative[2]);
    const auto agree = [lanes](unsigned bits) { return (bits & lanes) == 0 || (bits & lanes) == lanes; };
    rays.first = static_cast<unsigned>(std::countr_zero(lanes));
    rays.same_axis = agree(rays.along_x) && agree(rays.along_y);
    rays.same_signs = agree(rays.negative[0]) && agree(rays.negative[1]) && agree(rays.negative[2]);
    if (!rays.same_signs || std::popcount(lanes) < k_least_together) return;
    for (int a = 0; a < 3; ++a) {
        rays.least_for_low[a] = least_of(rays.for_low[a]), rays.most_for_low[a] = most_of(rays.for_low[a]);
        rays.least_for_high[a] = least_of(rays.for_high[a]), rays.most_for_high[a] = most_of(rays.for_high[a]);
        rays.least_inverse[a] = least_of(rays.inverse[a]), rays.most_inverse[a] = most_of(rays.inverse[a]);
    }
    rays.least_near = least_of(tnear);
}

// The distance of a hit along a ray, rounded once but for one in many millions: surfaces that meet at an edge are
// equally far there, so that the order of objects decides, and not rounding.
inline float distance_of(const Rays& rays, std::size_t lane, const TriangleBlock& block, unsigned which)
{
    const int k = rays.along(lane);
    glm::dvec3 origin, direction, corner[3];
    for (int i = 0; i < 3; ++i) {
        const int axis = (k + 1 + i) % 3;
        origin[axis] = static_cast<double>(rays.origin[axis][lane]);
        direction[axis] = static_cast<double>(rays.turned[i][lane]);
        for (int c = 0; c < 3; ++c) corner[c][axis] = static_cast<double>(block.corner[c][axis][which]);
    }
    const glm::dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    return static_cast<float>(glm::dot(corner[0] - origin, normal) / glm::dot(direction, normal));
}

// The state of a trace.
template <bool any>
struct Trace {
    const RayQuery& query;
    RayPacket& packet;
    alignas(64) float limit[k_packet_rays];   // ends of the rays, for boxes: with slack, or -1 if done
    unsigned open;                            // any: lanes that are not occluded yet
    const TreeInstance* instance = nullptr;

    Trace(const RayQuery& q, RayPacket& p, unsigned lanes) : query(q), packet(p), open(lanes)
    {
        for (std::size_t i = 0; i < k_packet_rays; ++i) {
            limit[i] = -1;
            if ((lanes >> i) & 1) set_limit(i);
        }
    }
    void set_limit(std::size_t lane) { limit[lane] = packet.t[lane] + k_hit_slack * packet.t[lane]; }

    // Takes a hit of a lane, unless the surface is not there for this ray.
    void take(const Rays& rays, std::size_t lane, const TriangleBlock& block, unsigned which, float u, float v)
    {
        if constexpr (any) {
            const std::uint8_t judged = block.judged_any[which];
            if ((judged & TriangleBlock::k_by_distance) != 0) {
                // A ray that starts on a narrow triangle would hit it by rounding.
                const float t = distance_of(rays, lane, block, which);
                if (!(t > packet.tnear[lane] && t <= packet.t[lane])) return;
            }
            if ((judged & TriangleBlock::k_by_material) != 0 &&
                !occludes(*instance, block.geometry[which], block.triangle[which], u, v, query, lane))
                return;
            open &= ~(1u << lane);
            limit[lane] = -1;
        } else {
            if (block.judged_closest[which] && is_hole(*instance, block.geometry[which], block.triangle[which], u, v))
                return;
            const float t = distance_of(rays, lane, block, which);
            if (!(t > packet.tnear[lane] && t <= packet.t[lane])) return;
            if (t == packet.t[lane] && packet.instance[lane] &&
                !comes_first(*instance, block.geometry[which], block.triangle[which], *packet.instance[lane],
                             packet.geometry[lane], packet.triangle[lane]))
                return;
            packet.t[lane] = t, packet.u[lane] = u, packet.v[lane] = v;
            packet.geometry[lane] = block.geometry[which], packet.triangle[lane] = block.triangle[which];
            packet.instance[lane] = instance;
            set_limit(lane);
        }
    }
};

// The test of triangles, the same for one ray and four triangles as for several rays and one triangle. Corners are
// relative to the ray's origin: a along the next axis, b along the one after it, c along the ray's.
template <class D>
struct Tested {
    hn::Vec<D> t, u, v, sum;
    hn::Mask<D> hit;
};
template <class D>
HWY_INLINE Tested<D> test(D d, const hn::Vec<D> (&a)[3], const hn::Vec<D> (&b)[3], const hn::Vec<D> (&c)[3],
                          hn::Vec<D> shear_a, hn::Vec<D> shear_b, hn::Vec<D> along_a, hn::Vec<D> along_b,
                          hn::Vec<D> along_c, hn::Vec<D> tnear, hn::Vec<D> tfar)
{
    const auto ax = hn::Sub(a[0], hn::Mul(shear_a, c[0])), ay = hn::Sub(b[0], hn::Mul(shear_b, c[0]));
    const auto bx = hn::Sub(a[1], hn::Mul(shear_a, c[1])), by = hn::Sub(b[1], hn::Mul(shear_b, c[1]));
    const auto cx = hn::Sub(a[2], hn::Mul(shear_a, c[2])), cy = hn::Sub(b[2], hn::Mul(shear_b, c[2]));
    const auto u = hn::Sub(hn::Mul(cx, by), hn::Mul(cy, bx));
    const auto v = hn::Sub(hn::Mul(ax, cy), hn::Mul(ay, cx));
    const auto w = hn::Sub(hn::Mul(bx, ay), hn::Mul(by, ax));
    const auto sum = hn::Add(hn::Add(u, v), w);
    const auto slack = hn::Mul(hn::Set(d, k_edge_slack), hn::Abs(sum));
    const auto least = hn::Min(hn::Min(u, v), w), most = hn::Max(hn::Max(u, v), w);
    Tested<D> result;
    result.sum = sum;
    result.hit = hn::And(hn::Or(hn::Ge(least, hn::Neg(slack)), hn::Le(most, slack)), hn::Ne(sum, hn::Zero(d)));
    if (hn::AllFalse(d, result.hit)) return result;
    // The distance to the plane, from the ray's own direction: planes that meet at an edge are equally far there.
    const auto a1 = hn::Sub(a[1], a[0]), b1 = hn::Sub(b[1], b[0]), c1 = hn::Sub(c[1], c[0]);
    const auto a2 = hn::Sub(a[2], a[0]), b2 = hn::Sub(b[2], b[0]), c2 = hn::Sub(c[2], c[0]);
    const auto na = hn::Sub(hn::Mul(b1, c2), hn::Mul(c1, b2)), nb = hn::Sub(hn::Mul(c1, a2), hn::Mul(a1, c2)),
               nc = hn::Sub(hn::Mul(a1, b2), hn::Mul(b1, a2));
    const auto height = hn::Add(hn::Add(hn::Mul(na, a[0]), hn::Mul(nb, b[0])), hn::Mul(nc, c[0]));
    const auto slope = hn::Add(hn::Add(hn::Mul(na, along_a), hn::Mul(nb, along_b)), hn::Mul(nc, along_c));
    result.t = hn::Div(height, slope);
    result.hit = hn::And(result.hit, hn::Ne(slope, hn::Zero(d)));
    result.hit = hn::And(result.hit, hn::And(hn::Gt(result.t, tnear), hn::Le(result.t, tfar)));
    result.u = v, result.v = w;   // times sum
    return result;
}

// Tests one ray against the triangles of a leaf.
template <bool any>
HWY_INLINE void meet_leaf(Trace<any>& trace, const Rays& rays, std::size_t lane, std::uint32_t leaf)
{
    const Four d;
    const int k = rays.along(lane), next = (k + 1) % 3, last = (k + 2) % 3;
    const V4 oa = hn::Set(d, rays.origin[next][lane]), ob = hn::Set(d, rays.origin[last][lane]),
             oc = hn::Set(d, rays.origin[k][lane]);
    const V4 shear_a = hn::Set(d, rays.shear[0][lane]), shear_b = hn::Set(d, rays.shear[1][lane]),
             along_a = hn::Set(d, rays.turned[0][lane]), along_b = hn::Set(d, rays.turned[1][lane]),
             along_c = hn::Set(d, rays.turned[2][lane]), tnear = hn::Set(d, trace.packet.tnear[lane]);
    const TriangleBlock* block = trace.instance->tree->blocks() + TreeNode::first_of(leaf);
    for (const TriangleBlock* const past = block + TreeNode::items_of(leaf); block != past; ++block) {
        V4 a[3], b[3], c[3];
        for (int i = 0; i < 3; ++i) {
            a[i] = hn::Sub(hn::Load(d, block->corner[i][next]), oa);
            b[i] = hn::Sub(hn::Load(d, block->corner[i][last]), ob);
            c[i] = hn::Sub(hn::Load(d, block->corner[i][k]), oc);
        }
        const auto tested = test(d, a, b, c, shear_a, shear_b, along_a, along_b, along_c, tnear,
                                 hn::Set(d, any ? trace.packet.t[lane] : trace.limit[lane]));
        unsigned hits = bits_of(d, tested.hit);
        if (hits == 0) continue;
        if (!any && trace.query.front_only) {
            unsigned behind = bits_of(d, hn::Lt(tested.sum, hn::Zero(d)));
            if (((rays.backward >> lane) & 1) != 0) behind = ~behind;
            hits &= ~((behind & block->unmet[1]) | (~behind & block->unmet[0]));
            if (hits == 0) continue;
        }
        alignas(16) float u[4], v[4], sum[4];
        hn::Store(tested.u, d, u), hn::Store(tested.v, d, v), hn::Store(tested.sum, d, sum);
        for (; hits != 0; hits &= hits - 1) {
            const auto i = static_cast<unsigned>(std::countr_zero(hits));
            if ((block->mask[i] & trace.query.mask) == 0) continue;
            trace.take(rays, lane, *block, i, u[i] / sum[i], v[i] / sum[i]);
            if constexpr (any)
                if (trace.limit[lane] < 0) return;
        }
    }
}

// Traces one ray through the part of a tree below `root`.
template <bool any>
void trace_single(Trace<any>& trace, const Rays& rays, std::size_t lane, std::uint32_t root)
{
    struct Later {
        std::uint32_t node;
        float near;
    };
    const Boxes d;
    Later stack[k_stack];
    std::size_t waiting = 0;
    const TreeNode* const nodes = trace.instance->tree->nodes();
    VB entry[3], leave[3], inverse[3];
    bool down[3];
    for (int a = 0; a < 3; ++a) {
        down[a] = rays.down(a, lane);
        entry[a] = hn::Set(d, down[a] ? rays.for_high[a][lane] : rays.for_low[a][lane]);
        leave[a] = hn::Set(d, down[a] ? rays.for_low[a][lane] : rays.for_high[a][lane]);
        inverse[a] = hn::Set(d, rays.inverse[a][lane]);
    }
    const VB tnear = hn::Set(d, trace.packet.tnear[lane]);
    std::uint32_t at = root;
    for (;;) {
        while (!TreeNode::is_leaf(at)) {
            const TreeNode& node = nodes[at];
            alignas(32) [[maybe_unused]] float near[TreeNode::k_width];
            unsigned hits = 0;
            for (std::size_t from = 0; from < TreeNode::k_width; from += k_boxes) {
                VB low = tnear, high = hn::Set(d, trace.limit[lane]);
                for (int a = 0; a < 3; ++a) {
                    const VB first = hn::Load(d, (down[a] ? node.high[a] : node.low[a]) + from),
                             second = hn::Load(d, (down[a] ? node.low[a] : node.high[a]) + from);
                    low = hn::Max(low, hn::Mul(hn::Sub(first, entry[a]), inverse[a]));
                    high = hn::Min(high, hn::Mul(hn::Sub(second, leave[a]), inverse[a]));
                }
                hits |= bits_of(d, hn::Le(low, high)) << from;
                if constexpr (!any) hn::Store(low, d, near + from);
            }
            hits &= (1u << node.count) - 1;
            if (hits == 0) goto next;
            unsigned nearest = static_cast<unsigned>(std::countr_zero(hits));
            hits &= hits - 1;
            if constexpr (any) {
                // In any order: a node's children are sorted by the sizes of their boxes.
                for (; hits != 0; hits &= hits - 1)
                    stack[waiting++].node = node.child[static_cast<unsigned>(std::countr_zero(hits))];
            } else if (hits != 0) {
                const std::size_t first = waiting;
                for (; hits != 0; hits &= hits - 1) {
                    auto i = static_cast<unsigned>(std::countr_zero(hits));
                    if (near[i] < near[nearest]) std::swap(i, nearest);
                    // Keep the farther ones below the nearer ones.
                    std::size_t to = waiting++;
                    for (; to > first && stack[to - 1].near < near[i]; --to) stack[to] = stack[to - 1];
                    stack[to] = {node.child[i], near[i]};
                }
            }
            at = node.child[nearest];
        }
        meet_leaf(trace, rays, lane, at);
        if constexpr (any)
            if (trace.limit[lane] < 0) return;
    next:
        do {
            if (waiting == 0) return;
            at = stack[--waiting].node;
        } while (!any && stack[waiting].near > trace.limit[lane]);
    }
}

// Tests several rays against the triangles of a leaf.
// @param same_axis  their directions have one main axis
template <bool any, bool same_axis>
HWY_INLINE void meet_leaf(Trace<any>& trace, const Rays& rays, unsigned lanes, std::uint32_t leaf)
{
    const Wide d;
    const int k = same_axis ? rays.along(rays.first) : 2, next = (k + 1) % 3, last = (k + 2) % 3;
    const TriangleBlock* block = trace.instance->tree->blocks() + TreeNode::first_of(leaf);
    for (const TriangleBlock* const past = block + TreeNode::items_of(leaf); block != past; ++block)
        for (unsigned i = 0; i < 4; ++i) {
            if ((block->mask[i] & trace.query.mask) == 0) continue;
            for (std::size_t at = 0; at < k_packet_rays; at += k_lanes) {
                const V oa = hn::Load(d, rays.origin[next] + at), ob = hn::Load(d, rays.origin[last] + at),
                        oc = hn::Load(d, rays.origin[k] + at);
                V a[3], b[3], c[3];
                for (int p = 0; p < 3; ++p) {
                    a[p] = hn::Sub(hn::Set(d, block->corner[p][next][i]), oa);
                    b[p] = hn::Sub(hn::Set(d, block->corner[p][last][i]), ob);
                    c[p] = hn::Sub(hn::Set(d, block->corner[p][k][i]), oc);
                    if constexpr (!same_axis) {
                        const auto by_x = mask_of(d, rays.along_x >> at), by_y = mask_of(d, rays.along_y >> at);
                        const V x = a[p], y = b[p], z = c[p];
                        a[p] = hn::IfThenElse(by_x, y, hn::IfThenElse(by_y, z, x));
                        b[p] = hn::IfThenElse(by_x, z, hn::IfThenElse(by_y, x, y));
                        c[p] = hn::IfThenElse(by_x, x, hn::IfThenElse(by_y, y, z));
                    }
                }
                const auto tested = test(d, a, b, c, hn::Load(d, rays.shear[0] + at), hn::Load(d, rays.shear[1] + at),
                                         hn::Load(d, rays.turned[0] + at), hn::Load(d, rays.turned[1] + at),
                                         hn::Load(d, rays.turned[2] + at), hn::Load(d, trace.packet.tnear + at),
                                         hn::Load(d, (any ? trace.packet.t : trace.limit) + at));
                unsigned hits = bits_of(d, tested.hit) & (lanes >> at);
                if constexpr (any) hits &= trace.open >> at;
                if (hits == 0) continue;
                if (!any && trace.query.front_only) {
                    const unsigned behind = bits_of(d, hn::Lt(tested.sum, hn::Zero(d))) ^ (rays.backward >> at);
                    if (((block->unmet[1] >> i) & 1) != 0) hits &= ~behind;
                    if (((block->unmet[0] >> i) & 1) != 0) hits &= behind;
                    if (hits == 0) continue;
                }
                alignas(64) float u[k_lanes], v[k_lanes];
                hn::Store(hn::Div(tested.u, tested.sum), d, u), hn::Store(hn::Div(tested.v, tested.sum), d, v);
                for (; hits != 0; hits &= hits - 1) {
                    const auto lane = static_cast<std::size_t>(std::countr_zero(hits));
                    trace.take(rays, at + lane, *block, i, u[lane], v[lane]);
                }
            }
        }
}

// Where the rays of a packet enter a box, infinite where they miss it. @return bits of the lanes that meet it
template <bool same_signs>
HWY_INLINE unsigned enter(const TreeNode& node, unsigned i, const Rays& rays, const float* tnear, const float* limit,
                          float* near)
{
    const Wide d;
    unsigned bits = 0;
    for (std::size_t at = 0; at < k_packet_rays; at += k_lanes) {
        V low = hn::Load(d, tnear + at), high = hn::Load(d, limit + at);
        for (int a = 0; a < 3; ++a) {
            const V inverse = hn::Load(d, rays.inverse[a] + at);
            const V below = hn::Mul(hn::Sub(hn::Set(d, node.low[a][i]), hn::Load(d, rays.for_low[a] + at)), inverse);
            const V above = hn::Mul(hn::Sub(hn::Set(d, node.high[a][i]), hn::Load(d, rays.for_high[a] + at)), inverse);
            if constexpr (same_signs) {
                const bool down = rays.down(a, rays.first);
                low = hn::Max(low, down ? above : below);
                high = hn::Min(high, down ? below : above);
            } else {
                low = hn::Max(low, hn::Min(below, above));
                high = hn::Min(high, hn::Max(below, above));
            }
        }
        const auto meets = hn::Le(low, high);
        bits |= bits_of(d, meets) << at;
        hn::Store(hn::IfThenElse(meets, low, hn::Set(d, k_infinity)), d, near + at);
    }
    return bits;
}

// The children of a node that any of the rays may meet, by the bounds of their origins and directions. @pre all have
// the same signs
HWY_INLINE unsigned some_enter(const TreeNode& node, const Rays& rays, float farthest)
{
    const Boxes d;
    unsigned bits = 0;
    for (std::size_t from = 0; from < TreeNode::k_width; from += k_boxes) {
        VB low = hn::Set(d, rays.least_near), high = hn::Set(d, farthest);
        for (int a = 0; a < 3; ++a) {
            const bool down = rays.down(a, rays.first);
            const VB least = hn::Set(d, rays.least_inverse[a]), most = hn::Set(d, rays.most_inverse[a]);
            // The distances that are least for the near side and largest for the far side.
            const VB to_near = down ? hn::Sub(hn::Load(d, node.high[a] + from), hn::Set(d, rays.least_for_high[a]))
                                    : hn::Sub(hn::Load(d, node.low[a] + from), hn::Set(d, rays.most_for_low[a]));
            const VB to_far = down ? hn::Sub(hn::Load(d, node.low[a] + from), hn::Set(d, rays.most_for_low[a]))
                                   : hn::Sub(hn::Load(d, node.high[a] + from), hn::Set(d, rays.least_for_high[a]));
            low = hn::Max(low, hn::Min(hn::Mul(to_near, least), hn::Mul(to_near, most)));
            high = hn::Min(high, hn::Max(hn::Mul(to_far, least), hn::Mul(to_far, most)));
        }
        bits |= bits_of(d, hn::Le(low, high)) << from;
    }
    return bits;
}

// Traces a packet through a tree. Leaf: void(std::uint32_t leaf, unsigned lanes); few: the same for the nodes that few
// rays meet.
template <bool any, bool same_signs, class Leaf, class Few>
HWY_INLINE void trace_packet(Trace<any>& trace, const Rays& rays, const TreeNode* nodes, unsigned lanes, Leaf&& leaf,
                             Few&& few)
{
    struct alignas(64) Later {
        float near[k_packet_rays];
        std::uint32_t node;
    };
    const Wide d;
    Later stack[k_stack];
    std::size_t waiting = 0;
    std::uint32_t at = 0;
    const unsigned all = lanes;
    float farthest = most_of(trace.limit);
    for (;;) {
        if (std::popcount(lanes) < k_least_together) {
            few(at, lanes);
        } else if (TreeNode::is_leaf(at)) {
            leaf(at, lanes);
        } else {
            const TreeNode& node = nodes[at];
            unsigned nearest_lanes = 0;
            float nearest = k_infinity;
            Later* const first = stack + waiting;
            Later* best = nullptr;
            unsigned some = (1u << node.count) - 1;
            if constexpr (same_signs) some &= some_enter(node, rays, farthest);
            for (; some != 0; some &= some - 1) {
                const auto i = static_cast<unsigned>(std::countr_zero(some));
                Later& later = stack[waiting];
                const unsigned bits =
                    enter<same_signs>(node, i, rays, trace.packet.tnear, trace.limit, later.near) & lanes;
                if (bits == 0) continue;
                later.node = node.child[i];
                ++waiting;
                // Any lane gives the order; it does not change the result.
                const float near = later.near[std::countr_zero(bits)];
                if (!best || near < nearest) best = &later, nearest = near, nearest_lanes = bits;
            }
            if (best) {
                at = best->node, lanes = nearest_lanes;
                *best = stack[--waiting];
                // Two are left to be sorted, or three.
                if constexpr (!any) {
                    const auto order = [](const Later& a) {
                        float low = a.near[0];
                        for (const float x : a.near) low = std::min(low, x);
                        return low;
                    };
                    const auto left = static_cast<std::size_t>(stack + waiting - first);
                    if (left == 2 && order(first[0]) < order(first[1])) std::swap(first[0], first[1]);
                }
                continue;
            }
        }
        // Take the next node that some rays still reach.
        for (;;) {
            if (waiting == 0) return;
            const Later& later = stack[--waiting];
            lanes = 0;
            for (std::size_t i = 0; i < k_packet_rays; i += k_lanes)
                lanes |= bits_of(d, hn::Le(hn::Load(d, later.near + i), hn::Load(d, trace.limit + i))) << i;
            lanes &= all;
            if constexpr (any) lanes &= trace.open;
            if (lanes == 0) continue;
            at = later.node;
            if constexpr (!any) farthest = most_of(trace.limit);
            break;
        }
    }
}

// Traces rays through the tree of an instance.
template <bool any>
HWY_INLINE void trace_tree(Trace<any>& trace, const Rays& rays, unsigned lanes)
{
    const auto leaf = [&](std::uint32_t at, unsigned which) HWY_ATTR {
        if (rays.same_axis)
            meet_leaf<any, true>(trace, rays, which, at);
        else
            meet_leaf<any, false>(trace, rays, which, at);
    };
    const auto few = [&](std::uint32_t at, unsigned which) HWY_ATTR {
        for (; which != 0; which &= which - 1)
            trace_single(trace, rays, static_cast<std::size_t>(std::countr_zero(which)), at);
    };
    const TreeNode* const nodes = trace.instance->tree->nodes();
    if (rays.same_signs)
        trace_packet<any, true>(trace, rays, nodes, lanes, leaf, few);
    else
        trace_packet<any, false>(trace, rays, nodes, lanes, leaf, few);
}

template <bool any>
void trace_instance(Trace<any>& trace, const Rays& world, const TreeInstance& instance, unsigned lanes)
{
    if constexpr (any) lanes &= trace.open;
    if (lanes == 0) return;
    trace.instance = &instance;
    if (instance.identity) return trace_tree(trace, world, lanes);
    const Wide d;
    Rays own;
    alignas(64) float direction[3][k_packet_rays];
    const auto& m = instance.to_object;
    for (std::size_t at = 0; at < k_packet_rays; at += k_lanes)
        for (std::size_t row = 0; row < 3; ++row) {
            V o = hn::Set(d, m[9 + row]), along = hn::Zero(d);
            for (std::size_t column = 0; column < 3; ++column) {
                const V factor = hn::Set(d, m[3 * column + row]);
                o = hn::Add(o, hn::Mul(factor, hn::Load(d, trace.packet.origin[column] + at)));
                along = hn::Add(along, hn::Mul(factor, hn::Load(d, trace.packet.direction[column] + at)));
            }
            hn::Store(o, d, own.origin[row] + at);
            hn::Store(along, d, direction[row] + at);
        }
    prepare(own, direction, trace.packet.tnear, lanes);
    trace_tree(trace, own, lanes);
}

template <bool any>
HWY_INLINE void trace_scene(const SceneTree& scene, Trace<any>& trace, const Rays& rays, unsigned lanes)
{
    if constexpr (any) lanes &= trace.open;
    if (scene.instances().empty() || lanes == 0) return;
    if (scene.instances().size() == 1) return trace_instance(trace, rays, scene.instances().front(), lanes);
    const TreeNode* const nodes = scene.nodes();
    const auto leaf = [&](std::uint32_t at, unsigned which)
                          HWY_ATTR { trace_instance(trace, rays, scene.instances()[TreeNode::first_of(at)], which); };
    // Instances are few: rays stay together as far as their boxes.
    const auto go_on = [&](auto& self, std::uint32_t at, unsigned which) HWY_ATTR -> void {
        if (TreeNode::is_leaf(at)) return leaf(at, which);
        for (unsigned i = 0; i < nodes[at].count; ++i) {
            alignas(64) float near[k_packet_rays];
            const unsigned bits = enter<false>(nodes[at], i, rays, trace.packet.tnear, trace.limit, near) & which;
            if (bits != 0) self(self, nodes[at].child[i], bits);
        }
    };
    const auto few = [&](std::uint32_t at, unsigned which) HWY_ATTR { go_on(go_on, at, which); };
    if (rays.same_signs)
        trace_packet<any, true>(trace, rays, nodes, lanes, leaf, few);
    else
        trace_packet<any, false>(trace, rays, nodes, lanes, leaf, few);
}

template <bool any>
HWY_INLINE void trace_scenes(std::span<const SceneTree* const> scenes, Trace<any>& trace, unsigned lanes)
{
    if (lanes == 0) return;
    Rays rays;
    const Wide d;
    for (int a = 0; a < 3; ++a)
        for (std::size_t at = 0; at < k_packet_rays; at += k_lanes)
            hn::Store(hn::Load(d, trace.packet.origin[a] + at), d, rays.origin[a] + at);
    prepare(rays, trace.packet.direction, trace.packet.tnear, lanes);
    for (const SceneTree* const scene : scenes) trace_scene(*scene, trace, rays, lanes);
}

void find_closest_of(std::span<const SceneTree* const> scenes, const RayQuery& query, RayPacket& packet)
{
    unsigned lanes = 0;
    for (std::size_t i = 0; i < k_packet_rays; ++i) lanes |= static_cast<unsigned>(packet.t[i] >= 0) << i;
    Trace<false> trace(query, packet, lanes);
    trace_scenes(scenes, trace, lanes);
}

unsigned find_occluded_of(std::span<const SceneTree* const> scenes, const RayQuery& query, RayPacket& packet,
                          unsigned lanes)
{
    Trace<true> trace(query, packet, lanes);
    trace_scenes(scenes, trace, lanes);
    return lanes & ~trace.open;
}

}   // namespace gnomon::ray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::ray {

HWY_EXPORT(find_closest_of);
HWY_EXPORT(find_occluded_of);

void find_closest(std::span<const SceneTree* const> scenes, const RayQuery& query, RayPacket& packet)
{
    HWY_DYNAMIC_DISPATCH(find_closest_of)(scenes, query, packet);
}

unsigned find_occluded(std::span<const SceneTree* const> scenes, const RayQuery& query, RayPacket& packet,
                       unsigned lanes)
{
    return HWY_DYNAMIC_DISPATCH(find_occluded_of)(scenes, query, packet, lanes);
}

}   // namespace gnomon::ray
#endif
