// SPDX-License-Identifier: Apache-2.0
// This file is compiled once for each instruction set: Highway includes it again and again.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "irradiance_cache/light_tree/point_kernels.cpp"
#include <hwy/foreach_target.h>   // first of all

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "irradiance_cache/light_tree/point_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::irradiance_cache::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float k_tiny = 1e-30f;
constexpr float k_least_reach = 1e-6f;   // of cosines around their mean, so that it is no zero divisor
constexpr float k_second_order = 0.5f;   // largest A / (pi d^2) for which a kernel's second order helps
constexpr float k_mixed = 0.1f;          // spread of normals above which one place cannot represent a node
constexpr float k_horizon = 0.1f;        // cosine at the point below which it cannot, either

// Quads that are evaluated together, in any vector width.
constexpr std::size_t k_group = 4;

// The nodes of a group of quads, as a point sees them.
struct Group {
    alignas(64) float light[4 * k_group];    // irradiance, visibility ignored
    alignas(64) float most[4 * k_group];     // approximate upper bound for any place inside the node
    alignas(64) float width[4 * k_group];    // radius over distance
    alignas(64) float spread[4 * k_group];   // of the normals: 0 if all agree
    unsigned there;                          // lanes with flux that are not entirely below the horizon
};

#if HWY_HAVE_SCALABLE
constexpr std::size_t k_lanes = 4;
#else
constexpr std::size_t k_lanes = std::min<std::size_t>(4 * k_group, HWY_MAX_BYTES / sizeof(float));
#endif
using Wide = hn::FixedTag<float, k_lanes>;

// Loads one member of consecutive quads into a vector.
using Member = const float (VirtualLightQuad::*)[4];
HWY_INLINE hn::Vec<hn::FixedTag<float, 4>> load(const VirtualLightQuad* const* quads, std::size_t i, Member member)
{
    return hn::LoadU(hn::FixedTag<float, 4>(), quads[i]->*member);
}
template <class D>
HWY_INLINE hn::Vec<D> side_by_side(D d, const VirtualLightQuad* const* quads, Member member)
{
    if constexpr (hn::MaxLanes(d) == 16) {
        const hn::Half<D> half;
        return hn::Combine(d, hn::Combine(half, load(quads, 3, member), load(quads, 2, member)),
                           hn::Combine(half, load(quads, 1, member), load(quads, 0, member)));
    } else if constexpr (hn::MaxLanes(d) == 8) {
        return hn::Combine(d, load(quads, 1, member), load(quads, 0, member));
    } else {
        return load(quads, 0, member);
    }
}

// The mean of max(x, 0) for x uniform within `reach` of its mean.
template <class D>
HWY_INLINE hn::Vec<D> rectified(D d, hn::Vec<D> mean, hn::Vec<D> reach)
{
    reach = hn::Max(reach, hn::Set(d, k_least_reach));
    const auto within = hn::Max(hn::Add(hn::Min(mean, reach), reach), hn::Zero(d));
    return hn::Add(hn::Div(hn::Mul(within, within), hn::Mul(hn::Set(d, 4.0f), reach)),
                   hn::Max(hn::Sub(mean, reach), hn::Zero(d)));
}

