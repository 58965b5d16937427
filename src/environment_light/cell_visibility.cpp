// SPDX-License-Identifier: Apache-2.0
#include "environment_light/cell_visibility.h"

#include <algorithm>
#include <bit>

#include "environment_light/cell_query.h"

namespace gnomon::environment_light {

namespace {

using visibility::ShadowPoint;
using visibility::TriangleId;

// Probes: one cell of 64, others for each point of a block and for blocks next to each other. A window or an occluder
// that is smaller than the distance of guides and shows in a few cells alone brings or takes a few percent of the
// light.
constexpr std::uint32_t k_probe_step = 64;

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
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf) {
        luminance_.push_back(luminance(cells.flux(leaf)));
        most_luminance_ = std::max(most_luminance_, luminance_.back());
    }
    std::vector<std::uint64_t> windows = cells.stand_ins();
    for (const CellFamily& family : cells.families())
        if (family.leaves <= 4)
            for_each_word(family.first, family.leaves, [&](std::size_t w, std::uint64_t bits) { windows[w] |= bits; });
    looked_into_ = windows;
    in_windows_.assign(k_window_kinds * cells.words(), 0);
    std::size_t number = 0;
    for_each_bit(windows, [&](std::size_t leaf) {
        in_windows_[number++ % k_window_kinds * cells.words() + leaf / 64] |= std::uint64_t{1} << (leaf % 64);
    });
    probes_.assign(k_probe_step * cells.words(), 0);
    for (std::size_t leaf = 0; leaf < cells.leaves(); ++leaf)
        probes_[cells.stable_number(leaf) % k_probe_step * cells.words() + leaf / 64] |= std::uint64_t{1}
                                                                                         << (leaf % 64);
}

void CellVisibility::take_over(const CellVisibility& other)
{
    proofs_->take_over(*other.proofs_);
    number_ = other.number_ + 1;
    other_ = &other;
    leaf_of_other_ = other.cells_.same_leaves(cells_);
}

// Finds the cells above a point's surface; neighbours often have the same normal.
void CellVisibility::find_above(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const glm::vec3& normal = query.point(k).normal;
    const std::span<std::uint64_t> above = query.of(scratch.above, k);
    if (scratch.above_at < k && scratch.above_normal == normal) {
        const auto same = query.of(scratch.above, scratch.above_at);
        std::copy(same.begin(), same.end(), above.begin());
    } else {
        for (std::size_t w = 0; w < above.size(); ++w) {
            std::array<std::uint8_t, 64> is_above{};
            const float *x = mean_[0].data() + 64 * w, *y = mean_[1].data() + 64 * w, *z = mean_[2].data() + 64 * w;
            for (std::size_t i = 0; i < 64; ++i)
                is_above[i] = static_cast<std::uint8_t>(normal.x * x[i] + normal.y * y[i] + normal.z * z[i] > 0);
            std::uint64_t word = 0;
            for (std::size_t i = 0; i < 64; ++i) word |= std::uint64_t{is_above[i]} << i;
            above[w] = word;
        }
    }
    scratch.above_normal = normal;
    scratch.above_at = k;
}

// The mask of the cells that a point probes.
const std::uint64_t* CellVisibility::probes_of(const Guides& guides) const
{
    static_assert(k_probe_step == 1 << (32 - 26));
    const std::uint32_t kind = (guides.block * 16 + guides.number) * 0x9e3779b1u >> 26;
    return probes_.data() + kind * cells_.words();
}

glm::vec3 CellVisibility::ray_direction(std::size_t leaf, const glm::vec3& normal) const
{
    const glm::vec3& own = cells_.direction(leaf);
    return glm::dot(own, normal) > k_least_sine ? own : glm::normalize(cells_.mean(leaf));
}

