// SPDX-License-Identifier: Apache-2.0
#pragma once
// An octree whose leaves are about as wide as patches should be: small where surfaces face many ways, wide on plains.
//
// The cube whose surfaces matter most is divided next, until there are as many cells (leaves by the direction that
// surfaces face) as asked for. A cube matters by its width squared, times the square of how many of its six directions
// are filled, times the mean weight of its surfaces. The ground around a courtyard therefore has patches several times
// as wide as the courtyard.
//
// Cost: the surfaces, times the depth of the tree.

#include <cstdint>
#include <span>
#include <vector>

#include "base/math.h"

namespace gnomon::patches {

/// The axis that a normal faces most, and its sign: 0 to 5.
int facing_of(const glm::vec3& normal);

/// A piece of surface.
struct DetailSample {
    glm::vec3 position{0};
    float area = 0;
    float weight = 1;   // how much it matters, 0 to 1
    std::int8_t facing = 0;
};

class DetailCells {
 public:
    /// @param cells  aimed at
    DetailCells(std::span<const DetailSample> samples, std::size_t cells);

    struct Cube {
        std::uint32_t number = 0;
        float width = 0;
    };
    /// The leaf that contains a point.
    Cube cube_at(const glm::vec3& position) const;

 private:
    struct Node {
        glm::vec3 low{0};
        float width = 0;
        std::uint32_t children = 0;   // the first of eight; 0: a leaf
    };
    static int child_of(const Node& node, const glm::vec3& position);
    std::vector<Node> nodes_;
};

}   // namespace gnomon::patches