// @param count  of quads, 1 to k_group
HWY_INLINE void evaluate(const LightTree& tree, const NodeId* ids, std::size_t count, const glm::vec3& origin,
                         const glm::vec3& normal, Group& group)
{
    const Wide d;
    const VirtualLightQuad* quads[k_group];
    for (std::size_t i = 0; i < k_group; ++i) quads[i] = &tree.quad(ids[std::min(i, count - 1)]);
    const auto inverse_pi = hn::Set(d, static_cast<float>(1 / k_pi)), tiny = hn::Set(d, k_tiny);
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    group.there = 0;
    for (std::size_t first = 0; first < 4 * count; first += k_lanes) {
        const VirtualLightQuad* const* const q = quads + first / 4;
        const auto x = hn::Sub(side_by_side(d, q, &VirtualLightQuad::x), hn::Set(d, origin.x));
        const auto y = hn::Sub(side_by_side(d, q, &VirtualLightQuad::y), hn::Set(d, origin.y));
        const auto z = hn::Sub(side_by_side(d, q, &VirtualLightQuad::z), hn::Set(d, origin.z));
        const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
        const auto inverse = hn::Div(one, hn::Sqrt(hn::Max(square, tiny)));
        const auto area = hn::Mul(side_by_side(d, q, &VirtualLightQuad::area), inverse_pi);
        const auto flux = side_by_side(d, q, &VirtualLightQuad::flux);
        const auto nx = side_by_side(d, q, &VirtualLightQuad::nx), ny = side_by_side(d, q, &VirtualLightQuad::ny),
                   nz = side_by_side(d, q, &VirtualLightQuad::nz);
        const auto mx = hn::Set(d, normal.x), my = hn::Set(d, normal.y), mz = hn::Set(d, normal.z);
        const auto width = hn::Mul(side_by_side(d, q, &VirtualLightQuad::radius), inverse);
        const auto receiver = hn::Mul(hn::Add(hn::Add(hn::Mul(x, mx), hn::Mul(y, my)), hn::Mul(z, mz)), inverse);
        const auto source = hn::Neg(hn::Mul(hn::Add(hn::Add(hn::Mul(x, nx), hn::Mul(y, ny)), hn::Mul(z, nz)), inverse));
        const auto disk = hn::Mul(hn::Div(inverse_pi, hn::Add(hn::Add(square, area), tiny)), flux);
        const auto spread =
            hn::Max(hn::Sub(one, hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(nz, nz))), zero);
        hn::Store(spread, d, group.spread + first);
        const auto reach = hn::Sqrt(spread), room = hn::Add(width, reach);
        const auto r = hn::Max(receiver, zero), e = rectified(d, source, reach);
        hn::Store(
            hn::Mul(hn::Mul(hn::Min(hn::Add(r, width), one), hn::Min(hn::Max(hn::Add(source, room), zero), one)), disk),
            d, group.most + first);
        // Compute the kernel's mean over a disk to second order, as far as that holds (point_kernels.h).
        const auto solid = hn::Div(area, hn::Max(square, tiny));
        const auto near = hn::Min(solid, hn::Set(d, k_second_order)), beyond = hn::Sub(solid, near);
        const auto mutual = hn::Add(hn::Add(hn::Mul(nx, mx), hn::Mul(ny, my)), hn::Mul(nz, mz));
        const auto change = hn::Mul(
            near,
            hn::Sub(hn::Mul(receiver, hn::Sub(one, hn::Mul(hn::Set(d, 3.0f), hn::Mul(e, e)))), hn::Mul(mutual, e)));
        const auto more = hn::Max(hn::Add(receiver, change), zero);
        const auto less = hn::Div(hn::Mul(r, r), hn::Max(hn::Sub(r, change), tiny));
        const auto cosine = hn::IfThenElse(hn::Gt(change, zero), more, less);
        const auto kernel = hn::Mul(hn::Div(inverse_pi, hn::Max(hn::Mul(square, hn::Add(one, beyond)), tiny)), flux);
        hn::Store(hn::Mul(hn::Mul(cosine, e), kernel), d, group.light + first);
        hn::Store(width, d, group.width + first);
        const auto there = hn::And(hn::Gt(flux, zero), hn::Gt(hn::Add(receiver, width), zero));
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(d, there, bits);
        constexpr unsigned k_all = (1u << k_lanes) - 1;
        group.there |= ((bits[0] | static_cast<unsigned>(bits[1]) << 8) & k_all) << first;
    }
    group.there &= (1u << (4 * count)) - 1;   // the last vector is padded with the last quad
}

HWY_INLINE float of_quad(const Group& group, std::size_t i)
{
    const float* light = group.light + 4 * i;
    return (light[0] + light[1]) + (light[2] + light[3]);
}

