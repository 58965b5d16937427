// SPDX-License-Identifier: Apache-2.0
#include "environment_light/cell_visibility.h"

#include <algorithm>
#include <bit>

namespace gnomon::environment_light {

namespace {

using visibility::ShadowPoint;
using visibility::TriangleId;

constexpr std::size_t k_rays_at_once = 1 << 14;
constexpr std::size_t k_block = 16;   // points whose rays in one direction are neighbours
// Of a ray's direction above the surface, least sine: below, the mean direction of the cell stands in.
constexpr float k_least_sine = 1e-3f;

template <class Body>
void for_each_bit(std::span<const std::uint64_t> mask, const Body& body)
{
    for (std::size_t w = 0; w < mask.size(); ++w)
        for (std::uint64_t word = mask[w]; word != 0; word &= word - 1)
            body(64 * w + static_cast<std::size_t>(std::countr_zero(word)));
}

}   // namespace

void VisibilityCounters::add(const VisibilityCounters& other)
{
    points += other.points, free_points += other.free_points, remembered += other.remembered;
    rays += other.rays, dynamic_rays += other.dynamic_rays;
}

Surroundings::Surroundings(const scene::SceneState& state, const ray::RayScene& rays)
    : rays_(&rays),
      triangles_(std::make_unique<visibility::StaticTriangles>(state, rays)),
      dynamic_(std::make_unique<visibility::DynamicBounds>(state, rays))
{
    dynamic_->all(boxes_);
}

bool Surroundings::follow(const scene::SceneState& state, const ray::RayScene& rays)
{
    rays_ = &rays;
    const bool changed = !state.changes().promoted.empty();
    if (changed) {
        triangles_ = std::make_unique<visibility::StaticTriangles>(state, rays);
        dynamic_ = std::make_unique<visibility::DynamicBounds>(state, rays);
    } else {
        triangles_->follow(state.scene());
        dynamic_->update(state, rays);
    }
    dynamic_->all(boxes_);
    return changed;
}

CellVisibility::CellVisibility(const Surroundings& surroundings, const DirectionCells& cells,
                               const ProofOptions& options)
    : surroundings_(surroundings),
      cells_(cells),
      proofs_(std::make_unique<CellProofs>(surroundings.triangles(), cells, options))
{
    for (int axis = 0; axis < 3; ++axis) {
        auto& list = mean_[static_cast<std::size_t>(axis)];
        list.assign(64 * cells.words(), 0);
        for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) list[leaf] = cells.mean(leaf)[axis];
    }
}

// Finds the cells above a surface; neighbours in a batch often have the same normal.
void CellVisibility::find_above(Scratch& scratch, const glm::vec3& normal) const
{
    if (scratch.has_above && scratch.above_normal == normal) return;
    scratch.has_above = true;
    scratch.above_normal = normal;
    scratch.above.assign(cells_.words(), 0);
    for (std::size_t w = 0; w < scratch.above.size(); ++w) {
        std::array<std::uint8_t, 64> above{};
        const float *x = mean_[0].data() + 64 * w, *y = mean_[1].data() + 64 * w, *z = mean_[2].data() + 64 * w;
        for (std::size_t i = 0; i < 64; ++i)
            above[i] = static_cast<std::uint8_t>(normal.x * x[i] + normal.y * y[i] + normal.z * z[i] > 0);
        std::uint64_t word = 0;
        for (std::size_t i = 0; i < 64; ++i) word |= std::uint64_t{above[i]} << i;
        scratch.above[w] = word;
    }
}

glm::vec3 CellVisibility::ray_direction(std::size_t leaf, const glm::vec3& normal) const
{
    const glm::vec3& own = cells_.direction(leaf);
    return glm::dot(own, normal) > k_least_sine ? own : glm::normalize(cells_.mean(leaf));
}

void CellVisibility::find(Scratch& scratch, std::span<const ShadowPoint> points, std::span<const std::uint32_t> asked,
                          PointMemory* memory, SeenCells& seen) const
{
    seen.words = cells_.words();
    seen.masks.assign(asked.size() * seen.words, 0);
    scratch.queue.purpose = ray::RayClass::shadow;
    scratch.has_above = false;
    scratch.counters.points += asked.size();
    look_up(scratch, points, asked, memory, seen);
    if (!surroundings_.dynamic_boxes().empty()) test_dynamic(scratch, points, asked, seen);
}

