// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "base/math.h"

namespace gnomon {

/// A function of the direction, as a table over the vertices of a square that folds to an octahedron
/// [Cigolle et al. 2014]: continuous, and bilinear between them.
class DirectionTable {
 public:
    DirectionTable() = default;
    explicit DirectionTable(int side);
    int side() const { return side_; }
    std::size_t size() const { return values_.size(); }
    /// The unit direction of an entry.
    glm::vec3 direction(std::size_t entry) const;
    glm::vec3& operator[](std::size_t entry) { return values_[entry]; }
    /// @param direction  unit
    glm::vec3 at(const glm::vec3& direction) const;

 private:
    int side_ = 0;   // squares along a side
    std::vector<glm::vec3> values_;
};

}   // namespace gnomon
