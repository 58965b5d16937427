// SPDX-License-Identifier: Apache-2.0
#pragma once
// Directions towards the bright parts of an image of the surroundings, for the reference's light from there.
//
// The density is constant over each cell of a grid that is no finer than the image, in proportion to the cell's mean
// luminance. It may be 0 where a blend of texels still is not black; so it is for use beside cosine sampling, weighted
// by the balance heuristic [Veach and Guibas 1995], which reaches every direction.
//
// Cost: one pass over the image; a sample is two binary searches.

#include <vector>

#include "scene/environment.h"

namespace gnomon::reference {

class EnvironmentSampler {
 public:
    explicit EnvironmentSampler(const scene::Environment& environment);

    /// A black image has no directions.
    bool empty() const { return rows_.empty() || !(total_ > 0); }
    /// u, v in [0, 1). Not for an empty one. @return unit; `density` per steradian, above 0
    glm::vec3 sample(float u, float v, float& density) const;
    /// Per steradian, of sample() returning this unit direction.
    float density(const glm::vec3& direction) const;

 private:
    float cell_density(int x, int y) const;

    int width_ = 0, height_ = 0;
    std::vector<double> rows_;    // sums up to and with each row
    std::vector<double> cells_;   // sums along each row, up to and with each cell
    double total_ = 0;
};

}   // namespace gnomon::reference
