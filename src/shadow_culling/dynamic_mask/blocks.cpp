// SPDX-License-Identifier: Apache-2.0
// Draws the blocks of the mask of dynamic objects.
#include <algorithm>

#include "shadow_culling/dynamic_mask/parts.h"

namespace gnomon::shadow_culling {

namespace {

// Bound, in texels, on the displacement of an outline by rounding of single-precision texel coordinates.
constexpr float k_texel_slack = 1.0f / 64;

std::size_t hash_of(BlockKey key)
{
    return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ull) >> 32);
}

constexpr int k_side = static_cast<int>(k_block_side);

// Progress of drawing a block. Lost: memory ran out, and rays are cast instead.
constexpr int k_not_drawn = 0, k_being_drawn = 1, k_drawn = 2, k_lost = 3;

// The position of a block on the light's plane.
struct Place {
    float low_x, high_x, low_y, high_y, texels;   // texels: per side of the whole plane
};

Place place_of(BlockKey key)
{
    const float texels = static_cast<float>(1u << level_of(key));
    const float low_x = static_cast<float>(x_of(key) * k_block_side) / texels;
    const float low_y = static_cast<float>(y_of(key) * k_block_side) / texels;
    return {low_x, low_x + k_block_side / texels, low_y, low_y + k_block_side / texels, texels};
}

// A texel coordinate within a range. Of large objects beside small static scenes it exceeds the range of int.
int texel_within(float at, int least, int most)
{
    return static_cast<int>(std::clamp(at, static_cast<float>(least), static_cast<float>(most)));
}

// Expands the bits of four texels to words.
constexpr auto k_spread = [] {
    std::array<std::array<std::uint32_t, 4>, 16> spread{};
    for (std::uint32_t bits = 0; bits < 16; ++bits)
        for (std::uint32_t c = 0; c < 4; ++c) spread[bits][c] = bits >> c & 1 ? 0xffffffffu : 0;
    return spread;
}();

// Applies a word of bits to the texels of a row.
void or_bits(std::uint32_t* row, std::uint32_t texels, std::uint32_t value)
{
    if (texels == 0) return;
    for (std::uint32_t c = 0; c < k_block_side; c += 4) {
        const auto& mask = k_spread[texels >> c & 15];
        for (std::uint32_t i = 0; i < 4; ++i) row[c + i] |= mask[i] & value;
    }
}

}   // namespace

// Returns the drawn block, or null if rays are cheaper. The estimate uses the rays that the points of this batch need,
// or those of the last frame, whichever are more.
DynamicMask::Block* DynamicMask::block_at(LightMask& mask, BlockKey key, std::uint32_t rays)
{
    const std::size_t wrap = mask.table.size() - 1;
    Block* block = nullptr;
    const auto find = [&](std::size_t& slot) {
        for (slot = hash_of(key) & wrap;; slot = (slot + 1) & wrap) {
            Block* const here = mask.table[slot].load(std::memory_order_acquire);
            if (here == nullptr || here->key == key) return here;
        }
    };
    std::size_t slot = 0;
    block = find(slot);
    if (block == nullptr) {
        std::unique_lock lock(mask.mutex);
        block = find(slot);
        if (block == nullptr) {
            if (4 * mask.used > 3 * mask.table.size()) return nullptr;
            if (mask.used == mask.blocks.size()) mask.blocks.push_back(std::make_unique<Block>());
            block = mask.blocks[mask.used++].get();
            block->key = key;
            block->ready.store(false, std::memory_order_relaxed);
            block->drawn.store(k_not_drawn, std::memory_order_relaxed);
            block->static_begins.store(std::numeric_limits<float>::quiet_NaN(), std::memory_order_relaxed);
            block->rays.store(0, std::memory_order_relaxed);
            const auto before = mask.asked_before.find(key);
            block->expected = before != mask.asked_before.end() ? before->second : 0;
            mask.table[slot].store(block, std::memory_order_release);
            lock.unlock();
            const auto publish = [&] {
                block->ready.store(true, std::memory_order_release);
                block->ready.notify_all();
            };
            try {
                find_prints(mask, *block);
            } catch (...) {
                block->drawn.store(k_lost, std::memory_order_relaxed);
                publish();   // other threads wait for it
                throw;
            }
            publish();
        }
    }
    block->ready.wait(false, std::memory_order_acquire);
    block->rays.fetch_add(rays, std::memory_order_relaxed);
    const std::uint32_t worth = std::max(rays, block->expected);
    if (!(options_.edges_per_ray * worth >= block->edges)) return nullptr;

    // The first thread that needs the block draws it; others wait.
    int drawn = block->drawn.load(std::memory_order_acquire);
    if (drawn == k_not_drawn && block->drawn.compare_exchange_strong(drawn, k_being_drawn)) {
        const auto publish = [&](int as) {
            block->drawn.store(as, std::memory_order_release);
            block->drawn.notify_all();
        };
        try {
            draw(mask, *block);
        } catch (...) {
            publish(k_lost);
            throw;
        }
        publish(k_drawn);
        return block;
    }
    block->drawn.wait(k_being_drawn, std::memory_order_acquire);
    return block->drawn.load(std::memory_order_acquire) == k_drawn ? block : nullptr;
}

