// SPDX-License-Identifier: Apache-2.0
#pragma once
// Cells between the two horizons of a point on a smooth mesh: above the one that vertex normals give, below that of the
// triangle. No ray of the point decides them, because the triangle blocks it. They are taken to be visible where their
// mirror image in the triangle's plane is: such cells are next to the horizon on both sides of it, and what stands
// around covers both, or neither. Without them, the light of an environment would change at every edge of a mesh.
//
// Cost: a table that is made when first asked for (some 5 ms); per point some 200 ns, and 5 ns for each such cell.

#include <array>
#include <span>
#include <vector>

#include "environment_light/direction_cells.h"

namespace gnomon::environment_light {

class MirroredCells {
 public:
    /// @param cells  kept by reference
    explicit MirroredCells(const DirectionCells& cells);

    /// Adds the visible cells between the horizons of a point.
    /// @param geometric, smooth  the horizons' normals; unit
    /// @param seen  a bit for each leaf: those above the triangle's horizon are decided
    void add(const glm::vec3& geometric, const glm::vec3& smooth, std::span<std::uint64_t> seen) const;

 private:
    std::size_t leaf_near(const glm::vec3& direction) const;

    const DirectionCells& cells_;
    std::array<std::vector<float>, 3> mean_;   // by axis, padded to whole words
    std::vector<std::uint16_t> leaf_of_;       // by entry of a table over directions
};

}   // namespace gnomon::environment_light