void CellVisibility::find(Scratch& scratch, std::span<const ShadowPoint> points, std::span<const std::uint32_t> asked,
                          std::span<const Guides> guides, PointMemory* memory, SeenCells& seen, std::size_t first,
                          std::span<const Guides> moving) const
{
    const bool moves = !surroundings_.dynamic_boxes().empty();
    if (first == 0) {
        seen.words = cells_.words();
        for (auto* masks :
             {&seen.masks, &scratch.above, &scratch.known, &scratch.free, &scratch.wanted, &scratch.between})
            masks->clear();
        seen.partial.clear(), seen.partials.clear();
        scratch.asked.clear(), scratch.light.clear(), scratch.unit.clear(), scratch.known_of.clear();
        scratch.glance.clear();
        scratch.small_windows = false;
    } else if (moves) {
        seen = scratch.at_rest;
    }
    const std::size_t all = asked.size() * seen.words;
    for (auto* masks : {&seen.masks, &scratch.above, &scratch.known, &scratch.free, &scratch.wanted, &scratch.between})
        masks->resize(all, 0);
    scratch.queue.purpose = scratch.part_queue.purpose = ray::RayClass::shadow;
    seen.partials.resize(asked.size());
    scratch.divided.clear(), scratch.known_parts.clear(), scratch.glimpses.clear();
    scratch.asked.resize(asked.size());
    scratch.light.resize(asked.size(), 0);
    scratch.unit.resize(asked.size(), 0);
    scratch.known_of.resize(asked.size());
    scratch.glance.resize(asked.size(), k_no_glance);
    scratch.counters.points += asked.size() - first;
    Query query{scratch, points, asked, guides, seen, first};
    if (!cells_.families().empty() && std::ranges::any_of(guides, &Guides::coarse))
        for (const Guides& guide : guides) query.is_coarse.push_back(guide.coarse ? 1 : 0);
    query.rough = !query.is_coarse.empty() && std::ranges::any_of(guides, &Guides::rough);
    look_up(query, memory);
    if (!query.is_coarse.empty()) decide_coarse(query);
    decide_alone(query);
    divide(query, 0);
    int passes = 0;
    for (const Guides& guide : guides) passes = std::max<int>(passes, guide.pass);
    for (int pass = 1; pass <= passes; ++pass) {
        decide_guided(query, pass);
        divide(query, pass);
    }
    if (memory) remember(query, *memory);
    if (moves && !guides.empty()) scratch.at_rest = seen;
    if (!moves) return;
    if (!moving.empty()) query.guides = moving;
    test_dynamic(query);
}

// Finds what is proven or remembered of points on static objects.
void CellVisibility::look_up(const Query& query, PointMemory* memory) const
{
    Scratch& scratch = query.scratch;
    const std::size_t words = query.seen.words;
    scratch.above_at = query.count();
    for (std::size_t k = query.first; k < query.count(); ++k) {
        const ShadowPoint& p = query.point(k);
        if (p.normal == glm::vec3(0)) continue;
        find_above(query, k);
        const TriangleId first =
            p.object == scene::none ? visibility::no_triangle : surroundings_.triangles().first_of(p.object);
        Scratch::Asked& own = scratch.asked[k];
        own.is_static = first != visibility::no_triangle;
        own.on_dynamic = !own.is_static;
        if (own.on_dynamic) continue;
        const auto above = query.of(scratch.above, k), sure = query.of(scratch.known, k),
                   free = query.of(scratch.free, k);
        const PointMemory::Known known = memory ? memory->find(p) : PointMemory::Known{};
        const bool of_these = known.masks && known.cells == number_;
        own.masks = of_these ? known.masks : &proofs_->part_at(first + p.triangle, p.front, p.u, p.v);
        bool asks = false;
        for (std::size_t w = 0; w < words; ++w) {
            free[w] = own.masks->free[w] & above[w];
            sure[w] = ~own.masks->open[w] & above[w];
            asks = asks || sure[w] != above[w];
        }
        if (!asks) ++scratch.counters.free_points;
        if (known.masks && other_ && known.cells == other_->number_) read_other(query, k, known);
        if (!of_these) continue;
        ++scratch.counters.remembered;
        scratch.known_of[k] = {static_cast<std::uint32_t>(scratch.known_parts.size()),
                               static_cast<std::uint32_t>(known.parts.size())};
        scratch.known_parts.insert(scratch.known_parts.end(), known.parts.begin(), known.parts.end());
        if (PointMemory::has_all_bits(*own.masks)) {
            for (std::size_t w = 0; w < words; ++w) sure[w] |= known.traced[w], free[w] |= known.seen[w];
            continue;
        }
        std::size_t i = 0;
        for_each_bit(own.masks->open, [&](std::size_t leaf) {
            sure[leaf / 64] |= (known.traced[i / 64] >> (i % 64) & 1) << (leaf % 64);
            free[leaf / 64] |= (known.seen[i / 64] >> (i % 64) & 1) << (leaf % 64);
            ++i;
        });
    }
}

