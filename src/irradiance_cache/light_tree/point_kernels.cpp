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

// Quads that are evaluated together, in any vector width. Sums have one partial sum for each of their nodes.
constexpr std::size_t k_group = 4;
constexpr std::size_t k_nodes = 4 * k_group;

#if HWY_HAVE_SCALABLE
constexpr std::size_t k_lanes = 4;
#else
constexpr std::size_t k_lanes = std::min<std::size_t>(k_nodes, HWY_MAX_BYTES / sizeof(float));
#endif
constexpr std::size_t k_vectors = k_nodes / k_lanes;   // of a group
using Wide = hn::FixedTag<float, k_lanes>;
using WideId = hn::RebindToUnsigned<Wide>;
using V = hn::Vec<Wide>;
using Ids = hn::Vec<WideId>;

// Puts vectors of four lanes, one for each quad, side by side. Four: a vector by number of the quad.
template <class D, class Four>
HWY_INLINE hn::Vec<D> side_by_side(D d, const Four& four)
{
    if constexpr (hn::MaxLanes(d) == 16) {
        const hn::Half<D> half;
        return hn::Combine(d, hn::Combine(half, four(3), four(2)), hn::Combine(half, four(1), four(0)));
    } else if constexpr (hn::MaxLanes(d) == 8) {
        return hn::Combine(d, four(1), four(0));
    } else {
        return four(0);
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

// The sum of as many numbers as a list is padded to, in an order that does not depend on the width of vectors.
float total_of(const float* values)
{
    float sums[k_seen_step];
    std::copy(values, values + k_seen_step, sums);
    for (std::uint32_t half = k_seen_step / 2; half > 0; half /= 2)
        for (std::uint32_t i = 0; i < half; ++i) sums[i] += sums[i + half];
    return sums[0];
}

// What a cut is for.
struct Receiver {
    const LightTree& tree;
    const CutOptions& options;
    glm::vec3 origin, normal;
};

// Nodes of quads, as a receiver sees them.
struct Seen {
    V light;    // irradiance, visibility ignored
    V most;     // approximate upper bound for any place inside the node
    V bound;    // of the error, if the node is not refined
    V spread;   // of the normals: 0 if all agree
    V flux;
    hn::Mask<Wide> there;   // with flux, and not entirely below the horizon
    hn::Mask<Wide> real;    // nodes of these quads; others fill a vector
};

// Evaluates quads. Take: void(std::size_t first, const Seen&), with the number of the first node in the group.
// @param count  of quads, 1 to k_group
template <class Take>
HWY_INLINE void evaluate(const Receiver& point, const NodeId* ids, std::size_t count, Take&& take)
{
    const Wide d;
    const glm::vec3 &origin = point.origin, &normal = point.normal;
    const VirtualLightQuad* quads[k_group];
    for (std::size_t i = 0; i < k_group; ++i) quads[i] = &point.tree.quad(ids[std::min(i, count - 1)]);
    const auto inverse_pi = hn::Set(d, static_cast<float>(1 / k_pi)), tiny = hn::Set(d, k_tiny);
    const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    for (std::size_t first = 0; first < 4 * count; first += k_lanes) {
        const auto load = [&](const float(VirtualLightQuad::*member)[4]) HWY_ATTR {
            return side_by_side(d, [&](std::size_t i) HWY_ATTR {
                return hn::LoadU(hn::FixedTag<float, 4>(), quads[first / 4 + i]->*member);
            });
        };
        const auto x = hn::Sub(load(&VirtualLightQuad::x), hn::Set(d, origin.x));
        const auto y = hn::Sub(load(&VirtualLightQuad::y), hn::Set(d, origin.y));
        const auto z = hn::Sub(load(&VirtualLightQuad::z), hn::Set(d, origin.z));
        const auto square = hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z));
        const auto inverse = hn::Div(one, hn::Sqrt(hn::Max(square, tiny)));
        const auto area = hn::Mul(load(&VirtualLightQuad::area), inverse_pi);
        const auto flux = load(&VirtualLightQuad::flux);
        const auto nx = load(&VirtualLightQuad::nx), ny = load(&VirtualLightQuad::ny), nz = load(&VirtualLightQuad::nz);
        const auto mx = hn::Set(d, normal.x), my = hn::Set(d, normal.y), mz = hn::Set(d, normal.z);
        const auto width = hn::Mul(load(&VirtualLightQuad::radius), inverse);
        const auto receiver = hn::Mul(hn::Add(hn::Add(hn::Mul(x, mx), hn::Mul(y, my)), hn::Mul(z, mz)), inverse);
        const auto source = hn::Neg(hn::Mul(hn::Add(hn::Add(hn::Mul(x, nx), hn::Mul(y, ny)), hn::Mul(z, nz)), inverse));
        const auto disk = hn::Mul(hn::Div(inverse_pi, hn::Add(hn::Add(square, area), tiny)), flux);
        const auto spread =
            hn::Max(hn::Sub(one, hn::Add(hn::Add(hn::Mul(nx, nx), hn::Mul(ny, ny)), hn::Mul(nz, nz))), zero);
        const auto reach = hn::Sqrt(spread), room = hn::Add(width, reach);
        const auto r = hn::Max(receiver, zero), e = rectified(d, source, reach);
        Seen seen;
        seen.most =
            hn::Mul(hn::Mul(hn::Min(hn::Add(r, width), one), hn::Min(hn::Max(hn::Add(source, room), zero), one)), disk);
        const auto wide = hn::Max(width, spread);
        seen.bound = hn::Mul(seen.most, hn::IfThenElse(hn::Gt(wide, hn::Set(d, point.options.nearest)), one, wide));
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
        seen.light = hn::Mul(hn::Mul(cosine, e), kernel);
        seen.spread = spread, seen.flux = flux;
        seen.real = hn::FirstN(d, std::min(4 * count - first, k_lanes));
        seen.there = hn::And(hn::And(hn::Gt(flux, zero), hn::Gt(hn::Add(receiver, width), zero)), seen.real);
        take(first, seen);
    }
}