// Gathers the prints that may be in a block, from a bin.
void DynamicMask::find_prints(const LightMask& mask, Block& block) const
{
    const std::uint32_t face = face_of(block.key);
    const auto [low_x, high_x, low_y, high_y, texels] = place_of(block.key);
    const auto bin = [](float at, float from, float scale) {
        return static_cast<std::uint32_t>(std::clamp((at - from) * scale, 0.0f, static_cast<float>(k_bins - 1)));
    };
    const auto meets = [&](const Print& print) {
        return print.face == face && print.low_x <= high_x && print.high_x >= low_x && print.low_y <= high_y &&
               print.high_y >= low_y;
    };
    block.prints.clear();
    const std::uint32_t x0 = bin(low_x, mask.bins_low_x, mask.bins_scale_x),
                        x1 = bin(high_x, mask.bins_low_x, mask.bins_scale_x),
                        y0 = bin(low_y, mask.bins_low_y, mask.bins_scale_y),
                        y1 = bin(high_y, mask.bins_low_y, mask.bins_scale_y);
    std::size_t entries = 0;   // of these bins, which have a print each for every bin that it may meet
    for (std::uint32_t y = y0; y <= y1; ++y)
        entries += mask.bin_begin[y * k_bins + x1 + 1] - mask.bin_begin[y * k_bins + x0];
    if (entries < mask.prints.size()) {
        for (std::uint32_t y = y0; y <= y1; ++y)
            for (std::uint32_t i = mask.bin_begin[y * k_bins + x0]; i < mask.bin_begin[y * k_bins + x1 + 1]; ++i)
                if (meets(mask.prints[mask.binned[i]])) block.prints.push_back(mask.binned[i]);
        std::sort(block.prints.begin(), block.prints.end());
        block.prints.erase(std::unique(block.prints.begin(), block.prints.end()), block.prints.end());
    } else {
        for (std::uint32_t p = 0; p < mask.prints.size(); ++p)
            if (meets(mask.prints[p])) block.prints.push_back(p);
    }
    block.empty = block.prints.empty();
    block.edges = 0;
    for (const std::uint32_t p : block.prints)
        block.edges += static_cast<std::uint32_t>(units_[mask.prints[p].unit]->shape->edge.size());
}