// Takes over what rays found at a point in directions that other cells had as well.
void CellVisibility::read_other(const Query& query, std::size_t k, const PointMemory::Known& known) const
{
    Scratch& scratch = query.scratch;
    const auto sure = query.of(scratch.known, k), free = query.of(scratch.free, k);
    const glm::vec3& normal = query.point(k).normal;
    const bool all = PointMemory::has_all_bits(*known.masks);
    std::size_t i = 0;
    for_each_bit(known.masks->open, [&](std::size_t there) {
        const std::size_t at = all ? there : i++, word = at / 64, bit = at % 64;
        const std::int32_t leaf = leaf_of_other_[there];
        if (leaf < 0 || (known.traced[word] >> bit & 1) == 0) return;
        const auto own = static_cast<std::size_t>(leaf);
        // A direction that stands in for a cell at the horizon depends on the image.
        if (has(sure, own) || !has(query.of(scratch.above, k), own) ||
            !(glm::dot(cells_.direction(own), normal) > k_least_sine))
            return;
        sure[own / 64] |= std::uint64_t{1} << (own % 64);
        free[own / 64] |= (known.seen[word] >> bit & 1) << (own % 64);
    });
    ++scratch.counters.remembered;
    scratch.asked[k].fresh = true;   // to be remembered for these cells
}

// Decides the cells of points without guides.
void CellVisibility::decide_alone(const Query& query) const
{
    Scratch& scratch = query.scratch;
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != 0 || query.coarse(k)) continue;
        const auto above = query.of(scratch.above, k), wanted = query.of(scratch.wanted, k);
        std::copy(above.begin(), above.end(), wanted.begin());
    }
    decide(query, 0);
}

// Decides the wanted cells of the points of a pass, scouts first: those of groups, and for points without guides, which
// want all cells, those of families.
void CellVisibility::decide(const Query& query, int pass) const
{
    Scratch& scratch = query.scratch;
    const bool by_families = pass == 0 && !cells_.families().empty();
    if (cells_.groups().empty() && !by_families) return decide_wanted(query, pass);
    const std::size_t words = query.seen.words;
    scratch.following.assign(query.count() * words, 0);
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        const auto wanted = query.of(scratch.wanted, k), following = query.of(scratch.following, k),
                   above = query.of(scratch.above, k);
        if (query.coarse(k)) continue;
        for (const LeafGroup& group : cells_.groups()) {
            // If one of its leaves is wanted, all scouts are.
            bool any = false;
            for (std::size_t leaf = group.first; leaf < group.first + group.leaves && !any; ++leaf)
                any = has(wanted, leaf);
            if (!any) continue;
            for (const std::uint32_t leaf : group.scouts)
                wanted[leaf / 64] |= above[leaf / 64] & std::uint64_t{1} << (leaf % 64);
        }
        for (std::size_t w = 0; w < words; ++w) {
            const std::uint64_t later = cells_.followers()[w] | (by_families ? cells_.family_followers()[w] : 0);
            following[w] = wanted[w] & later, wanted[w] &= ~later;
        }
    }
    decide_wanted(query, pass);
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        if (query.coarse(k)) continue;
        follow_groups(query, k);
        if (by_families) follow_families(query, k);
    }
    decide_wanted(query, pass);
}

