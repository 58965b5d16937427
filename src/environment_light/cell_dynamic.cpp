// SPDX-License-Identifier: Apache-2.0
// What dynamic objects hide of the cells that points of static objects see (cell_visibility.h).
#include <algorithm>
#include <bit>

#include "environment_light/cell_query.h"

namespace gnomon::environment_light {

// Finds the cells that a box may cover from somewhere in a sphere, and adds them to those affected.
void CellVisibility::cover(Scratch& scratch, const glm::vec3& from, float from_radius, const Box3& box) const
{
    constexpr float k_room = 1.0001f;
    const glm::vec3 way = box.centre() - from;
    const float distance = glm::length(way), radius = k_room * (from_radius + 0.5f * box.diagonal());
    const glm::vec3 outside = glm::max(box.low - from, from - box.high);   // how far, by axis
    if (std::max({outside.x, outside.y, outside.z}) <= k_room * from_radius) {
        std::fill(scratch.affected.begin(), scratch.affected.end(), ~std::uint64_t{0});
        return;
    }
    const bool beyond = distance > radius;
    const glm::vec3 axis = beyond ? way / distance : glm::vec3(0);
    const float sine = beyond ? std::min(radius / distance * k_room, 1.0f) : 1.0f;
    const float cosine = std::sqrt(1 - sine * sine), farthest = distance + radius;
    scratch.stack.clear();
    for (std::uint32_t r = 0; r < cells_.roots(); ++r) scratch.stack.push_back(r);
    while (!scratch.stack.empty()) {
        const DirectionNode& node = cells_.nodes()[scratch.stack.back()];
        scratch.stack.pop_back();
        if (beyond) {
            // Whether the angle between the axes is at most the sum of both half-angles.
            const float own_sine = std::sqrt(std::max(0.0f, 1 - node.cosine * node.cosine));
            const float sum_cosine = cosine * node.cosine - sine * own_sine;   // both are below 90 degrees
            constexpr float k_rounding = 1e-4f;
            if (glm::dot(axis, node.axis) < sum_cosine - k_rounding) continue;
        }
        // A ray of the node is nowhere farther from the ray through its axis than this, up to the box's far side.
        const float apart = k_room * (from_radius + farthest * std::sqrt(std::max(0.0f, 2 - 2 * node.cosine)));
        const Box3 wider{box.low - glm::vec3(apart), box.high + glm::vec3(apart)};
        if (!visibility::segment_meets(wider, from, node.axis, farthest)) continue;
        if (node.children == 0)
            scratch.affected[node.first_leaf / 64] |= std::uint64_t{1} << (node.first_leaf % 64);
        else
            for (std::uint32_t q = 0; q < node.count; ++q) scratch.stack.push_back(node.children + q);
    }
}

// Takes away what dynamic objects hide from points of static ones: first from points without guides, then from those
// between them.
void CellVisibility::test_dynamic(const Query& query) const
{
    Scratch& scratch = query.scratch;
    find_affected(query);
    const auto for_each_point = [&](int pass, const auto& body) {
        for (std::size_t k = query.first; k < query.count(); ++k)
            if (scratch.asked[k].is_static && query.pass(k) == pass) body(k);
    };
    for_each_point(0, [&](std::size_t k) {
        std::ranges::copy(query.of(scratch.touched, k), query.of(scratch.wanted, k).begin());
        if (query.coarse(k)) leave_stand_ins(query, k);
    });
    decide_dynamic(query, 0);
    for_each_point(0, [&](std::size_t k) {
        if (!query.coarse(k)) return;
        follow_hidden(query, k);
        note_found(query, k, query.of(scratch.touched, k));
    });
    int passes = 0;
    for (const Guides& guide : query.guides) passes = std::max<int>(passes, guide.pass);
    for (int pass = 1; pass <= passes; ++pass) {
        std::size_t blocks = 0;
        for (const Guides& guide : query.guides)
            if (guide.pass == pass) blocks = std::max<std::size_t>(blocks, guide.block + 1);
        scratch.contested.assign(blocks * query.seen.words, 0);
        for_each_point(pass, [&](std::size_t k) { follow_guides(query, k); });
        decide_dynamic(query, pass);
        for_each_point(pass, [&](std::size_t k) { contest(query, k); });
        for_each_point(pass, [&](std::size_t k) {
            const auto agreed = query.of(scratch.agreed, k), wanted = query.of(scratch.wanted, k);
            const std::uint64_t* const contested = scratch.contested.data() + query.guides[k].block * query.seen.words;
            const std::uint64_t* const probes = probes_of(query.guides[k]);
            for (std::size_t w = 0; w < wanted.size(); ++w)
                wanted[w] = agreed[w] & ~probes[w] & (wanted[w] | contested[w]);
        });
        decide_dynamic(query, pass);
    }
}

// Finds the cells of each point that dynamic objects may hide, and those of these of which it asks for a share.
void CellVisibility::find_affected(const Query& query) const
{
    Scratch& scratch = query.scratch;
    const std::size_t words = query.seen.words, all = query.count() * words;
    for (auto* masks : {&scratch.touched, &scratch.shared, &scratch.clear_of, &scratch.hidden_by, &scratch.agreed}) {
        if (query.first == 0) masks->clear();
        masks->resize(all, 0);
    }
    std::vector<std::uint32_t> block;
    for (std::size_t k = query.first; k <= query.count(); ++k) {
        if (k < query.count() && scratch.asked[k].is_static) block.push_back(static_cast<std::uint32_t>(k));
        if (block.size() < k_block && k < query.count()) continue;
        if (block.empty()) continue;
        Box3 box;
        for (const std::uint32_t b : block) box.add(query.point(b).origin);
        scratch.affected.assign(words, 0);
        for (const Box3& blocker : surroundings_.dynamic_boxes())
            cover(scratch, box.centre(), 0.5f * box.diagonal(), blocker);
        for (const std::uint32_t b : block) {
            const auto touched = query.of(scratch.touched, b), clear = query.of(scratch.clear_of, b);
            for (std::size_t w = 0; w < words; ++w) {
                touched[w] = query.seen.of(b)[w] & scratch.affected[w];
                clear[w] = ~scratch.affected[w];
            }
            if (!query.coarse(b)) find_shared(query, b);
        }
        block.clear();
    }
}

// Takes cells to be as all guides of a point found them, and wants the others, and probes.
void CellVisibility::follow_guides(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const Guides& guide = query.guides[k];
    const auto touched = query.of(scratch.touched, k), shared = query.of(scratch.shared, k),
               wanted = query.of(scratch.wanted, k), agreed = query.of(scratch.agreed, k),
               clear = query.of(scratch.clear_of, k), hidden = query.of(scratch.hidden_by, k);
    const auto mask = query.seen.of(k);
    const std::uint64_t* const probes = probes_of(guide);
    for (std::size_t w = 0; w < touched.size(); ++w) {
        std::uint64_t all_clear = touched[w], all_hidden = touched[w] & ~shared[w];
        for (const std::uint32_t c : guide.corner) {
            all_clear &= query.of(scratch.clear_of, c)[w];
            all_hidden &= query.of(scratch.hidden_by, c)[w];
        }
        agreed[w] = all_clear | all_hidden;
        mask[w] &= ~all_hidden;
        clear[w] |= all_clear, hidden[w] |= all_hidden;
        wanted[w] = touched[w] & (~agreed[w] | probes[w]);
    }
}

// Where a probe found otherwise than the guides, wants the cells around at the point, and the cell at all points of its
// block.
void CellVisibility::contest(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const Guides& guide = query.guides[k];
    const auto wanted = query.of(scratch.wanted, k), agreed = query.of(scratch.agreed, k),
               clear = query.of(scratch.clear_of, k);
    const auto guided = query.of(scratch.clear_of, guide.corner[0]);
    std::uint64_t* const contested = scratch.contested.data() + guide.block * agreed.size();
    for (std::size_t w = 0; w < agreed.size(); ++w) {
        std::uint64_t other = agreed[w] & (clear[w] ^ guided[w]);
        contested[w] |= other;
        for (; other != 0; other &= other - 1)
            cells_.add_around(64 * w + static_cast<std::size_t>(std::countr_zero(other)), wanted);
    }
}

// Tests the wanted cells of the points of a pass against what moves, as wholes or by parts.
void CellVisibility::decide_dynamic(const Query& query, int pass) const
{
    Scratch& scratch = query.scratch;
    scratch.divided.clear();
    for (std::size_t k = query.first; k < query.count(); ++k) {
        if (!scratch.asked[k].is_static || query.pass(k) != pass) continue;
        divide_affected(query, k);
        const auto wanted = query.of(scratch.wanted, k), shared = query.of(scratch.shared, k);
        for (std::size_t w = 0; w < wanted.size(); ++w) wanted[w] &= ~shared[w];
    }
    std::vector<std::uint32_t>& block = scratch.stack;
    block.clear();
    for (std::size_t k = query.first; k <= query.count(); ++k) {
        if (k < query.count()) {
            if (!scratch.asked[k].is_static || query.pass(k) != pass) continue;
            if (std::ranges::all_of(query.of(scratch.wanted, k), [](std::uint64_t word) { return word == 0; }))
                continue;
            block.push_back(static_cast<std::uint32_t>(k));
        }
        if (block.size() < k_block && k < query.count()) continue;
        push_rays(query, block);
        block.clear();
        if (scratch.queue.size() >= k_rays_at_once)
            flush(query, ray::Against::dynamic_only, true, scratch.counters.dynamic_rays);
    }
    flush(query, ray::Against::dynamic_only, true, scratch.counters.dynamic_rays);
    for (std::size_t k = query.first; k < query.count(); ++k) {
        if (!scratch.asked[k].is_static || query.pass(k) != pass) continue;
        const auto wanted = query.of(scratch.wanted, k);
        note_found(query, k, wanted);
        std::ranges::fill(wanted, 0);
    }
    take_dynamic_parts(query);
}

// Notes of cells that are decided whether dynamic objects leave or hide them.
void CellVisibility::note_found(const Query& query, std::size_t k, std::span<const std::uint64_t> decided) const
{
    const auto clear = query.of(query.scratch.clear_of, k), hidden = query.of(query.scratch.hidden_by, k);
    const auto mask = query.seen.of(k);
    for (std::size_t w = 0; w < mask.size(); ++w) {
        clear[w] = (clear[w] & ~decided[w]) | (decided[w] & mask[w]);
        hidden[w] = (hidden[w] & ~decided[w]) | (decided[w] & ~mask[w]);
    }
}

}   // namespace gnomon::environment_light