// LONG: one pass over a block's prints that fills rows of bits; they stay in registers and on the stack, and each step
// needs most of them.
void DynamicMask::draw(LightMask& mask, Block& block)
{
    const auto [low_x, high_x, low_y, high_y, texels] = place_of(block.key);
    MaskTexels& texels_over = block.texels;
    texels_over.texel.fill(0);
    texels_over.begins.assign(1, k_infinity);
    texels_over.ends.assign(1, k_infinity);
    block.print_of.assign(1, scene::none);
    if (block.empty) return;
    for (const std::uint32_t p : block.prints)
        std::call_once(mask.outlined[p], [&] { find_outline(mask, mask.prints[p]); });
    std::sort(block.prints.begin(), block.prints.end(), [&](std::uint32_t a, std::uint32_t b) {
        return mask.prints[a].begins != mask.prints[b].begins ? mask.prints[a].begins < mask.prints[b].begins : a < b;
    });

    std::array<std::uint32_t, k_block_side> has_full{}, has_first{}, has_next{};
    for (const std::uint32_t p : block.prints) {
        const Print& print = mask.prints[p];
        const auto number = static_cast<std::uint32_t>(block.print_of.size());
        texels_over.begins.push_back(print.begins);
        texels_over.ends.push_back(print.ends);
        block.print_of.push_back(p);
        if (number == MaskTexels::k_numbers - 1) {
            // There are too many: all others begin at this depth or later, anywhere.
            for (std::uint32_t row = 0; row < k_block_side; ++row) {
                std::uint32_t* const at = &texels_over.texel[row * k_block_side];
                or_bits(at, ~has_next[row], number << 8);
                or_bits(at, ~has_first[row], number);
            }
            break;
        }
        // Skip a print that begins behind everything relevant.
        std::uint32_t settled = 0xffffffffu;
        for (std::uint32_t row = 0; row < k_block_side; ++row)
            settled &= has_full[row] & has_first[row] & has_next[row];
        if (settled == 0xffffffffu) break;
        std::array<std::uint32_t, k_block_side> open{}, steps{};   // the outline passes; layers begin or end
        std::array<std::array<std::int16_t, k_block_side>, k_block_side> step;
        if (print.blind || print.masked) open.fill(0xffffffffu);

        for (const Piece& piece : mask.outlines[p]) {
            // Transform to texels of the block; orient the piece upward.
            float ax = (piece.ax - low_x) * texels, ay = (piece.ay - low_y) * texels;
            float bx = (piece.bx - low_x) * texels, by = (piece.by - low_y) * texels;
            auto layers = static_cast<std::int16_t>(piece.layers);
            const float widen = piece.widen * texels + k_texel_slack;
            if (ay > by) std::swap(ax, bx), std::swap(ay, by), layers = static_cast<std::int16_t>(-layers);
            if (by + widen < 0 || ay - widen >= k_side || std::min(ax, bx) - widen >= k_side) continue;
            const float least = std::min(ax, bx) - widen, most = std::max(ax, bx) + widen;
            const bool level_line = !(by - ay > 1e-6f);
            const float slope = level_line ? 0 : (bx - ax) / (by - ay);
            // Mark the texels of each row that it may pass: between its positions at the row's borders, widened.
            const float reach = widen * (1 + std::abs(slope));
            const int first = texel_within(std::floor(ay - widen), 0, k_side);
            const int last = texel_within(std::floor(by + widen), -1, k_side - 1);
            float here = ax + (static_cast<float>(first) - ay) * slope;
            for (int row = first; row <= last; ++row) {
                const float there = ax + (static_cast<float>(row + 1) - ay) * slope;
                const float left = level_line ? least : std::max(least, std::min(here, there) - reach);
                const float right = level_line ? most : std::min(most, std::max(here, there) + reach);
                here = there;
                if (!(left < k_side && right >= 0)) continue;
                const auto l = static_cast<std::uint32_t>(std::max(left, 0.0f));
                const auto h = static_cast<std::uint32_t>(std::min(right, k_side - 0.5f));
                open[static_cast<std::size_t>(row)] |= (0xffffffffu << l) & (0xffffffffu >> (k_block_side - 1 - h));
            }
            if (layers == 0) continue;

            // Layers change where it crosses the centre of a row.
            const int first_middle = texel_within(std::ceil(ay - 0.5f), 0, k_side);
            const int end_middle = texel_within(std::ceil(by - 0.5f), 0, k_side);
            for (int row = first_middle; row < end_middle; ++row) {
                const float cross = ax + (static_cast<float>(row) + 0.5f - ay) * slope;
                if (!(cross <= k_side - 0.5f)) continue;
                const auto r = static_cast<std::size_t>(row);
                const auto c = static_cast<std::size_t>(std::max(0.0f, std::ceil(cross - 0.5f)));
                if (!(steps[r] >> c & 1)) step[r][c] = 0, steps[r] |= 1u << c;
                step[r][c] = static_cast<std::int16_t>(step[r][c] + layers);
            }
        }

        const bool opaque = !print.blind && !print.masked;
        for (std::uint32_t row = 0; row < k_block_side; ++row) {
            // Add the layers up along the row.
            std::uint32_t covered = 0, torn = 0;
            int sum = 0;
            for (std::uint32_t rest = steps[row]; rest != 0; rest &= rest - 1) {
                const auto c = static_cast<std::uint32_t>(__builtin_ctz(rest));
                sum += step[row][c];
                const std::uint32_t from_here = 0xffffffffu << c;
                covered = sum > 0 ? covered | from_here : covered & ~from_here;
                torn = sum < 0 ? torn | from_here : torn & ~from_here;
            }
            const std::uint32_t some = open[row] | covered | torn;
            if ((some & ~(has_full[row] & has_next[row])) == 0) continue;
            std::uint32_t* const at = &texels_over.texel[row * k_block_side];
            // The first object that covers a texel usually also ends first; later ones are not tested.
            if (opaque) {
                const std::uint32_t full = covered & ~(open[row] | torn | has_full[row]);
                or_bits(at, full, number << 16);
                has_full[row] |= full;
            }
            or_bits(at, some & has_first[row] & ~has_next[row], number << 8);
            or_bits(at, some & ~has_first[row], number);
            has_next[row] |= some & has_first[row];
            has_first[row] |= some;
        }
    }
}

