// SPDX-License-Identifier: Apache-2.0
#pragma once
// Moves an image to where another camera shows what it shows, until an image of that camera is there.
//
// A place of the moved image is searched for in the image by iteration: from the place found so far, what is seen there
// is moved with the camera, and what it misses the place by is the next step [Bowles et al. 2012]. No place stays
// empty: where the image lacks what comes into view, the surface beside it is stretched.
//
// Cost: about 30 ns for each pixel.

#include <optional>
#include <span>
#include <vector>

#include "base/image.h"
#include "base/math.h"
#include "gnomon/scene_parts.h"

namespace gnomon::viewer {

class Reprojection {
 public:
    /// None where a camera is orthographic.
    /// @param size  of the images that both cameras make, in any unit
    static std::optional<Reprojection> between(const Camera& from, const Camera& to, const glm::vec2& size);

    /// Where the other camera shows what lies at a place; both in fractions of the image's width and height from its
    /// top left. None behind that camera.
    /// @param nearness  1 divided by its depth along the first camera's axis; 0: infinitely far
    std::optional<glm::vec2> moved(const glm::vec2& place, float nearness) const;

    /// @param image     of three channels, of the first camera
    /// @param nearness  by pixel, row by row
    Image8 moved(const Image8& image, const std::vector<float>& nearness) const;

 private:
    struct Nearness;
    struct Start;
    std::vector<Start> starts(const Image8& image, const std::vector<float>& nearness) const;
    glm::vec2 found(const glm::vec2& place, std::span<const Start> starts, const Nearness& nearness) const;

    // From a place and its nearness to the other place, times its depth in units of the first depth.
    glm::mat3 turn_{1};
    glm::vec3 step_{0};
};

}   // namespace gnomon::viewer
