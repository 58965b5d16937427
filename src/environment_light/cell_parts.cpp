// SPDX-License-Identifier: Apache-2.0
// The shares of cells that points see where a whole cell is too much (cell_visibility.h).
#include <algorithm>
#include <bit>

#include "environment_light/cell_query.h"

namespace gnomon::environment_light {

namespace {

// A cell is divided into the more parts, the more of a point's visible light it brings: above the first fraction into
// 4, above the second into 16, above the third into 64. The fractions are those of a point that sees much of the light
// above it; a point that sees little has smaller ones, because what it sees is all that lights it.
constexpr std::array<float, 3> k_divided_above = {1 / 64.0f, 1 / 32.0f, 1 / 8.0f};
constexpr float k_much = 1 / 4.0f, k_finest = 1 / 2.0f;   // of the light above; of the fractions
// Points that guide no others, on small triangles: steps do not show there, and every ray is their own.
constexpr float k_alone = 16;
// A point that sees less than this fraction of the light above it looks for windows that scouts missed.
constexpr float k_dark = 1 / 16.0f;
// Where points in the dark see at most so many cells each, on average, some may be visible through a small part only.
constexpr std::size_t k_small_window = 2;
// Shares at guides are interpolated if what the cell brings differs by at most this fraction of the visible light.
constexpr float k_alike = 1 / 32.0f;
// Cells on which guides disagree are interpolated if what they bring together differs by at most this fraction.
constexpr float k_interpolated = 1 / 16.0f;
constexpr int k_rounds = 3;

// @param light  of the cell
// @param all    that is visible
int level_of(float light, float all)
{
    int level = 0;
    while (level < k_rounds && light > k_divided_above[static_cast<std::size_t>(level)] * all) ++level;
    return level;
}

// The part of a leaf at which points in the dark look in turn: the first ones in different quarters.
std::uint32_t part_in_turn(std::uint32_t turn, std::size_t leaf)
{
    const std::uint32_t part = (turn & 3) << 4 | (turn & 12) | turn >> 4;
    return part ^ (static_cast<std::uint32_t>(leaf) * 0x9e3779b1u >> 26);
}

// Whether the bits of a mask are all set, or none is.
bool all_agree(std::uint64_t bits, std::uint64_t mask)
{
    return (bits & mask) == 0 || (bits & mask) == mask;
}

// Lets one part of each group of so many in a row stand for the group.
std::uint64_t spread(std::uint64_t seen, std::uint64_t representatives, std::uint32_t group)
{
    std::uint64_t result = 0;
    const std::uint64_t ones = (std::uint64_t{1} << group) - 1;
    for (std::uint32_t first = 0; first < k_parts; first += group)
        if ((seen & representatives) >> first & ones) result |= ones << first;
    return result;
}

}   // namespace

const PartDirections& CellVisibility::part_directions() const
{
    std::call_once(parts_made_, [&] { parts_ = std::make_unique<PartDirections>(cells_); });
    return *parts_;
}

// The luminance that a visible cell brings to a surface.
float CellVisibility::light_of(std::size_t leaf, const glm::vec3& normal) const
{
    const float cosine = normal.x * mean_[0][leaf] + normal.y * mean_[1][leaf] + normal.z * mean_[2][leaf];
    return luminance_[leaf] * std::max(cosine, 0.0f);
}

float CellVisibility::light_of(std::span<const std::uint64_t> mask, const glm::vec3& normal) const
{
    float sum = 0;
    for_each_bit(mask, [&](std::size_t leaf) { sum += light_of(leaf, normal); });
    return sum;
}

// Finds the shares of cells for the points of a pass, whose cells are decided.
void CellVisibility::divide(const Query& query, int pass) const
{
    if (cells_.families().empty()) return;
    Scratch& scratch = query.scratch;
    const std::size_t first = scratch.divided.size();
    const auto for_each_point = [&](const auto& body) {
        for (std::size_t k = 0; k < query.count(); ++k)
            if (query.pass(k) == pass && !query.coarse(k) && query.point(k).normal != glm::vec3(0)) body(k);
    };
    if (pass == 0) {
        for_each_point([&](std::size_t k) { measure_light(query, k); });
        look_for_windows(query);
        for_each_point([&](std::size_t k) { divide_alone(query, k); });
    } else {
        for_each_point([&](std::size_t k) { divide_guided(query, k); });
    }
    trace_parts(query, first);
    add_partials(query, first);
    // Let proofs be made sooner where they would have saved many rays.
    constexpr std::uint32_t k_asks = 16;   // cells that count like a point
    for (std::size_t d = first; d < scratch.divided.size();) {
        const std::uint32_t k = scratch.divided[d].asked;
        std::uint32_t cells = 0;
        for (; d < scratch.divided.size() && scratch.divided[d].asked == k; ++d)
            cells += scratch.divided[d].traced != 0 ? 1 : 0;
        const visibility::ShadowPoint& p = query.point(k);
        if (cells >= k_asks && scratch.asked[k].is_static)
            proofs_->ask_for_shares(surroundings_.triangles().first_of(p.object) + p.triangle, p.front, p.u, p.v,
                                    cells / k_asks);
    }
}

// Finds the light that a point sees, and what cells are compared with.
void CellVisibility::measure_light(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const glm::vec3& normal = query.point(k).normal;
    const float seen = light_of(query.seen.of(k), normal);
    scratch.light[k] = scratch.unit[k] = seen;
    if (level_of(most_luminance_, k_finest * seen) == 0) return;
    const float all = light_of(query.of(scratch.above, k), normal);
    if (all > 0) scratch.unit[k] = seen * std::clamp(seen / (k_much * all), k_finest, 1.0f);
}

bool CellVisibility::is_dark(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    return scratch.light[k] < k_dark * light_of(query.of(scratch.above, k), query.point(k).normal);
}

// Looks from points in the dark in directions that scouts left out, and lists the families in which any of these points
// sees the sky: what one of them sees through, the others look at.
void CellVisibility::look_for_windows(const Query& query) const
{
    Scratch& scratch = query.scratch;
    scratch.windows.assign(cells_.families().size(), 0);
    std::vector<std::uint32_t>& dark = scratch.dark;
    dark.clear();
    std::size_t kind = 0;
    for (std::size_t k = 0; k < query.count(); ++k) {
        if (query.pass(k) != 0 || query.coarse(k) || query.point(k).normal == glm::vec3(0)) continue;
        if (level_of(most_luminance_, scratch.unit[k]) == 0 || !is_dark(query, k)) continue;
        if (query.guides.empty() || !query.guides[k].guides) continue;
        dark.push_back(static_cast<std::uint32_t>(k));
        const auto above = query.of(scratch.above, k), wanted = query.of(scratch.wanted, k);
        // Neighbours look in different directions.
        const std::uint64_t* directions = in_windows_.data() + kind++ % k_window_kinds * above.size();
        for (std::size_t w = 0; w < above.size(); ++w) wanted[w] = above[w] & directions[w];
    }
    if (dark.empty()) return;
    decide_wanted(query, 0);
    const std::span<const CellFamily> families = cells_.families();
    for (const std::uint32_t k : dark) {
        const auto mask = query.seen.of(k);
        for (std::size_t f = 0; f < families.size(); ++f)
            for_each_word(families[f].first, families[f].leaves, [&](std::size_t w, std::uint64_t bits) {
                if ((mask[w] & bits) != 0) scratch.windows[f] = 1;
            });
    }
    glance_between(query);
    scratch.small_windows = scratch.glimpses.size() <= k_small_window * dark.size();
    // Decide the cells around windows at all of them.
    std::vector<std::uint64_t>& around = scratch.affected;
    around.assign(query.seen.words, 0);
    for (std::size_t f = 0; f < families.size(); ++f)
        if (scratch.windows[f] != 0) cells_.add_around(families[f].scout, around);
    for (const std::uint32_t k : dark) {
        const auto above = query.of(scratch.above, k), wanted = query.of(scratch.wanted, k);
        for (std::size_t w = 0; w < above.size(); ++w) wanted[w] = above[w] & around[w];
    }
    decide_wanted(query, 0);
    for (const std::uint32_t k : dark) measure_light(query, k);
}

// Looks from points in the dark into one part of each cell, neighbours into different parts, so that a window that is
// narrower than a cell is found by one of them.
void CellVisibility::glance_between(const Query& query) const
{
    Scratch& scratch = query.scratch;
    const PartDirections& parts = part_directions();
    const auto flush = [&](ray::Against against) {
        const std::size_t rays = scratch.part_queue.size();
        if (rays == 0) return;
        scratch.counters.rays += rays;
        scratch.occluded.resize(rays + ray::k_packet_pad);
        surroundings_.rays().occluded(scratch.part_queue, 0, rays, scratch.occluded.data(), against);
        for (std::size_t r = 0; r < rays; ++r)
            if (!scratch.occluded[r]) scratch.glimpses.push_back(scratch.glance_targets[r]);
        scratch.part_queue.clear(), scratch.glance_targets.clear();
    };
    for (const bool on_dynamic : {false, true}) {
        const ray::Against against = on_dynamic ? ray::Against::everything : ray::Against::static_only;
        for (std::uint32_t number = 0; number < scratch.dark.size(); ++number) {
            const std::uint32_t k = scratch.dark[number];
            Scratch::Asked& own = scratch.asked[k];
            if (own.on_dynamic != on_dynamic) continue;
            const std::uint32_t turn = number % k_parts;
            scratch.glance[k] = turn;
            // Take what is remembered of the same parts.
            const auto [first, count] = scratch.known_of[k];
            const std::span<const KnownParts> known(scratch.known_parts.data() + first, count);
            if (!known.empty() && known.back().leaf == k_last_glimpse && known.back().seen == turn) {
                for (const KnownParts& glimpse : known)
                    if (glimpse.leaf >= k_glimpse && glimpse.leaf != k_last_glimpse)
                        scratch.glimpses.push_back(
                            {k, glimpse.leaf - k_glimpse, static_cast<std::uint32_t>(glimpse.seen)});
                continue;
            }
            own.fresh = true;
            const visibility::ShadowPoint& p = query.point(k);
            for_each_bit(query.of(scratch.above, k), [&](std::size_t leaf) {
                if (!has(looked_into_, leaf)) return;
                const std::uint32_t part = part_in_turn(turn, leaf);
                const glm::vec3& way = parts.direction(leaf, part);
                if (!(glm::dot(way, p.normal) > k_least_sine)) return;
                const Scratch::Glimpse glimpse{k, static_cast<std::uint32_t>(leaf), part};
                if (own.masks && has(own.masks->whole, leaf)) {
                    if (has(own.masks->free, leaf)) scratch.glimpses.push_back(glimpse);
                    return;
                }
                scratch.part_queue.push(p.origin, 0, way, k_infinity);
                scratch.glance_targets.push_back(glimpse);
            });
            if (scratch.part_queue.size() >= k_rays_at_once) flush(against);
        }
        flush(against);
    }
    for (const Scratch::Glimpse& glimpse : scratch.glimpses) scratch.windows[cells_.family_of(glimpse.leaf)] = 1;
}

// Asks for the cells at the rim of what a point without guides sees.
void CellVisibility::divide_alone(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const glm::vec3& normal = query.point(k).normal;
    const auto above = query.of(scratch.above, k);
    const auto mask = query.seen.of(k);
    const bool guides = !query.guides.empty() && query.guides[k].guides;
    const float unit = (guides ? 1 : k_alone) * scratch.unit[k];
    if (level_of(most_luminance_, unit) == 0) return;
    const bool dark = guides && is_dark(query, k);
    // Find families with visible and hidden leaves, or beside such; in the dark, those with windows, and beside these.
    const std::span<const CellFamily> families = cells_.families();
    constexpr std::uint8_t k_seen = 1, k_hidden = 2;
    scratch.family_sees.assign(families.size(), 0);
    for (std::size_t f = 0; f < families.size(); ++f) {
        for_each_word(families[f].first, families[f].leaves, [&](std::size_t w, std::uint64_t bits) {
            if ((mask[w] & bits) != 0) scratch.family_sees[f] |= k_seen;
            if ((above[w] & ~mask[w] & bits) != 0) scratch.family_sees[f] |= k_hidden;
        });
        if (dark && scratch.windows[f] != 0) scratch.family_sees[f] |= k_seen | k_hidden;
    }
    for (std::size_t f = 0; f < families.size(); ++f) {
        std::uint8_t around = scratch.family_sees[f];
        if (around == 0) continue;
        for (const std::uint32_t n : families[f].neighbours) around |= scratch.family_sees[n];
        if (around != (k_seen | k_hidden)) continue;
        for (std::size_t leaf = families[f].first; leaf < families[f].first + families[f].leaves; ++leaf) {
            if (!has(above, leaf)) continue;
            const int level = level_of(light_of(leaf, normal), unit);
            if (level > 0) look_at(query, k, leaf, level, dark && scratch.small_windows);
        }
    }
}

// The share that a point sees of a cell.
float CellVisibility::share_at(const Query& query, std::size_t k, std::size_t leaf)
{
    const std::span<const PartialCell> partial = query.seen.partial_of(k);
    const auto at = std::ranges::lower_bound(partial, static_cast<std::uint32_t>(leaf), {}, &PartialCell::leaf);
    if (at != partial.end() && at->leaf == leaf) return at->share;
    return has(query.seen.of(k), leaf) ? 1.0f : 0.0f;
}

// Whether the guides of a point get nearly as much light as each other from the cells on which they disagree.
bool CellVisibility::guides_are_alike(const Query& query, std::size_t k, std::span<const std::uint64_t> leaves) const
{
    if (cells_.families().empty()) return false;
    const Guides& guides = query.guides[k];
    const glm::vec3& normal = query.point(k).normal;
    std::array<float, 4> light{};
    for_each_bit(leaves, [&](std::size_t leaf) {
        const float brings = light_of(leaf, normal);
        for (std::size_t i = 0; i < light.size(); ++i)
            if (has(query.seen.of(guides.corner[i]), leaf)) light[i] += brings;
    });
    float unit = 0;
    for (std::size_t i = 0; i < light.size(); ++i) unit += guides.weight[i] * query.scratch.unit[guides.corner[i]];
    const auto [least, most] = std::ranges::minmax(light);
    return most - least <= k_interpolated * unit;
}

// Interpolates the shares of cells at guides that are alike, and asks for the others.
void CellVisibility::divide_guided(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const Guides& guides = query.guides[k];
    const glm::vec3& normal = query.point(k).normal;
    std::vector<std::uint32_t>& leaves = scratch.union_leaves;
    leaves.clear();
    float unit = 0;
    for (std::size_t i = 0; i < guides.corner.size(); ++i) {
        unit += guides.weight[i] * scratch.unit[guides.corner[i]];
        if (guides.weight[i] > 0 || i == 0)
            for (const PartialCell& cell : query.seen.partial_of(guides.corner[i])) leaves.push_back(cell.leaf);
    }
    scratch.unit[k] = unit;
    const auto interpolated = query.of(scratch.between, k);
    for_each_bit(interpolated, [&](std::size_t leaf) { leaves.push_back(static_cast<std::uint32_t>(leaf)); });
    if (leaves.empty()) return;
    std::ranges::sort(leaves);
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    const auto above = query.of(scratch.above, k);
    for (const std::uint32_t leaf : leaves) {
        if (!has(above, leaf)) continue;
        float least = 1, most = 0, between = 0;
        for (std::size_t i = 0; i < guides.corner.size(); ++i) {
            const float share = share_at(query, guides.corner[i], leaf);
            least = std::min(least, share), most = std::max(most, share);
            between += guides.weight[i] * share;
        }
        const float brings = light_of(leaf, normal);
        if (has(interpolated, leaf) || brings * (most - least) <= k_alike * unit) {
            if (has(interpolated, leaf)) set(query.seen.of(k), leaf, between >= 0.5f);
            Scratch::Divided& divided = scratch.divided.emplace_back();
            divided.asked = static_cast<std::uint32_t>(k), divided.leaf = leaf;
            divided.share = std::clamp(between, 0.0f, 1.0f);
            divided.done = true, divided.remembered = false;
        } else if (const int level = level_of(brings, unit); level > 0) {
            look_at(query, k, leaf, level, scratch.small_windows);
        }
    }
}

// Asks for the share that a point sees of a cell: by what is proven or remembered, else by rays.
// @param small_window  the cell may be visible through less than a sixteenth of it
void CellVisibility::look_at(const Query& query, std::size_t k, std::size_t leaf, int level, bool small_window) const
{
    Scratch& scratch = query.scratch;
    const Scratch::Asked& own = scratch.asked[k];
    const glm::vec3& normal = query.point(k).normal;
    Scratch::Divided divided;
    divided.asked = static_cast<std::uint32_t>(k), divided.leaf = static_cast<std::uint32_t>(leaf);
    divided.level = level;
    divided.thorough = level == k_rounds || (small_window && level > 1);
    divided.fine = level == k_rounds && small_window;
    divided.above = ~std::uint64_t{0};
    if (own.masks && has(own.masks->whole, leaf)) {
        divided.seen = has(own.masks->free, leaf) ? ~std::uint64_t{0} : 0;
        divided.done = true, divided.remembered = false;
        scratch.divided.push_back(divided);
        return;
    }
    const DirectionNode& node = cells_.nodes()[cells_.node_of(leaf)];
    const float sine = std::sqrt(std::max(0.0f, 1 - node.cosine * node.cosine));
    if (!(glm::dot(node.axis, normal) > sine + k_least_sine))
        divided.above = part_directions().above(leaf, normal, k_least_sine);
    if (divided.above == 0) return;
    const auto [first, count] = scratch.known_of[k];
    const std::span<const KnownParts> known(scratch.known_parts.data() + first, count);
    const auto at = std::ranges::lower_bound(known, static_cast<std::uint32_t>(leaf), {}, &KnownParts::leaf);
    if (at != known.end() && at->leaf == leaf) divided.seen = at->seen, divided.done = true;
    scratch.divided.push_back(divided);
}

// Traces rays to parts of the cells that are asked for from the first one on, few at first, and more where these
// disagree.
void CellVisibility::trace_parts(const Query& query, std::size_t first) const
{
    using parts::k_of_quarter, parts::k_of_sixteenth;
    Scratch& scratch = query.scratch;
    for (int round = 0; round < k_rounds; ++round) {
        push_parts(query, first, round, false, ray::Against::static_only, scratch.counters.rays);
        push_parts(query, first, round, true, ray::Against::everything, scratch.counters.rays);
        for (std::size_t d = first; d < scratch.divided.size(); ++d) {
            Scratch::Divided& of = scratch.divided[d];
            if (of.done) continue;
            scratch.asked[of.asked].fresh = true;
            if (of.above != ~std::uint64_t{0}) {   // all of its rays were traced
                of.done = true;
            } else if (round == 0 && of.thorough) {
                continue;
            } else if (round == 0) {
                const bool as_cell = has(query.seen.of(of.asked), of.leaf) == ((of.seen & k_of_quarter) != 0);
                of.done = of.level == 1 || (all_agree(of.seen, k_of_quarter) && as_cell);
                if (of.done) of.seen = spread(of.seen, k_of_quarter, 16);
            } else if (round == 1) {
                const bool hidden = (of.seen & k_of_sixteenth) == 0;
                of.done = of.level == 2 || (all_agree(of.seen, k_of_sixteenth) && !(of.fine && hidden));
                if (of.done) of.seen = spread(of.seen, k_of_sixteenth, 4);
            } else {
                of.done = true;
            }
        }
    }
}

// Queues and traces the rays of a round, direction by direction for blocks of neighbouring points of one kind.
void CellVisibility::push_parts(const Query& query, std::size_t first, int round, bool on_dynamic, ray::Against against,
                                std::uint64_t& count) const
{
    using parts::k_of_quarter, parts::k_of_sixteenth;
    Scratch& scratch = query.scratch;
    const auto wanted = [&](const Scratch::Divided& of) {
        std::uint64_t mask = 0;
        if (of.above != ~std::uint64_t{0}) return of.above & ~of.traced;
        if (round == 0) mask = of.thorough ? k_of_sixteenth : k_of_quarter;
        if (round == 1) mask = k_of_sixteenth;
        if (round == 2) mask = ~std::uint64_t{0};
        return mask & ~of.traced;
    };
    std::vector<std::uint32_t>& block = scratch.order;
    block.clear();
    std::size_t points = 0;
    std::uint32_t last = 0xffffffff;
    const auto push_block = [&] {
        std::ranges::stable_sort(block, {}, [&](std::uint32_t d) { return scratch.divided[d].leaf; });
        for (std::size_t i = 0; i < block.size();) {
            const std::uint32_t leaf = scratch.divided[block[i]].leaf;
            std::size_t end = i;
            std::uint64_t all = 0;
            for (; end < block.size() && scratch.divided[block[end]].leaf == leaf; ++end)
                all |= wanted(scratch.divided[block[end]]);
            for (; all != 0; all &= all - 1) {
                const auto part = static_cast<std::uint32_t>(std::countr_zero(all));
                for (std::size_t j = i; j < end; ++j) {
                    const Scratch::Divided& of = scratch.divided[block[j]];
                    if ((wanted(of) >> part & 1) == 0) continue;
                    scratch.part_queue.push(query.point(of.asked).origin, 0, part_directions().direction(leaf, part),
                                            k_infinity);
                    scratch.part_targets.push_back({block[j], part});
                }
            }
            i = end;
        }
        block.clear();
        points = 0;
    };
    for (std::size_t d = first; d < scratch.divided.size(); ++d) {
        const Scratch::Divided& of = scratch.divided[d];
        if (of.done || scratch.asked[of.asked].on_dynamic != on_dynamic) continue;
        if (of.asked != last) {
            if (points == k_block) push_block();
            if (scratch.part_queue.size() >= k_rays_at_once) flush_parts(query, against, count);
            last = of.asked;
            ++points;
        }
        block.push_back(static_cast<std::uint32_t>(d));
    }
    push_block();
    flush_parts(query, against, count);
}

void CellVisibility::flush_parts(const Query& query, ray::Against against, std::uint64_t& count) const
{
    Scratch& scratch = query.scratch;
    const std::size_t rays = scratch.part_queue.size();
    if (rays == 0) return;
    count += rays;
    scratch.occluded.resize(rays + ray::k_packet_pad);
    surroundings_.rays().occluded(scratch.part_queue, 0, rays, scratch.occluded.data(), against);
    for (std::size_t r = 0; r < rays; ++r) {
        const auto [d, part] = scratch.part_targets[r];
        Scratch::Divided& of = scratch.divided[d];
        of.traced |= std::uint64_t{1} << part;
        if (!scratch.occluded[r]) of.seen |= std::uint64_t{1} << part;
    }
    scratch.part_queue.clear(), scratch.part_targets.clear();
}

// Lists the shares that were found.
void CellVisibility::add_partials(const Query& query, std::size_t first) const
{
    Scratch& scratch = query.scratch;
    for (std::size_t d = first; d < scratch.divided.size();) {
        const std::uint32_t k = scratch.divided[d].asked;
        const auto mask = query.seen.of(k);
        const auto begin = static_cast<std::uint32_t>(query.seen.partial.size());
        for (; d < scratch.divided.size() && scratch.divided[d].asked == k; ++d) {
            const Scratch::Divided& of = scratch.divided[d];
            const float share = of.share >= 0 ? of.share
                                              : static_cast<float>(std::popcount(of.seen & of.above)) /
                                                    static_cast<float>(std::popcount(of.above));
            const float whole = has(mask, of.leaf) ? 1.0f : 0.0f;
            if (share == whole) continue;
            query.seen.partial.push_back({of.leaf, share});
        }
        query.seen.partials[k] = {begin, static_cast<std::uint32_t>(query.seen.partial.size()) - begin};
    }
}

// Finds the cells that dynamic objects may hide of which a point asks for shares: those that bring much of its light,
// or of which it sees a share already.
void CellVisibility::find_shared(const Query& query, std::size_t k) const
{
    Scratch& scratch = query.scratch;
    const float unit = scratch.unit[k];
    const std::span<const PartialCell> partial = query.seen.partial_of(k);
    const bool divides = unit > 0 && level_of(most_luminance_, unit) > 0;
    if (!divides && partial.empty()) return;
    const auto touched = query.of(scratch.touched, k), shared = query.of(scratch.shared, k);
    for (const PartialCell& cell : partial) set(shared, cell.leaf, has(scratch.affected, cell.leaf));
    if (divides)
        for_each_bit(touched, [&](std::size_t leaf) {
            if (level_of(light_of(leaf, query.point(k).normal), unit) > 0) set(shared, leaf, true);
        });
    for (std::size_t w = 0; w < touched.size(); ++w) touched[w] |= shared[w];
}

// Asks for the shares of those of the wanted cells.
void CellVisibility::divide_affected(const Query& query, std::size_t k) const
{
    using parts::k_of_quarter, parts::k_of_sixteenth;
    Scratch& scratch = query.scratch;
    const float unit = scratch.unit[k];
    const bool divides = unit > 0 && level_of(most_luminance_, unit) > 0;
    const std::span<const PartialCell> partial = query.seen.partial_of(k);
    const auto wanted = query.of(scratch.wanted, k), shared = query.of(scratch.shared, k);
    for (std::size_t w = 0; w < wanted.size(); ++w)
        for (std::uint64_t word = wanted[w] & shared[w]; word != 0; word &= word - 1) {
            const std::size_t leaf = 64 * w + static_cast<std::size_t>(std::countr_zero(word));
            const auto at = std::ranges::lower_bound(partial, static_cast<std::uint32_t>(leaf), {}, &PartialCell::leaf);
            const int level = divides ? level_of(light_of(leaf, query.point(k).normal), unit) : 0;
            Scratch::Divided of;
            of.asked = static_cast<std::uint32_t>(k), of.leaf = static_cast<std::uint32_t>(leaf);
            of.above = part_directions().above(leaf, query.point(k).normal, k_least_sine) &
                       (level > 1 ? k_of_sixteenth : k_of_quarter);
            of.thorough = at != partial.end() && at->leaf == leaf;
            if (of.above != 0) scratch.divided.push_back(of);
        }
}

// Takes from the shares what dynamic objects hide.
void CellVisibility::take_dynamic_parts(const Query& query) const
{
    Scratch& scratch = query.scratch;
    if (scratch.divided.empty()) return;
    push_parts(query, 0, 0, false, ray::Against::dynamic_only, scratch.counters.dynamic_rays);
    // Of a share, what is hidden counts among the parts that static objects leave.
    for (Scratch::Divided& of : scratch.divided) {
        of.clear = of.seen;
        of.done = !of.thorough || of.clear == of.above;
        if (!of.done) of.traced = of.seen = 0;
    }
    push_parts(query, 0, 0, false, ray::Against::static_only, scratch.counters.rays);
    for (std::size_t d = 0; d < scratch.divided.size();) {
        const std::uint32_t k = scratch.divided[d].asked;
        const auto mask = query.seen.of(k);
        // Merge the shares of the point with those that changed.
        const std::span<const PartialCell> before = query.seen.partial_of(k);
        scratch.partial.assign(before.begin(), before.end());
        for (; d < scratch.divided.size() && scratch.divided[d].asked == k; ++d) {
            const Scratch::Divided& of = scratch.divided[d];
            if (of.clear == of.above) {
                set(query.of(scratch.clear_of, k), of.leaf, true);
                continue;
            }
            set(query.of(scratch.clear_of, k), of.leaf, false);
            const std::uint64_t counts = of.thorough && of.seen != 0 ? of.seen : of.above;
            const float clear =
                static_cast<float>(std::popcount(of.clear & counts)) / static_cast<float>(std::popcount(counts));
            const auto at = std::ranges::lower_bound(scratch.partial, of.leaf, {}, &PartialCell::leaf);
            if (at != scratch.partial.end() && at->leaf == of.leaf)
                at->share *= clear;
            else if (has(mask, of.leaf))
                scratch.partial.insert(at, {of.leaf, clear});
        }
        query.seen.partials[k] = {static_cast<std::uint32_t>(query.seen.partial.size()),
                                  static_cast<std::uint32_t>(scratch.partial.size())};
        query.seen.partial.insert(query.seen.partial.end(), scratch.partial.begin(), scratch.partial.end());
    }
}

}   // namespace gnomon::environment_light
