// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light by sampling the light map around each receiver's projection in it [Dachsbacher and Stamminger 2005,
// 4.2], for comparison with [Ki and Oh 2007]. Kernel, vector width and units are those of gather.h.
//
// Samples lie on a disk around the receiver's projection. All receivers use the same pattern, which is denser in the
// middle; a sample's weight is the number of texels that it represents.
//
// DEVIATION(Dachsbacher 2005, 4.2): a sample's weight is the inverse of the pattern's density, xi_1, where the paper
// prints xi_1^2, which does not sum to the light of the disk. A sample's kernel is that of the area that it represents.
// DEVIATION(Dachsbacher 2005, 4.2): Hammersley points instead of Poisson's. Several views divide the samples among
// them. Cost: a gather of ten numbers per sample and receiver, then as in gather.h.

#include "light_quadtree/gather.h"

namespace gnomon::light_quadtree {

struct RsmOptions {
    int samples = 256;     // of all views together
    float radius = 0.3f;   // of the disk, in sides of the map, as published
};

struct RsmPattern {
    std::vector<float> x, y;     // offset, in texels
    std::vector<float> weight;   // number of texels that the sample represents
};
RsmPattern make_rsm_pattern(int samples, float radius, int side);

/// Scratch: the receivers' projections in a view, in texels.
struct RsmPlaces {
    std::vector<float> x, y;
};

/// Computes irradiance at receivers [begin, end), like gather().
void sample_map(const LightMap& map, const RsmOptions& options, Receivers& receivers, std::size_t begin,
                std::size_t end, RsmPlaces& scratch);
/// Reference implementation for one receiver, without SIMD.
glm::vec3 sample_map_one(const LightMap& map, const RsmOptions& options, const glm::vec3& position,
                         const glm::vec3& normal);

}   // namespace gnomon::light_quadtree