// A list to which some lanes of a vector are added.
template <class T>
class Lanes {
 public:
    explicit Lanes(std::vector<T>& values) : values_(values) {}
    Lanes(const Lanes&) = delete;
    Lanes& operator=(const Lanes&) = delete;
    ~Lanes() { values_.resize(size_); }

    std::size_t size() const { return size_; }
    const T* from(std::size_t first) const { return values_.data() + first; }
    template <class D>
    HWY_INLINE void add(D d, hn::Vec<D> v, hn::Mask<hn::Rebind<float, D>> lanes)
    {
        if (values_.size() < size_ + k_lanes) values_.resize(2 * size_ + 16 * k_lanes);
        size_ += hn::CompressStore(v, hn::RebindMask(d, lanes), d, values_.data() + size_);
    }
    void assign(const std::vector<T>& values)
    {
        values_ = values;
        size_ = values.size();
    }
    // Takes the last values, up to k_group of them, off the list. @return their number
    std::size_t pop(T (&values)[k_group])
    {
        const std::size_t count = std::min(k_group, size_);
        size_ -= count;
        std::copy_n(values_.data() + size_, count, values);
        return count;
    }

 private:
    std::vector<T>& values_;
    std::size_t size_ = 0;
};

// A sum of one partial sum for each node of a group.
class Sum {
 public:
    HWY_INLINE Sum()
    {
        for (V& part : parts_) part = hn::Zero(Wide());
    }
    HWY_INLINE void add(std::size_t first, V v, hn::Mask<Wide> lanes)
    {
        V& part = parts_[first / k_lanes];
        part = hn::Add(part, hn::IfThenElseZero(lanes, v));
    }
    HWY_INLINE float total() const
    {
        alignas(64) float sums[k_nodes];
        for (std::size_t i = 0; i < k_vectors; ++i) hn::Store(parts_[i], Wide(), sums + i * k_lanes);
        return total_of(sums);
    }

 private:
    V parts_[k_vectors];
};

// The quads of the children of some quads' nodes: scene::none for leaves.
HWY_INLINE Ids children_of(const LightTree& tree, const NodeId* quads, std::size_t count, std::size_t first)
{
    return side_by_side(WideId(), [&](std::size_t i) HWY_ATTR {
        const std::size_t quad = std::min(first / 4 + i, count - 1);
        return hn::LoadU(hn::FixedTag<NodeId, 4>(), tree.children().data() + 4 * std::size_t{quads[quad]});
    });
}

