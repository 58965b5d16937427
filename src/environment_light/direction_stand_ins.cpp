// SPDX-License-Identifier: Apache-2.0
// The leaves of direction cells that stand in for others where a coarse or a rough answer will do.
#include "environment_light/direction_cells.h"

namespace gnomon::environment_light {

// Chooses the leaf that stands in for each leaf of a family: its scout, or the leaf next to the middle of the leaf's
// own quarter where these were divided further.
void DirectionCells::add_stand_ins(const DirectionNode& family, std::uint32_t scout, bool divided_once)
{
    const auto set = [&](const DirectionNode& node, std::uint32_t stand_in) {
        for (std::uint32_t leaf = node.first_leaf; leaf < node.first_leaf + node.leaves; ++leaf)
            stand_in_of_[leaf] = static_cast<std::uint16_t>(stand_in);
        stand_ins_[stand_in / 64] |= std::uint64_t{1} << (stand_in % 64);
        stood_for_.push_back({node.first_leaf, node.leaves, stand_in});
    };
    if (divided_once) return set(family, scout);
    for (std::uint32_t q = 0; q < family.count; ++q) {
        const DirectionNode& quarter = nodes_[family.children + q];
        set(quarter, middle_of(quarter));
    }
}

// Lets rows of families have one leaf to stand in for all, as long as they bring little light together and are few.
void DirectionCells::add_few_stand_ins()
{
    constexpr float k_light = 1 / 32.0f, k_most_light = 1 / 12.0f, k_angle = static_cast<float>(4 * k_pi / 60);
    const float all = luminance(total_);
    StoodFor row;
    float light = 0, angle = 0;
    const auto brightest = [&](std::uint32_t first, std::uint32_t leaves) {
        std::uint32_t most = first;
        for (std::uint32_t leaf = first; leaf < first + leaves; ++leaf)
            if (luminance(fluxes_[leaf]) > luminance(fluxes_[most])) most = leaf;
        return most;
    };
    const auto end_row = [&] {
        if (row.leaves > 0) few_stood_for_.push_back({row.first, row.leaves, brightest(row.first, row.leaves)});
        row = {}, light = angle = 0;
    };
    for (std::size_t f = 0; f < families_.size(); ++f) {
        const CellFamily& family = families_[f];
        float own_light = 0, own_angle = 0;
        for (std::uint32_t leaf = family.first; leaf < family.first + family.leaves; ++leaf)
            own_light += luminance(fluxes_[leaf]), own_angle += angles_[leaf];
        if (row.leaves > 0 && (light + own_light > k_light * all || angle + own_angle > k_angle)) end_row();
        if (own_light > k_most_light * all) {
            // As where a coarse answer will do.
            for (const StoodFor& cells : stood_for_)
                if (cells.first >= family.first && cells.first < family.first + family.leaves)
                    few_stood_for_.push_back(cells);
            continue;
        }
        if (row.leaves == 0) row.first = family.first;
        row.leaves += family.leaves;
        light += own_light, angle += own_angle;
    }
    end_row();
}

}   // namespace gnomon::environment_light
