// SPDX-License-Identifier: Apache-2.0
#pragma once
// Samples directions towards the bright parts of an environment image, for the path-traced reference.
//
// The density is constant over each cell of a grid that is no finer than the image, in proportion to the cell's mean
// luminance. It may be 0 where interpolated texels are not black; so it is to be combined with cosine sampling, which
// reaches every direction, by the balance heuristic [Veach and Guibas 1995].
//
// Cost: one pass over the image; a sample is two binary searches.

#include <vector>

#include "scene/environment.h"

namespace gnomon::reference {

class EnvironmentSampler {
 public:
    explicit EnvironmentSampler(const scene::Environment& environment);

    /// True for a black image, which has no directions to sample.
    bool empty() const { return rows_.empty() || !(total_ > 0); }
    /// u, v in [0, 1). Not when empty(). @return unit direction; `density` per steradian, above 0
    glm::vec3 sample(float u, float v, float& density) const;
    /// The density per steradian with which sample() returns this unit direction.
    float density(const glm::vec3& direction) const;

 private:
    float cell_density(int x, int y) const;

    int width_ = 0, height_ = 0;
    std::vector<double> rows_;    // sums up to and with each row
    std::vector<double> cells_;   // sums along each row, up to and with each cell
    double total_ = 0;
};

}   // namespace gnomon::reference