// Estimates the light of all nodes, visibility ignored, from a cut whose nodes have error bounds of at most `wrong`.
// With 0, the cut is the roots, and the estimate is above 0 wherever any light might arrive.
float estimate(const Receiver& point, float wrong, CutScratch& scratch)
{
    constexpr float k_likely = 0.05f;   // fraction of its upper bound that a wide node is assumed to bring
    const Wide d;
    const WideId di;
    Sum light, most;
    Lanes stack(scratch.stack), kept(scratch.below);
    stack.assign(point.tree.roots());
    NodeId quads[k_group];
    const V limit = hn::Set(d, wrong > 0 ? wrong : k_infinity);
    while (const std::size_t count = stack.pop(quads)) {
        evaluate(point, quads, count, [&](std::size_t first, const Seen& seen) HWY_ATTR {
            const Ids children = children_of(point.tree, quads, count, first);
            const auto leaf = hn::RebindMask(d, hn::Eq(children, hn::Set(di, scene::none)));
            const auto inner = hn::AndNot(leaf, seen.there), refined = hn::And(inner, hn::Gt(seen.bound, limit));
            stack.add(di, children, refined);
            kept.add(di, children, hn::AndNot(refined, inner));
            light.add(first, seen.light, hn::And(leaf, seen.there));
            if (!(wrong > 0)) most.add(first, seen.most, seen.there);
        });
    }
    // The light of a kept node is that of its children.
    for (std::size_t k = 0; k < kept.size(); k += k_group)
        evaluate(point, kept.from(k), std::min(k_group, kept.size() - k),
                 [&](std::size_t first, const Seen& seen) HWY_ATTR { light.add(first, seen.light, seen.real); });
    const float total = light.total();
    return wrong > 0 ? total : std::max(total, k_likely * most.total());
}

// A cut in the making.
struct Cut {
    Lanes<NodeId> nodes;
    Lanes<float> weights;
    Sum light;          // of its nodes
    float negligible;   // light of a node that is left out

    HWY_INLINE void keep(std::size_t first, Ids ids, V lights, V flux, hn::Mask<Wide> lanes)
    {
        const Wide d;
        lanes = hn::And(lanes, hn::Gt(lights, hn::Set(d, negligible)));
        nodes.add(WideId(), ids, lanes);
        weights.add(d, hn::Div(lights, flux), lanes);
        light.add(first, lights, lanes);
    }
};

// The nodes of quads.
HWY_INLINE Ids nodes_of(const NodeId* quads, std::size_t count, std::size_t first)
{
    const hn::FixedTag<NodeId, 4> d4;
    return side_by_side(
        WideId(), [&](std::size_t i) HWY_ATTR { return hn::Iota(d4, 4 * quads[std::min(first / 4 + i, count - 1)]); });
}

// Adds the nodes that are not refined to a cut: each as itself, or as its children where one place cannot represent it.
void keep_nodes(const Receiver& point, const CutScratch& scratch, Cut& cut)
{
    const Wide d;
    const WideId di;
    const hn::FixedTag<NodeId, 4> i4;
    const hn::FixedTag<float, 4> d4;
    const auto first_of_quad = hn::Eq(hn::And(hn::Iota(di, 0), hn::Set(di, 3)), hn::Zero(di));
    for (std::size_t k = 0; k < scratch.below.size(); k += k_group) {
        const std::size_t count = std::min(k_group, scratch.below.size() - k);
        const NodeId* const below = scratch.below.data() + k;
        evaluate(point, below, count, [&](std::size_t first, const Seen& seen) HWY_ATTR {
            const auto of = [&](std::size_t i) { return k + std::min(first / 4 + i, count - 1); };
            const auto node =
                side_by_side(di, [&](std::size_t i) HWY_ATTR { return hn::Set(i4, scratch.node[of(i)]); });
            const auto flux = side_by_side(d, [&](std::size_t i) HWY_ATTR { return hn::Set(d4, scratch.flux[of(i)]); });
            const auto spread =
                side_by_side(d, [&](std::size_t i) HWY_ATTR { return hn::Set(d4, scratch.spread[of(i)]); });
            const auto place = [&](int axis) HWY_ATTR {
                return hn::Sub(side_by_side(d,
                                            [&](std::size_t i) HWY_ATTR {
                                                return hn::Set(d4, point.tree.samples().at(scratch.node[of(i)])[axis]);
                                            }),
                               hn::Set(d, point.origin[axis]));
            };
            // One place must represent the whole node: on a side that can be visible, above the horizon. Otherwise the
            // whole node could be lost, so each of its children gets a visibility ray of its own.
            const auto x = place(0), y = place(1), z = place(2);
            const auto along =
                hn::Add(hn::Add(hn::Mul(x, hn::Set(d, point.normal.x)), hn::Mul(y, hn::Set(d, point.normal.y))),
                        hn::Mul(z, hn::Set(d, point.normal.z)));
            const auto length = hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
            const auto mixed =
                hn::Or(hn::Gt(spread, hn::Set(d, k_mixed)), hn::Lt(along, hn::Mul(hn::Set(d, k_horizon), length)));
            const auto two = hn::Add(seen.light, hn::Shuffle2301(seen.light));
            const auto whole = hn::And(hn::AndNot(mixed, seen.real), hn::RebindMask(d, first_of_quad));
            cut.keep(first, hn::IfThenElse(hn::RebindMask(di, mixed), nodes_of(below, count, first), node),
                     hn::IfThenElse(mixed, seen.light, hn::Add(two, hn::Shuffle1032(two))),
                     hn::IfThenElse(mixed, seen.flux, flux), hn::Or(hn::And(mixed, seen.there), whole));
        });
    }
}

