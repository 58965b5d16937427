// SPDX-License-Identifier: Apache-2.0
#pragma once
// Which of up to a thousand places that face the same way as a point is the nearest to it: looked at four at once.

#include <array>
#include <cstdint>
#include <vector>

#include "base/math.h"

namespace gnomon::patches {

class FacingPlaces {
 public:
    static constexpr float k_same_facing = 0.5f;   // cosine between normals that face the same way

    void clear();
    void push(const glm::vec3& place, const glm::vec3& normal);
    /// The least square of a distance to a point among the places from `first` to `last`, which is excluded, that face
    /// the same way; infinite if there are none.
    float least(std::uint32_t first, std::uint32_t last, const glm::vec3& p, const glm::vec3& normal) const;
    /// The first of them that is so near; `last` if there is none.
    /// @param square  as least() returns it
    std::uint32_t next(std::uint32_t first, std::uint32_t last, const glm::vec3& p, const glm::vec3& normal,
                       float square) const;

 private:
    struct Squares;
    std::array<std::vector<float>, 6> at_;   // positions and normals, by axis
};

}   // namespace gnomon::patches