// Finds what points see past static objects; points on dynamic objects, past everything.
void CellVisibility::look_up(Scratch& scratch, std::span<const ShadowPoint> points,
                             std::span<const std::uint32_t> asked, PointMemory* memory, SeenCells& seen) const
{
    const std::size_t words = seen.words;
    scratch.pending.clear();
    for (const bool on_dynamic : {false, true}) {
        const ray::Against against = on_dynamic ? ray::Against::everything : ray::Against::static_only;
        for (std::size_t begin = 0; begin < asked.size(); begin += k_block) {
            const std::size_t end = std::min(begin + k_block, asked.size());
            scratch.open.assign(k_block * words, 0);
            bool any = false;
            for (std::size_t k = begin; k < end; ++k) {
                const ShadowPoint& p = points[asked[k]];
                const TriangleId first = p.object == scene::none ? visibility::no_triangle
                                                                 : surroundings_.triangles().first_of(p.object);
                if ((first == visibility::no_triangle) != on_dynamic) continue;
                if (p.normal == glm::vec3(0)) continue;
                find_above(scratch, p.normal);
                std::uint64_t* open = scratch.open.data() + (k - begin) * words;
                if (on_dynamic) {
                    std::copy(scratch.above.begin(), scratch.above.end(), open);
                    any = true;
                    continue;
                }
                const std::span<std::uint64_t> mask = seen.of(k);
                if (memory) {
                    if (const PointMemory::Known known = memory->find(p); known.masks) {
                        ++scratch.counters.remembered;
                        for (std::size_t w = 0; w < words; ++w) mask[w] = known.masks->free[w];
                        std::size_t i = 0;
                        for_each_bit(known.masks->open, [&](std::size_t leaf) {
                            mask[leaf / 64] |= (known.seen[i / 64] >> (i % 64) & 1) << (leaf % 64);
                            ++i;
                        });
                        for (std::size_t w = 0; w < words; ++w) mask[w] &= scratch.above[w];
                        continue;
                    }
                }
                const PartMasks& masks = proofs_->part_at(first + p.triangle, p.front, p.u, p.v);
                bool asks = false;
                for (std::size_t w = 0; w < words; ++w) {
                    mask[w] = masks.free[w] & scratch.above[w];
                    open[w] = masks.open[w] & scratch.above[w];
                    asks = asks || open[w] != 0;
                }
                if (!asks) {
                    ++scratch.counters.free_points;
                    continue;
                }
                any = true;
                if (memory) scratch.pending.push_back({static_cast<std::uint32_t>(k), &masks});
            }
            if (any) push_rays(scratch, points, asked, begin, end);
            if (scratch.queue.size() >= k_rays_at_once) flush(scratch, against, true, scratch.counters.rays, seen);
        }
        flush(scratch, against, true, scratch.counters.rays, seen);
    }
    for (const auto& [k, masks] : scratch.pending) {
        scratch.seen_open.clear();
        std::size_t i = 0;
        for_each_bit(masks->open, [&](std::size_t leaf) {
            if (i % 64 == 0) scratch.seen_open.push_back(0);
            scratch.seen_open.back() |= (seen.of(k)[leaf / 64] >> (leaf % 64) & 1) << (i % 64);
            ++i;
        });
        memory->add(points[asked[k]], *masks, scratch.seen_open);
    }
}

// Queues the rays of a block of points to their open cells, direction by direction.
void CellVisibility::push_rays(Scratch& scratch, std::span<const ShadowPoint> points,
                               std::span<const std::uint32_t> asked, std::size_t begin, std::size_t end) const
{
    const std::size_t words = cells_.words(), count = end - begin;
    for (std::size_t w = 0; w < words; ++w) {
        std::uint64_t all = 0;
        for (std::size_t k = 0; k < count; ++k) all |= scratch.open[k * words + w];
        for (; all != 0; all &= all - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(all));
            const std::size_t leaf = 64 * w + bit;
            for (std::size_t k = 0; k < count; ++k) {
                if ((scratch.open[k * words + w] >> bit & 1) == 0) continue;
                const ShadowPoint& p = points[asked[begin + k]];
                scratch.queue.push(p.origin, 0, ray_direction(leaf, p.normal), k_infinity);
                scratch.targets.push_back({static_cast<std::uint32_t>(begin + k), static_cast<std::uint16_t>(leaf)});
            }
        }
    }
}