// Takes the followers of a group to be as its scouts if these agree, else wants them.
void CellVisibility::follow_groups(const Query& query, std::size_t k) const
{
    const auto above = query.of(query.scratch.above, k);
    const auto mask = query.seen.of(k);
    for (const LeafGroup& group : cells_.groups()) {
        bool some_seen = false, some_hidden = false;
        for (const std::uint32_t leaf : group.scouts)
            if (has(above, leaf)) (has(mask, leaf) ? some_seen : some_hidden) = true;
        follow(query, k, group.first, group.leaves, some_seen, some_hidden);
    }
}

// The same for families: the middle scouts of neighbours count, too.
void CellVisibility::follow_families(const Query& query, std::size_t k) const
{
    const auto above = query.of(query.scratch.above, k), following = query.of(query.scratch.following, k);
    const auto mask = query.seen.of(k);
    const std::span<const CellFamily> families = cells_.families();
    for (const CellFamily& family : families) {
        bool any = false;
        for_each_word(family.first, family.leaves,
                      [&](std::size_t w, std::uint64_t bits) { any = any || (following[w] & bits) != 0; });
        if (!any) continue;
        bool some_seen = false, some_hidden = false;
        const auto look_at = [&](std::uint32_t scout) {
            if (has(above, scout)) (has(mask, scout) ? some_seen : some_hidden) = true;
        };
        for (const std::uint32_t scout : family.scouts) look_at(scout);
        if (some_seen != some_hidden)
            for (const std::uint32_t n : family.neighbours) look_at(families[n].scout);
        follow(query, k, family.first, family.leaves, some_seen, some_hidden);
    }
}

// Decides those of some leaves in a row that follow scouts; where these disagree, or there are none, they are wanted.
void CellVisibility::follow(const Query& query, std::size_t k, std::size_t first, std::size_t leaves, bool some_seen,
                            bool some_hidden) const
{
    const auto following = query.of(query.scratch.following, k), wanted = query.of(query.scratch.wanted, k);
    const auto mask = query.seen.of(k);
    for_each_word(first, leaves, [&](std::size_t w, std::uint64_t bits) {
        bits &= following[w];
        if (some_seen == some_hidden)
            wanted[w] |= bits;
        else
            mask[w] = some_seen ? mask[w] | bits : mask[w] & ~bits;
        following[w] &= ~bits;
    });
}

// Decides the cells of points with guides. What guides agree on is taken even where it is proven or remembered to be
// otherwise, so that the answer does not depend on that.
void CellVisibility::decide_guided(const Query& query, int pass) const
{
    Scratch& scratch = query.scratch;
    const std::size_t words = query.seen.words;
    std::size_t blocks = 0;
    for (const Guides& guide : query.guides)
        if (guide.pass == pass) blocks = std::max<std::size_t>(blocks, guide.block + 1);
    scratch.agreed.assign(query.count() * words, 0);
    scratch.contested.assign(blocks * words, 0);
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        const Guides& guide = query.guides[k];
        const auto above = query.of(scratch.above, k), wanted = query.of(scratch.wanted, k),
                   agreed = query.of(scratch.agreed, k);
        const auto mask = query.seen.of(k);
        const std::uint64_t* const probes = probes_of(guide);
        const auto between = query.of(scratch.between, k);
        for (std::size_t w = 0; w < words; ++w) {
            std::uint64_t all_see = ~std::uint64_t{0}, none_sees = ~std::uint64_t{0}, above_all = ~std::uint64_t{0};
            for (const std::uint32_t c : guide.corner) {
                const std::uint64_t sees = query.seen.of(c)[w], above_guide = scratch.above[c * words + w];
                all_see &= sees, none_sees &= ~sees & above_guide, above_all &= above_guide;
            }
            agreed[w] = above[w] & (all_see | none_sees);
            mask[w] = agreed[w] & all_see;
            wanted[w] = above[w] & (~agreed[w] | probes[w]);
            between[w] = above[w] & above_all & ~agreed[w];
        }
        // Where guides see nearly as much light in the cells on which they disagree, interpolate these.
        if (!guides_are_alike(query, k, between)) std::ranges::fill(between, 0);
        for (std::size_t w = 0; w < words; ++w) wanted[w] &= ~between[w];
    }
    decide(query, pass);
    // Where a probe found otherwise, decide the cell at all points of the block, and those around it at the point.
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        const Guides& guide = query.guides[k];
        const auto agreed = query.of(scratch.agreed, k), wanted = query.of(scratch.wanted, k);
        const auto mask = query.seen.of(k), corner = query.seen.of(guide.corner[0]);
        std::uint64_t* contested = scratch.contested.data() + guide.block * words;
        for (std::size_t w = 0; w < words; ++w) {
            std::uint64_t other = agreed[w] & (mask[w] ^ corner[w]);
            contested[w] |= other;
            for (; other != 0; other &= other - 1)
                cells_.add_around(64 * w + static_cast<std::size_t>(std::countr_zero(other)), wanted);
        }
    }
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        const auto above = query.of(scratch.above, k), wanted = query.of(scratch.wanted, k);
        const std::uint64_t* contested = scratch.contested.data() + query.guides[k].block * words;
        const auto between = query.of(scratch.between, k);
        for (std::size_t w = 0; w < words; ++w) {
            wanted[w] = above[w] & (wanted[w] | contested[w]);
            between[w] &= ~wanted[w];
        }
    }
    decide(query, pass);
}