// Takes a group of quads off the stack.
HWY_INLINE std::size_t pop(std::vector<NodeId>& stack, NodeId (&quads)[k_group])
{
    const std::size_t count = std::min(k_group, stack.size());
    std::copy(stack.end() - static_cast<std::ptrdiff_t>(count), stack.end(), quads);
    stack.resize(stack.size() - count);
    return count;
}

// Estimates the light of all nodes, visibility ignored, from a cut whose nodes have error bounds of at most `wrong`.
// With 0, the cut is the roots, and the estimate is above 0 wherever any light might arrive.
float estimate(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
               float wrong, std::vector<NodeId>& stack, std::vector<NodeId>& kept)
{
    constexpr float k_likely = 0.05f;   // fraction of its upper bound that a wide node is assumed to bring
    float total = 0, most = 0;
    Group group;
    NodeId quads[k_group];
    kept.clear();
    stack = tree.roots();
    while (!stack.empty()) {
        const std::size_t count = pop(stack, quads);
        evaluate(tree, quads, count, origin, normal, group);
        for (unsigned lanes = group.there; lanes != 0; lanes &= lanes - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(lanes));
            const NodeId below = tree.children(4 * quads[i / 4] + i % 4);
            const float width = std::max(group.width[i], group.spread[i]);
            if (wrong > 0 && below != scene::none && group.most[i] * (width > options.nearest ? 1.0f : width) > wrong) {
                stack.push_back(below);
                continue;
            }
            most += group.most[i];
            if (below == scene::none)
                total += group.light[i];
            else
                kept.push_back(below);
        }
    }
    // The light of a kept node is that of its children.
    for (std::size_t k = 0; k < kept.size(); k += k_group) {
        const std::size_t count = std::min(k_group, kept.size() - k);
        evaluate(tree, kept.data() + k, count, origin, normal, group);
        for (std::size_t i = 0; i < count; ++i) total += of_quad(group, i);
    }
    return wrong > 0 ? total : std::max(total, k_likely * most);
}

void cut_tree_of(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
                 std::vector<NodeId>& nodes, std::vector<float>& weights, std::vector<NodeId>& stack)
{
    // Estimate the light of all nodes by coarse cuts, each of which gives the error threshold of the next.
    float total = estimate(tree, options, origin, normal, 0, stack, nodes);
    for (const float fraction : {0.3f, options.estimate}) {
        if (!(total > 0)) break;
        total = estimate(tree, options, origin, normal, fraction * total, stack, nodes);
    }
    Group group, parts;
    NodeId quads[k_group];
    struct Kept {
        NodeId id, below;
        bool mixed;   // one place cannot represent the whole node
    } waiting[k_group];
    std::size_t waits = 0;
    // Refine each node whose error bound exceeds the threshold [Walter et al. 2005, Section 4].
    const float wrong = options.error * total, negligible = options.negligible * total;
    float kept = 0;
    nodes.clear();
    weights.clear();
    const auto keep = [&](NodeId node, float flux, float light) {
        if (!(light > negligible)) return;
        nodes.push_back(node);
        weights.push_back(light / flux);
        kept += light;
    };
    const auto keep_waiting = [&]() HWY_ATTR {
        if (waits == 0) return;
        NodeId below[k_group];
        for (std::size_t i = 0; i < waits; ++i) below[i] = waiting[i].below;
        evaluate(tree, below, waits, origin, normal, parts);
        for (std::size_t i = 0; i < waits; ++i) {
            const Kept& node = waiting[i];
            if (!node.mixed) {
                keep(node.id, tree.quad(node.id / 4).flux[node.id % 4], of_quad(parts, i));
                continue;
            }
            for (std::size_t part = 0; part < 4; ++part)
                if ((parts.there >> (4 * i + part)) & 1)
                    keep(static_cast<NodeId>(4 * node.below + part), tree.quad(node.below).flux[part],
                         parts.light[4 * i + part]);
        }
        waits = 0;
    };
    stack = tree.roots();
    while (!stack.empty()) {
        const std::size_t count = pop(stack, quads);
        evaluate(tree, quads, count, origin, normal, group);
        for (unsigned lanes = group.there; lanes != 0; lanes &= lanes - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(lanes));
            const NodeId id = 4 * quads[i / 4] + i % 4, below = tree.children(id);
            if (below == scene::none) {
                keep(id, tree.quad(id / 4).flux[id % 4], group.light[i]);
                continue;
            }
            const float width = std::max(group.width[i], group.spread[i]);
            if (group.most[i] * (width > options.nearest ? 1.0f : width) > wrong) {
                stack.push_back(below);
                continue;
            }
            // One place must represent the whole node: on a side that can be visible, above the horizon. Otherwise the
            // whole node could be lost, so each of its children gets a visibility ray of its own.
            const glm::vec3 to = tree.samples().at(id) - origin;
            const bool mixed = group.spread[i] > k_mixed || glm::dot(to, normal) < k_horizon * glm::length(to);
            waiting[waits++] = {id, below, mixed};
            if (waits == k_group) keep_waiting();
        }
    }
    keep_waiting();
    // Coarse nodes are too dark because the kernel is convex. Scale all weights to make up for it.
    constexpr float k_most_lack = 1.25f;
    const float lack = kept > 0 ? std::clamp(total / kept, 1.0f, k_most_lack) : 1.0f;
    for (float& weight : weights) weight *= lack;
}