void cut_tree_of(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
                 std::vector<NodeId>& nodes, std::vector<float>& weights, CutScratch& scratch)
{
    const Wide d;
    const WideId di;
    const Receiver point{tree, options, origin, normal};
    // Estimate the light of all nodes by coarse cuts, each of which gives the error threshold of the next.
    float total = estimate(point, 0, scratch);
    for (const float fraction : {0.3f, options.estimate}) {
        if (!(total > 0)) break;
        total = estimate(point, fraction * total, scratch);
    }
    float kept = 0;
    {
        Cut cut{Lanes(nodes), Lanes(weights), {}, options.negligible * total};
        // Refine each node whose error bound exceeds the threshold [Walter et al. 2005, Section 4].
        const V wrong = hn::Set(d, options.error * total);
        {
            Lanes stack(scratch.stack), node(scratch.node), below(scratch.below);
            Lanes flux(scratch.flux), spread(scratch.spread);
            stack.assign(tree.roots());
            NodeId quads[k_group];
            while (const std::size_t count = stack.pop(quads)) {
                evaluate(point, quads, count, [&](std::size_t first, const Seen& seen) HWY_ATTR {
                    const Ids children = children_of(tree, quads, count, first), ids = nodes_of(quads, count, first);
                    const auto leaf = hn::RebindMask(d, hn::Eq(children, hn::Set(di, scene::none)));
                    const auto inner = hn::AndNot(leaf, seen.there),
                               refined = hn::And(inner, hn::Gt(seen.bound, wrong));
                    const auto whole = hn::AndNot(refined, inner);
                    stack.add(di, children, refined);
                    node.add(di, ids, whole), below.add(di, children, whole);
                    flux.add(d, seen.flux, whole), spread.add(d, seen.spread, whole);
                    cut.keep(first, ids, seen.light, seen.flux, hn::And(leaf, seen.there));
                });
            }
        }
        keep_nodes(point, scratch, cut);
        kept = cut.light.total();
    }
    // Coarse nodes are too dark because the kernel is convex. Scale all weights to make up for it.
    constexpr float k_most_lack = 1.25f;
    const float lack = kept > 0 ? std::clamp(total / kept, 1.0f, k_most_lack) : 1.0f;
    for (float& weight : weights) weight *= lack;
}

