// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light that arrives at patches from beyond the scene: a sky without its sun, which is a light of its own, or an
// environment image.
//
// An image is averaged over cells about as wide as the directions in which a patch looks are apart, so that a small sun
// in it neither falls between two of them nor counts whole in one.

#include <vector>

#include "scene/light.h"

namespace gnomon::patches {

class Surroundings {
 public:
    explicit Surroundings(const scene::Background& background);
    /// Whether any light comes from beyond the scene. A background of one colour is seen, and lights nothing.
    bool any() const { return any_; }
    /// From a unit direction.
    glm::vec3 radiance(const glm::vec3& direction) const;

 private:
    scene::Background background_;
    bool any_ = false;
    std::vector<glm::vec3> cells_;   // of an image: means, row by row
};

}   // namespace gnomon::patches