// The samples, four floats per node; null if there are none.
HWY_INLINE const float* places_of(const LightTree& tree)
{
    const std::vector<glm::vec4>& places = tree.samples().places;
    return places.empty() ? nullptr : &places.front().x;
}

// A weight is stored as the leading bits of a float between 2^-64 and 2^64.
constexpr std::uint32_t k_weight_shift = 30 - k_weight_bits, k_weight_bias = (127u - 64) << 23;

// The sum of as many numbers as a list is padded to, in an order that does not depend on the width of vectors.
float total_of(const float* values)
{
    float sums[k_seen_step];
    std::copy(values, values + k_seen_step, sums);
    for (std::uint32_t half = k_seen_step / 2; half > 0; half /= 2)
        for (std::uint32_t i = 0; i < half; ++i) sums[i] += sums[i + half];
    return sums[0];
}

// Every k_seen_step-th node is added to the same sum, in any vector width.
// @param before  the flux of node n is at n - before; that of nodes below it at 0
void sum_seen_of(const LightTree& tree, const LightTree::Flux& flux, NodeId before, const SeenNode* seen,
                 std::uint32_t count, const glm::vec3& origin, glm::vec3 (&light)[3])
{
    const hn::CappedTag<float, k_seen_step> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::RebindToUnsigned<decltype(d)> du;
    const auto ox = hn::Set(d, origin.x), oy = hn::Set(d, origin.y), oz = hn::Set(d, origin.z);
    const auto zero = hn::Zero(d), tiny = hn::Set(d, k_tiny);
    const float* const places = places_of(tree);
    const auto shift = hn::Set(di, static_cast<std::int32_t>(before));
    alignas(64) float sums[9][k_seen_step];
    const std::uint32_t padded = (count + k_seen_step - 1) / k_seen_step * k_seen_step;
    for (std::uint32_t lane = 0; lane < k_seen_step; lane += static_cast<std::uint32_t>(hn::Lanes(d))) {
        auto rx = zero, ry = zero, rz = zero, gx = zero, gy = zero, gz = zero, bx = zero, by = zero, bz = zero;
        for (std::uint32_t k = lane; k < padded; k += k_seen_step) {
            const auto packed = hn::LoadU(du, seen + k);
            const auto id = hn::BitCast(di, hn::ShiftRight<k_weight_bits>(packed));
            const auto code = hn::And(packed, hn::Set(du, (1u << k_weight_bits) - 1));
            auto weight = hn::BitCast(d, hn::Add(hn::ShiftLeft<k_weight_shift>(code), hn::Set(du, k_weight_bias)));
            weight = hn::IfThenZeroElse(hn::RebindMask(d, hn::Eq(packed, hn::Zero(du))), weight);
            const auto at = hn::ShiftLeft<2>(id);
            const auto x = hn::Sub(hn::GatherIndex(d, places, at), ox);
            const auto y = hn::Sub(hn::GatherIndex(d, places + 1, at), oy);
            const auto z = hn::Sub(hn::GatherIndex(d, places + 2, at), oz);
            const auto square = hn::Max(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)), tiny);
            weight = hn::Div(weight, hn::Sqrt(square));
            const auto own = hn::Max(hn::Sub(id, shift), hn::Zero(di));
            const auto r = hn::Mul(hn::GatherIndex(d, flux.r.data(), own), weight);
            const auto g = hn::Mul(hn::GatherIndex(d, flux.g.data(), own), weight);
            const auto b = hn::Mul(hn::GatherIndex(d, flux.b.data(), own), weight);
            rx = hn::Add(rx, hn::Mul(r, x)), ry = hn::Add(ry, hn::Mul(r, y)), rz = hn::Add(rz, hn::Mul(r, z));
            gx = hn::Add(gx, hn::Mul(g, x)), gy = hn::Add(gy, hn::Mul(g, y)), gz = hn::Add(gz, hn::Mul(g, z));
            bx = hn::Add(bx, hn::Mul(b, x)), by = hn::Add(by, hn::Mul(b, y)), bz = hn::Add(bz, hn::Mul(b, z));
        }
        hn::Store(rx, d, sums[0] + lane), hn::Store(ry, d, sums[1] + lane), hn::Store(rz, d, sums[2] + lane);
        hn::Store(gx, d, sums[3] + lane), hn::Store(gy, d, sums[4] + lane), hn::Store(gz, d, sums[5] + lane);
        hn::Store(bx, d, sums[6] + lane), hn::Store(by, d, sums[7] + lane), hn::Store(bz, d, sums[8] + lane);
    }
    for (int i = 0; i < 3; ++i)
        light[i] = {total_of(sums[3 * i]), total_of(sums[3 * i + 1]), total_of(sums[3 * i + 2])};
}