// Finds the cells that a box may cover from somewhere in a sphere, and adds them to those affected.
void CellVisibility::cover(Scratch& scratch, const glm::vec3& from, float from_radius, const Box3& box) const
{
    constexpr float k_room = 1.0001f;
    const glm::vec3 way = box.centre() - from;
    const float distance = glm::length(way), radius = k_room * (from_radius + 0.5f * box.diagonal());
    if (!(distance > radius)) {
        std::fill(scratch.affected.begin(), scratch.affected.end(), ~std::uint64_t{0});
        return;
    }
    const glm::vec3 axis = way / distance;
    const float sine = std::min(radius / distance * k_room, 1.0f), cosine = std::sqrt(1 - sine * sine);
    scratch.stack.clear();
    for (std::uint32_t r = 0; r < cells_.roots(); ++r) scratch.stack.push_back(r);
    while (!scratch.stack.empty()) {
        const DirectionNode& node = cells_.nodes()[scratch.stack.back()];
        scratch.stack.pop_back();
        // Whether the angle between the axes is at most the sum of both half-angles.
        const float own_sine = std::sqrt(std::max(0.0f, 1 - node.cosine * node.cosine));
        const float sum_cosine = cosine * node.cosine - sine * own_sine;   // both are below 90 degrees
        constexpr float k_rounding = 1e-4f;
        if (glm::dot(axis, node.axis) < sum_cosine - k_rounding) continue;
        if (node.children == 0)
            scratch.affected[node.first_leaf / 64] |= std::uint64_t{1} << (node.first_leaf % 64);
        else
            for (std::uint32_t q = 0; q < 4; ++q) scratch.stack.push_back(node.children + q);
    }
}

// Takes away what dynamic objects hide from points of static ones.
void CellVisibility::test_dynamic(Scratch& scratch, std::span<const ShadowPoint> points,
                                  std::span<const std::uint32_t> asked, SeenCells& seen) const
{
    const std::size_t words = seen.words;
    for (std::size_t begin = 0; begin < asked.size(); begin += k_block) {
        const std::size_t end = std::min(begin + k_block, asked.size());
        Box3 box;
        bool any = false;
        for (std::size_t k = begin; k < end; ++k) {
            const ShadowPoint& p = points[asked[k]];
            const bool is_static = p.object != scene::none &&
                                   surroundings_.triangles().first_of(p.object) != visibility::no_triangle;
            if (is_static) box.add(p.origin), any = true;
        }
        if (!any) continue;
        scratch.affected.assign(words, 0);
        const glm::vec3 middle = box.centre();
        for (const Box3& blocker : surroundings_.dynamic_boxes())
            cover(scratch, middle, 0.5f * box.diagonal(), blocker);
        scratch.open.assign(k_block * words, 0);
        bool asks = false;
        for (std::size_t k = begin; k < end; ++k) {
            const ShadowPoint& p = points[asked[k]];
            if (p.object == scene::none || surroundings_.triangles().first_of(p.object) == visibility::no_triangle)
                continue;
            for (std::size_t w = 0; w < words; ++w) {
                const std::uint64_t word = seen.of(k)[w] & scratch.affected[w];
                scratch.open[(k - begin) * words + w] = word;
                asks = asks || word != 0;
            }
        }
        if (asks) push_rays(scratch, points, asked, begin, end);
        if (scratch.queue.size() >= k_rays_at_once)
            flush(scratch, ray::Against::dynamic_only, false, scratch.counters.dynamic_rays, seen);
    }
    flush(scratch, ray::Against::dynamic_only, false, scratch.counters.dynamic_rays, seen);
}

// Traces the queue, and sets the cells that rays reach, or takes away those that they do not reach.
void CellVisibility::flush(Scratch& scratch, ray::Against against, bool sets, std::uint64_t& count,
                           SeenCells& seen) const
{
    const std::size_t rays = scratch.queue.size();
    if (rays == 0) return;
    count += rays;
    scratch.occluded.resize(rays + ray::k_packet_pad);
    surroundings_.rays().occluded(scratch.queue, 0, rays, scratch.occluded.data(), against);
    for (std::size_t r = 0; r < rays; ++r) {
        const auto [asked, leaf] = scratch.targets[r];
        std::uint64_t& word = seen.of(asked)[leaf / 64];
        const std::uint64_t bit = std::uint64_t{1} << (leaf % 64);
        if (sets && !scratch.occluded[r]) word |= bit;
        if (!sets && scratch.occluded[r]) word &= ~bit;
    }
    scratch.queue.clear(), scratch.targets.clear();
}

}   // namespace gnomon::environment_light
