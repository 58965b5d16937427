// SPDX-License-Identifier: Apache-2.0
#pragma once
// Directions within cells (direction_cells.h): each cell has 64 equal parts with a direction each.
//
// Parts are numbered by quarters: the first two bits of a number are the quarter, the next two the quarter of that, the
// last two the part. The direction of a part is jittered within it, and the same for every point. A few parts can
// represent all: k_of_quarter has one for each quarter, and k_of_sixteenth, which contains these, one for each
// sixteenth.
//
// Cost: 768 bytes for each cell.

#include <array>
#include <cstdint>
#include <vector>

#include "environment_light/direction_cells.h"

namespace gnomon::environment_light {

inline constexpr std::uint32_t k_parts = 64;

namespace parts {

constexpr std::uint64_t of_sixteenths()
{
    constexpr std::array<std::uint32_t, 4> k_part = {2, 0, 3, 1};
    std::uint64_t mask = 0;
    for (std::uint32_t sixteenth = 0; sixteenth < 16; ++sixteenth)
        mask |= std::uint64_t{1} << (4 * sixteenth + k_part[(sixteenth / 4 + sixteenth) % 4]);
    return mask;
}

constexpr std::uint64_t of_quarters()
{
    std::uint64_t mask = 0;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter)   // a sixteenth of each
        mask |= of_sixteenths() & (std::uint64_t{0xf} << (16 * quarter + 4 * ((quarter + 1) % 4)));
    return mask;
}

inline constexpr std::uint64_t k_of_sixteenth = of_sixteenths(), k_of_quarter = of_quarters();

}   // namespace parts

class PartDirections {
 public:
    /// @param cells  of an image
    explicit PartDirections(const DirectionCells& cells);
    /// Unit.
    const glm::vec3& direction(std::size_t leaf, std::uint32_t part) const
    {
        return directions_[k_parts * leaf + part];
    }
    /// Parts of a leaf whose direction is above a plane, as a mask.
    /// @param normal  unit
    /// @param least   sine above it
    std::uint64_t above(std::size_t leaf, const glm::vec3& normal, float least) const;

 private:
    std::vector<glm::vec3> directions_;
};

}   // namespace gnomon::environment_light