void find_changed_of(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
                     const MovingSpheres& dynamic_bounds, std::vector<ChangedNode>& changed)
{
    const hn::CappedTag<float, k_seen_step> d;
    const hn::RebindToSigned<decltype(d)> di;
    const hn::RebindToUnsigned<decltype(d)> du;
    const auto ox = hn::Set(d, origin.x), oy = hn::Set(d, origin.y), oz = hn::Set(d, origin.z);
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f), tiny = hn::Set(d, k_tiny);
    const float* const places = places_of(tree);
    const bool differs = tree.any_differs();
    for (std::uint32_t k = 0; k < count; k += static_cast<std::uint32_t>(hn::Lanes(d))) {
        const auto node = hn::ShiftRight<k_weight_bits>(hn::LoadU(du, seen + k));
        const auto at = hn::BitCast(di, hn::ShiftLeft<2>(node));
        auto found = hn::Lt(one, zero), crossed = found;
        if (differs) found = hn::Gt(hn::GatherIndex(d, places + 3, at), zero);
        if (!dynamic_bounds.empty()) {
            const auto x = hn::Sub(hn::GatherIndex(d, places, at), ox);
            const auto y = hn::Sub(hn::GatherIndex(d, places + 1, at), oy);
            const auto z = hn::Sub(hn::GatherIndex(d, places + 2, at), oz);
            const auto square = hn::Max(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)), tiny);
            const auto inverse = hn::Div(one, square);
            const auto meets = [&](const Sphere& sphere) HWY_ATTR {
                const glm::vec3 centre = sphere.centre - origin;
                const auto ax = hn::Set(d, centre.x), ay = hn::Set(d, centre.y), az = hn::Set(d, centre.z);
                const auto along = hn::Min(
                    hn::Max(hn::Mul(hn::Add(hn::Add(hn::Mul(ax, x), hn::Mul(ay, y)), hn::Mul(az, z)), inverse), zero),
                    one);
                const auto dx = hn::Sub(ax, hn::Mul(along, x)), dy = hn::Sub(ay, hn::Mul(along, y)),
                           dz = hn::Sub(az, hn::Mul(along, z));
                const auto off = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
                return hn::Le(off, hn::Set(d, sphere.radius * sphere.radius));
            };
            const std::vector<MovingSpheres::Node>& nodes = dynamic_bounds.nodes();
            for (std::uint32_t m = 0; m < nodes.size();) {
                const auto near = meets(nodes[m].sphere);
                if (nodes[m].single) crossed = hn::Or(crossed, near);
                m = hn::AllFalse(d, near) ? nodes[m].next : m + 1;
            }
            found = hn::Or(found, crossed);
        }
        if (hn::AllFalse(d, found)) continue;
        const auto bits_of = [&](auto mask) HWY_ATTR {
            std::uint8_t bytes[8] = {};
            hn::StoreMaskBits(d, mask, bytes);
            return static_cast<std::uint32_t>(bytes[0]) | (static_cast<std::uint32_t>(bytes[1]) << 8);
        };
        const std::uint32_t crossing = bits_of(crossed);
        for (std::uint32_t left = bits_of(found); left != 0; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(__builtin_ctz(left));
            if (k + lane < count) changed.push_back({k + lane, ((crossing >> lane) & 1) != 0});
        }
    }
}

}   // namespace gnomon::irradiance_cache::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon::irradiance_cache {

