// SPDX-License-Identifier: Apache-2.0
#pragma once
// Sums over the cells of directions at one point, in the widest vectors that the machine has.
//
// Terms are added by eight lanes, whatever the width of vectors, or are whole numbers, and no multiplication is fused
// with an addition: every instruction set gives the same bits.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/math.h"

namespace gnomon::environment_light {

inline constexpr std::size_t k_sum_lanes = 8;
using LaneSums = std::array<float, k_sum_lanes>;

/// Lists by leaf, padded with zeros to whole words of masks; by axis or colour where there are three.
struct CellLists {
    std::array<const float*, 3> mean, flux;
    const float* angle = nullptr;
};

/// Lists by leaf, padded likewise: mean directions by axis, flux by colour in units, and solid angles in units. The sum
/// of each list's units is below 2^30.
struct UnitLists {
    std::array<const float*, 3> mean, flux;
    const float* angle = nullptr;
};

struct CosineSums {
    std::array<std::int64_t, 3> flux{};   // cosine times flux, by colour, in units
    std::int64_t angle = 0;               // cosine times solid angle
};

/// Sums over cells that are above a surface. Each term is rounded to whole units.
/// @param mask  a bit for each leaf that counts. @param exists  likewise. @param flip  all bits: those not in the mask
CosineSums cosine_sums(const glm::vec3& normal, const UnitLists& cells, std::span<const std::uint64_t> mask,
                       std::span<const std::uint64_t> exists, std::uint64_t flip);

/// A lobe as CellLight::seen_by() weights cells by it.
struct WeightedLobe {
    glm::vec3 to_viewer{0}, normal{0}, horizon{0};   // see Lobe
    float a2 = 1;                                    // the fourth power of the roughness
    float n_v = 1;                                   // cosine of the view, above 0
    float masking = 1;                               // of the viewer's direction
    float f0 = 1, f90 = 1;                           // see Lobe
};

struct LobeSums {
    std::array<LaneSums, 3> all{}, visible{};   // weight times flux
    LaneSums angles{}, visible_angles{};        // weight times solid angle
};

/// The weight of one direction: the distribution of normals times masking and shadowing of the microfacets [Heitz 2014,
/// equation 99] times their reflectance [Schlick 1994], without constant factors; 0 below a horizon.
float lobe_weight(const WeightedLobe& lobe, const glm::vec3& direction);

/// Sums over all cells above both horizons, and over those that are seen.
/// @param seen  a bit for each leaf
LobeSums lobe_sums(const WeightedLobe& lobe, const CellLists& cells, std::span<const std::uint64_t> seen);

}   // namespace gnomon::environment_light