void find_uneven_of(const LightTree& tree, const glm::vec3& origin, const MarkedNodes& but, std::vector<NodeId>& found,
                    std::vector<NodeId>& stack)
{
    const hn::FixedTag<float, 4> d;
    const hn::RebindToUnsigned<decltype(d)> di;
    const std::span<const PatchLight::Reach> reaches = tree.patch_light()->uneven();
    const NodeId first = tree.first_patch() / 4;
    const auto ox = hn::Set(d, origin.x), oy = hn::Set(d, origin.y), oz = hn::Set(d, origin.z), zero = hn::Zero(d);
    const auto square_to = [&](const float(&x)[4], const float(&y)[4], const float(&z)[4]) HWY_ATTR {
        const auto dx = hn::Sub(hn::LoadU(d, x), ox), dy = hn::Sub(hn::LoadU(d, y), oy),
                   dz = hn::Sub(hn::LoadU(d, z), oz);
        return hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    };
    found.clear();
    stack.clear();
    for (const std::uint32_t root : tree.patch_light()->tree().roots) stack.push_back(first + root);
    while (!stack.empty()) {
        const NodeId number = stack.back();
        stack.pop_back();
        const VirtualLightQuad& quad = tree.quad(number);
        const PatchLight::Reach& reach = reaches[number - first];
        const auto radius = hn::LoadU(d, reach.radius);
        auto near =
            hn::And(hn::Gt(radius, zero), hn::Lt(square_to(reach.x, reach.y, reach.z), hn::Mul(radius, radius)));
        near = hn::And(near, hn::Gt(hn::LoadU(d, quad.flux), zero));
        if (hn::AllFalse(d, near)) continue;
        // Of leaves, take those that are near.
        const auto children = hn::LoadU(di, tree.children().data() + 4 * std::size_t{number});
        const auto leaf = hn::RebindMask(d, hn::Eq(children, hn::Set(di, scene::none)));
        const auto distance = hn::Sqrt(square_to(quad.x, quad.y, quad.z));
        const auto wide = hn::Gt(hn::Mul(hn::LoadU(d, quad.radius), hn::Set(d, PatchLight::k_uneven_reach)), distance);
        std::uint8_t bits[8] = {}, leaves[8] = {};
        hn::StoreMaskBits(d, hn::And(near, hn::Or(hn::Not(leaf), wide)), bits);
        hn::StoreMaskBits(d, leaf, leaves);
        for (unsigned lanes = bits[0] & 15u; lanes != 0; lanes &= lanes - 1) {
            const auto lane = static_cast<unsigned>(__builtin_ctz(lanes));
            const NodeId node = 4 * number + lane;
            if (but.has(node)) continue;
            if (((leaves[0] >> lane) & 1) != 0)
                found.push_back(node);
            else
                stack.push_back(tree.children(node));
        }
    }
}

// The samples, four floats per node; null if there are none.
HWY_INLINE const float* places_of(const LightTree& tree)
{
    const std::vector<glm::vec4>& places = tree.samples().places;
    return places.empty() ? nullptr : &places.front().x;
}

// A weight is stored as the leading bits of a float between 2^-64 and 2^64.
constexpr std::uint32_t k_weight_shift = 30 - k_weight_bits, k_weight_bias = (127u - 64) << 23;

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
            // As meets_way() of a box.
            const auto meets_box = [&](const MovingBox& box) HWY_ATTR {
                const glm::vec3 from = origin - box.centre;
                const float more = MovingBox::margin(from);
                auto begin = zero, end = one;
                for (int i = 0; i < 3; ++i) {
                    const glm::vec3 n = box.normal[i];
                    const float away = glm::dot(n, from), half = box.half[i] + more;
                    auto speed = hn::Add(hn::Add(hn::Mul(hn::Set(d, n.x), x), hn::Mul(hn::Set(d, n.y), y)),
                                         hn::Mul(hn::Set(d, n.z), z));
                    const auto slowest = hn::Set(d, MovingBox::k_slowest);
                    speed = hn::IfThenElse(hn::Lt(hn::Abs(speed), slowest), slowest, speed);
                    const auto a = hn::Div(hn::Set(d, -half - away), speed),
                               b = hn::Div(hn::Set(d, half - away), speed);
                    begin = hn::Max(begin, hn::Min(a, b)), end = hn::Min(end, hn::Max(a, b));
                }
                return hn::Le(begin, end);
            };
            const std::vector<MovingSpheres::Node>& nodes = dynamic_bounds.nodes();
            for (std::uint32_t m = 0; m < nodes.size();) {
                const auto near = meets(nodes[m].sphere);
                const bool none = hn::AllFalse(d, near);
                if (nodes[m].single && !none)
                    crossed = hn::Or(crossed, hn::And(near, meets_box(dynamic_bounds.boxes()[m])));
                m = none ? nodes[m].next : m + 1;
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
HWY_EXPORT(find_uneven_of);
HWY_EXPORT(sum_seen_of);
HWY_EXPORT(find_changed_of);

void cut_tree(const LightTree& tree, const CutOptions& options, const glm::vec3& origin, const glm::vec3& normal,
              std::vector<NodeId>& nodes, std::vector<float>& weights, CutScratch& scratch)
{
    HWY_DYNAMIC_DISPATCH(cut_tree_of)(tree, options, origin, normal, nodes, weights, scratch);
}

void find_uneven(const LightTree& tree, const glm::vec3& origin, const MarkedNodes& but, std::vector<NodeId>& found,
                 std::vector<NodeId>& stack)
{
    HWY_DYNAMIC_DISPATCH(find_uneven_of)(tree, origin, but, found, stack);
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
