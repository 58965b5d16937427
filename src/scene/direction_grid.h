// SPDX-License-Identifier: Apache-2.0
#pragma once
// The directions of the middles of the cells of an even grid over an image of an environment: bit for bit those of
// Environment::direction_at(), with two sines and cosines for each column and row instead of each cell.

#include <vector>

#include "base/math.h"

namespace gnomon::scene {

class DirectionGrid {
 public:
    DirectionGrid(int columns, int rows);
    glm::vec3 at(int column, int row) const
    {
        const glm::dvec2& along = columns_[static_cast<std::size_t>(column)];
        const glm::dvec2& down = rows_[static_cast<std::size_t>(row)];
        return glm::vec3(glm::dvec3(down.x * along.x, down.y, -down.x * along.y));
    }

 private:
    std::vector<glm::dvec2> columns_, rows_;   // sine and cosine of longitudes, and of polar angles
};

}   // namespace gnomon::scene