// Decides the wanted cells of the points of a pass: by what is known, else by rays.
void CellVisibility::decide_wanted(const Query& query, int pass) const
{
    Scratch& scratch = query.scratch;
    const std::size_t words = query.seen.words;
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        const auto mask = query.seen.of(k);
        const auto known = query.of(scratch.known, k), free = query.of(scratch.free, k),
                   wanted = query.of(scratch.wanted, k);
        for (std::size_t w = 0; w < words; ++w) {
            const std::uint64_t now = wanted[w] & known[w];
            mask[w] = (mask[w] & ~now) | (free[w] & now);
            wanted[w] &= ~known[w];
        }
    }
    for (const bool on_dynamic : {false, true}) {
        const ray::Against against = on_dynamic ? ray::Against::everything : ray::Against::static_only;
        // Blocks of neighbours of one kind, whose rays in one direction share packets.
        std::vector<std::uint32_t>& block = scratch.stack;
        block.clear();
        for (std::size_t k = 0; k <= query.count(); ++k) {
            if (k < query.count()) {
                if (scratch.asked[k].on_dynamic != on_dynamic || query.pass(k) != pass) continue;
                const auto wanted = query.of(scratch.wanted, k);
                if (std::ranges::all_of(wanted, [](std::uint64_t word) { return word == 0; })) continue;
                block.push_back(static_cast<std::uint32_t>(k));
            }
            if (block.size() < k_block && k < query.count()) continue;
            push_rays(query, block);
            block.clear();
            if (scratch.queue.size() >= k_rays_at_once) flush(query, against, true, scratch.counters.rays);
        }
        flush(query, against, true, scratch.counters.rays);
    }
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != pass) continue;
        for (std::size_t w = k * words; w < (k + 1) * words; ++w) {
            if (scratch.wanted[w] != 0) scratch.asked[k].fresh = true;
            scratch.known[w] |= scratch.wanted[w];
            scratch.free[w] |= scratch.wanted[w] & query.seen.masks[w];
            scratch.wanted[w] = 0;
        }
    }
}

// Queues the wanted rays of a block of points, direction by direction.
void CellVisibility::push_rays(const Query& query, std::span<const std::uint32_t> block) const
{
    Scratch& scratch = query.scratch;
    const std::size_t words = query.seen.words;
    for (std::size_t w = 0; w < words; ++w) {
        std::uint64_t all = 0;
        for (const std::uint32_t k : block) all |= scratch.wanted[k * words + w];
        for (; all != 0; all &= all - 1) {
            const auto bit = static_cast<std::size_t>(std::countr_zero(all));
            const std::size_t leaf = 64 * w + bit;
            for (const std::uint32_t k : block) {
                if ((scratch.wanted[k * words + w] >> bit & 1) == 0) continue;
                const ShadowPoint& p = query.point(k);
                scratch.queue.push(p.origin, 0, ray_direction(leaf, p.normal), k_infinity);
                scratch.targets.push_back({k, static_cast<std::uint16_t>(leaf)});
            }
        }
    }
}

