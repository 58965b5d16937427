// SPDX-License-Identifier: Apache-2.0
#include "light_views/atlas.h"

#include <bit>
#include <numeric>

#include "base/check.h"

namespace gnomon::light_views {

namespace {

// Extracts every second bit of a number: x or y of the n-th square along a Z-order curve.
int compact_bits(std::uint64_t n)
{
    int result = 0;
    for (int bit = 0; n >> (2 * bit) != 0; ++bit) result |= static_cast<int>((n >> (2 * bit)) & 1u) << bit;
    return result;
}

}   // namespace

std::int64_t Atlas::texels() const
{
    std::int64_t sum = 0;
    for (const Tile& tile : tiles) sum += tile.rect().area();
    return sum;
}

Atlas make_atlas(std::span<const int> views, const AtlasOptions& options)
{
    GNOMON_CHECK(std::has_single_bit(static_cast<unsigned>(options.view_size)));
    GNOMON_CHECK(std::has_single_bit(static_cast<unsigned>(options.least_size)));

    // Choose sizes: start with the requested one, then halve from the last light to the first, round by round, until
    // all fit.
    std::vector<int> size(views.size());
    std::int64_t texels = 0;
    const auto cost = [&](std::size_t l) { return static_cast<std::int64_t>(size[l]) * size[l] * views[l]; };
    for (std::size_t l = 0; l < views.size(); ++l) {
        size[l] = std::max(views[l] > 2 ? options.view_size / 2 : options.view_size, options.least_size);
        texels += cost(l);
    }
    while (texels > options.budget_texels) {
        bool halved = false;
        const int largest = size.empty() ? 0 : *std::max_element(size.begin(), size.end());
        for (std::size_t l = views.size(); l-- > 0 && texels > options.budget_texels;) {
            if (size[l] < largest || size[l] <= options.least_size) continue;
            texels -= cost(l);
            size[l] /= 2;
            texels += cost(l);
            halved = true;
        }
        if (!halved)
            throw MissingError(fmt::format("{} lights do not fit into the shadow atlas of {} texels", views.size(),
                                           options.budget_texels));
    }

    Atlas atlas;
    atlas.first_tile.push_back(0);
    for (std::size_t l = 0; l < views.size(); ++l) {
        for (int v = 0; v < views[l]; ++v) atlas.tiles.push_back({0, 0, 0, size[l]});
        atlas.first_tile.push_back(static_cast<std::uint32_t>(atlas.tiles.size()));
    }
    if (atlas.tiles.empty()) return atlas;

    // Place squares along a Z-order curve, largest first: every square is aligned, without gaps between them.
    std::vector<std::uint32_t> order(atlas.tiles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return atlas.tiles[a].size > atlas.tiles[b].size; });
    atlas.page_size = atlas.tiles[order.front()].size;
    const std::uint64_t page_texels =
        static_cast<std::uint64_t>(atlas.page_size) * static_cast<unsigned>(atlas.page_size);
    std::uint64_t at = 0;   // in texels along the curve
    for (const std::uint32_t t : order) {
        Tile& tile = atlas.tiles[t];
        const auto size_texels = static_cast<std::uint64_t>(tile.size) * static_cast<unsigned>(tile.size);
        const std::uint64_t square = at % page_texels / size_texels;
        tile.page = static_cast<int>(at / page_texels);
        tile.x = compact_bits(square) * tile.size;
        tile.y = compact_bits(square >> 1) * tile.size;
        at += size_texels;
    }
    atlas.pages = static_cast<int>((at + page_texels - 1) / page_texels);
    return atlas;
}

}   // namespace gnomon::light_views