// Computed once per block, and kept while the light rests.
float DynamicMask::static_begins(LightMask& mask, Block& block) const
{
    const float known = block.static_begins.load(std::memory_order_relaxed);
    if (!std::isnan(known)) return known;
    {
        const std::scoped_lock lock(mask.mutex);
        const auto found = mask.static_begins.find(block.key);
        if (found != mask.static_begins.end()) {
            block.static_begins.store(found->second, std::memory_order_relaxed);
            return found->second;
        }
    }
    const std::uint32_t face = face_of(block.key);
    const double blocks = std::ldexp(1.0, static_cast<int>(level_of(block.key) - k_block_bits));
    const double low[2] = {x_of(block.key) / blocks, y_of(block.key) / blocks};
    std::array<visibility::Plane, 4> sides;
    for (std::size_t k = 0; k < 4; ++k) {
        const int axis = static_cast<int>(k / 2);
        const double at = low[axis] + (k & 1 ? 1 / blocks : 0.0), sign = k & 1 ? -1 : 1;
        sides[k] = mask.space.in_world(face, mask.space.side(axis, at, sign, mask.static_margin));
    }
    visibility::Plane depth;
    depth.normal = {0, 0, 1};
    const double least = triangles_.least_height(sides, mask.space.in_world(face, depth));
    const float begins = std::nextafter(static_cast<float>(least - mask.static_between), -k_infinity);
    const std::scoped_lock lock(mask.mutex);
    mask.static_begins.emplace(block.key, begins);
    block.static_begins.store(begins, std::memory_order_relaxed);
    return begins;
}

}   // namespace gnomon::shadow_culling
