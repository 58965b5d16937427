// SPDX-License-Identifier: Apache-2.0
#pragma once
// The light that arrives at patches from beyond the scene: a sky without its sun, which is a light of its own, or an
// environment image.
//
// An image is averaged over cells about as wide as the directions in which a patch looks are apart, so that a small sun
// in it neither falls between two of them nor counts whole in one. The brightest cells, such as that of a sun, are
// bright spots: patches look for each of them.
//
// Cost: one look at each texel of the image, and some milliseconds.

#include <span>
#include <vector>

#include "base/direction_table.h"
#include "scene/light.h"

namespace gnomon::patches {

class Surroundings {
 public:
    explicit Surroundings(const scene::Background& background);
    /// Whether a background may light patches. One of one colour is seen, and lights nothing.
    static bool may_light(const scene::Background& background)
    {
        return background.kind != scene::Background::Kind::color;
    }
    /// Whether any light comes from beyond the scene.
    bool any() const { return any_; }
    /// Whether they are a sky, whose light pixels get as indirect light.
    bool is_sky() const { return background_.kind == scene::Background::Kind::sky; }
    /// From a unit direction.
    glm::vec3 radiance(const glm::vec3& direction) const;

    /// A part of an image that is far brighter than the rest of it.
    struct Spot {
        glm::vec3 direction{0};    // unit
        glm::vec3 irradiance{0};   // on a surface that faces it
    };
    static constexpr std::size_t k_most_spots = 8;
    std::span<const Spot> spots() const { return spots_; }
    /// The same as radiance(), without the spots.
    glm::vec3 radiance_beside_spots(const glm::vec3& direction) const;
    /// Irradiance that this is on a surface that nothing hides from it, by its unit normal; within 1 %.
    glm::vec3 irradiance_beside_spots(const glm::vec3& normal) const { return irradiance_.at(normal); }

 private:
    void find_spots(std::span<const glm::vec3> direction);
    void find_irradiance();

    scene::Background background_;
    bool any_ = false;
    std::vector<glm::vec3> cells_;          // of an image: means, row by row
    std::vector<glm::vec3> beside_spots_;   // the same, 0 in spots
    std::vector<Spot> spots_;               // brightest first
    DirectionTable irradiance_;             // by normal, without spots
};

}   // namespace gnomon::patches