// Traces the queue, and sets the cells that rays reach and takes away those that they do not reach, or the latter
// alone.
void CellVisibility::flush(const Query& query, ray::Against against, bool sets, std::uint64_t& count) const
{
    Scratch& scratch = query.scratch;
    const std::size_t rays = scratch.queue.size();
    if (rays == 0) return;
    count += rays;
    scratch.occluded.resize(rays + ray::k_packet_pad);
    surroundings_.rays().occluded(scratch.queue, 0, rays, scratch.occluded.data(), against);
    for (std::size_t r = 0; r < rays; ++r) {
        const auto [asked, leaf] = scratch.targets[r];
        std::uint64_t& word = query.seen.of(asked)[leaf / 64];
        const std::uint64_t bit = std::uint64_t{1} << (leaf % 64);
        if (scratch.occluded[r])
            word &= ~bit;
        else if (sets)
            word |= bit;
    }
    scratch.queue.clear(), scratch.targets.clear();
}

// Keeps what rays found at static points.
void CellVisibility::remember(const Query& query, PointMemory& memory) const
{
    Scratch& scratch = query.scratch;
    // Sort what was found of parts by point.
    std::vector<std::uint32_t>& order = scratch.order;
    order.clear();
    for (std::uint32_t d = 0; d < scratch.divided.size(); ++d)
        if (scratch.divided[d].remembered) order.push_back(d);
    std::ranges::sort(order, {},
                      [&](std::uint32_t d) { return std::pair(scratch.divided[d].asked, scratch.divided[d].leaf); });
    std::ranges::sort(scratch.glimpses, {}, [](const auto& glimpse) { return std::pair(glimpse.asked, glimpse.leaf); });
    std::size_t next = 0, glimpse = 0;
    for (std::size_t k = query.first; k < query.count(); ++k) {
        scratch.own_parts.clear();
        for (; next < order.size() && scratch.divided[order[next]].asked == k; ++next)
            scratch.own_parts.push_back({scratch.divided[order[next]].leaf, scratch.divided[order[next]].seen});
        if (scratch.glance[k] != k_no_glance) {
            for (; glimpse < scratch.glimpses.size() && scratch.glimpses[glimpse].asked == k; ++glimpse)
                scratch.own_parts.push_back(
                    {k_glimpse | scratch.glimpses[glimpse].leaf, scratch.glimpses[glimpse].part});
            scratch.own_parts.push_back({k_last_glimpse, scratch.glance[k]});
        }
        const Scratch::Asked& own = scratch.asked[k];
        if (!own.is_static || !own.fresh) continue;
        const auto known = query.of(scratch.known, k), free = query.of(scratch.free, k);
        const std::span<const std::uint64_t> open = own.masks->open;
        if (PointMemory::has_all_bits(*own.masks)) {
            scratch.bits.resize(2 * open.size());
            for (std::size_t w = 0; w < open.size(); ++w)
                scratch.bits[w] = known[w] & open[w], scratch.bits[open.size() + w] = free[w] & open[w];
        } else {
            std::size_t count = 0;
            for (const std::uint64_t word : open) count += static_cast<std::size_t>(std::popcount(word));
            const std::size_t words = (count + 63) / 64;
            scratch.bits.assign(2 * words, 0);
            std::size_t i = 0;
            for_each_bit(open, [&](std::size_t leaf) {
                scratch.bits[i / 64] |= (known[leaf / 64] >> (leaf % 64) & 1) << (i % 64);
                scratch.bits[words + i / 64] |= (free[leaf / 64] >> (leaf % 64) & 1) << (i % 64);
                ++i;
            });
        }
        memory.add(query.point(k), *own.masks, number_, scratch.bits, scratch.own_parts);
    }
}

}   // namespace gnomon::environment_light