HWY_EXPORT(cut_tree_of);
HWY_EXPORT(sum_seen_of);
HWY_EXPORT(find_changed_of);

void cut_tree(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
              std::vector<NodeId>& nodes, std::vector<float>& weights, std::vector<NodeId>& stack)
{
    HWY_DYNAMIC_DISPATCH(cut_tree_of)(tree, options, origin, normal, nodes, weights, stack);
}

SeenNode pack_seen(NodeId node, float weight)
{
    using HWY_NAMESPACE::k_weight_bias;
    using HWY_NAMESPACE::k_weight_shift;
    constexpr std::uint32_t k_most = (1u << k_weight_bits) - 1;
    const std::uint32_t rounded = std::bit_cast<std::uint32_t>(weight) + (1u << (k_weight_shift - 1));
    const std::uint32_t code =
        rounded < k_weight_bias ? 0 : std::min((rounded - k_weight_bias) >> k_weight_shift, k_most);
    return (node << k_weight_bits) | std::max(code, 1u);
}

float seen_weight(SeenNode seen)
{
    using HWY_NAMESPACE::k_weight_bias;
    using HWY_NAMESPACE::k_weight_shift;
    return std::bit_cast<float>(((seen & ((1u << k_weight_bits) - 1)) << k_weight_shift) + k_weight_bias);
}

void sum_seen(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
              glm::vec3 (&light)[3])
{
    HWY_DYNAMIC_DISPATCH(sum_seen_of)(tree, tree.static_flux(), 0, seen, count, origin, light);
}

void sum_seen_difference(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
                         glm::vec3 (&light)[3])
{
    const NodeId before = tree.first_patch() - 1;   // may wrap: to -1
    HWY_DYNAMIC_DISPATCH(sum_seen_of)(tree, tree.patch_difference(), before, seen, count, origin, light);
}

void find_changed(const LightTree& tree, const SeenNode* seen, std::uint32_t count, const glm::vec3& origin,
                  const MovingSpheres& dynamic_bounds, std::vector<ChangedNode>& changed)
{
    HWY_DYNAMIC_DISPATCH(find_changed_of)(tree, seen, count, origin, dynamic_bounds, changed);
}

}   // namespace gnomon::irradiance_cache
#endif
