// SPDX-License-Identifier: Apache-2.0
#pragma once
// The directions of the middles of the cells of an even grid over an image of an environment: bit for bit those of
// Environment::direction_at(), with two sines and cosines for each column and row instead of each cell.

#include <cmath>
#include <vector>

#include "base/image.h"
#include "base/math.h"

namespace gnomon::scene {

/// Environment::radiance() of an image by angles.
/// @param longitude  atan2(x, -z). @param v  from the top, 0 to 1: acos(y) / pi
glm::vec3 radiance_at(const ImageF& image, float longitude, float v);

class DirectionGrid {
 public:
    DirectionGrid(int columns, int rows);
    glm::vec3 at(int column, int row) const
    {
        const Column& along = columns_[static_cast<std::size_t>(column)];
        const glm::dvec2& down = rows_[static_cast<std::size_t>(row)];
        return glm::vec3(glm::dvec3(down.x * along.sine, down.y, -down.x * along.cosine));
    }
    /// atan2(x, -z) of the direction d at a cell, bit for bit. It differs from the column's longitude because d is
    /// rounded.
    float longitude(int column, int row, const glm::vec3& d) const
    {
        constexpr double k_error = 1e-12;   // of this angle and of atan2's, many times over
        const Column& along = columns_[static_cast<std::size_t>(column)];
        const double x = static_cast<double>(d.x), z = static_cast<double>(-d.z);
        const double angle =
            along.longitude + (x * along.cosine - z * along.sine) / rows_[static_cast<std::size_t>(row)].x;
        const auto low = static_cast<float>(angle - k_error), high = static_cast<float>(angle + k_error);
        return low == high ? low : std::atan2(d.x, -d.z);
    }

 private:
    struct Column {
        double longitude, sine, cosine;
    };
    std::vector<Column> columns_;
    std::vector<glm::dvec2> rows_;   // sine and cosine of polar angles
};

}   // namespace gnomon::scene
