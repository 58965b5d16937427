// SPDX-License-Identifier: Apache-2.0
#pragma once
// Where the detail of a scene is, for patches to be there.
//
// Files of single objects stand on a ground that has a hundred times their area and is a few triangles. What a patch of
// the ground gives the objects is the solid angle under which they see it: from a height of their own size L, at a
// distance D, in proportion to L/D^3. Patches of equal weight are therefore larger by the square root of (D/L)^3 there.
//
// A ground is what the library has added, and a plane that has more than half of the area of all else. Where there is
// none, as in rooms, everything has the weight 1.

#include <cstddef>
#include <functional>

#include "base/math.h"
#include "scene/state.h"

namespace gnomon::patches {

/// A flat piece of surface.
struct FlatPiece {
    glm::vec3 corners[3];
    float area = 0;       // 0: it does not count
    bool added = false;   // by the library
};

class DetailRegion {
 public:
    DetailRegion() = default;   // the weight is 1 everywhere
    /// Cost: two passes over the pieces, and one more for each plane that is a ground; and the dynamic objects.
    /// @param piece  by number below `count`: of static surfaces
    DetailRegion(const scene::SceneState& state, std::size_t count, const std::function<FlatPiece(std::size_t)>& piece);

    /// Half the diagonal of the region; infinite where the weight is 1 everywhere.
    float size() const { return size_; }
    /// 0 inside the region.
    float distance(const glm::vec3& point) const;
    /// How much a surface matters, 0 to 1; 1 up to size() away from the region.
    float weight(const glm::vec3& point) const;
    /// Whether the weight is 1 on all of a triangle.
    bool holds(const glm::vec3 (&corners)[3]) const;

 private:
    Box3 box_;
    float size_ = k_infinity;
};

}   // namespace gnomon::patches
