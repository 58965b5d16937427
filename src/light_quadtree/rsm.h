// SPDX-License-Identifier: Apache-2.0
#pragma once
// Indirect light by sampling the light map around each receiver's own place in it [Dachsbacher and Stamminger 2005,
// 4.2]: what [Ki and Oh 2007] is compared with. Kernel, vector width and units are the gather's (gather.h).
//
// Samples lie on a disk about the place where the light sees the receiver, one pattern for all receivers, denser in the
// middle; each stands for as many texels as its place in the pattern is thin.
//
// DEVIATION(Dachsbacher 2005, 4.2): a sample's weight is the inverse of the pattern's density there, xi_1, where the
// paper prints xi_1^2, which does not sum to the light of the disk. A sample's kernel is that of the area it stands
// for. DEVIATION(Dachsbacher 2005, 4.2): Hammersley points for Poisson's. Several views share the samples. Cost: a
// gather of ten numbers a sample and receiver, then as gather.h.

#include "light_quadtree/gather.h"

namespace gnomon::light_quadtree {

struct RsmOptions {
    int samples = 256;     // of all views together
    float radius = 0.3f;   // of the disk, in sides of the map, as published
};

struct RsmPattern {
    std::vector<float> x, y;     // offset, in texels
    std::vector<float> weight;   // texels that the sample stands for
};
RsmPattern make_rsm_pattern(int samples, float radius, int side);

/// Scratch: where a view sees the receivers, in texels.
struct RsmPlaces {
    std::vector<float> x, y;
};

/// Irradiance at receivers [begin, end), as gather().
void sample_map(const LightMap& map, const RsmOptions& options, Receivers& receivers, std::size_t begin,
                std::size_t end, RsmPlaces& scratch);
/// The twin for one receiver, by single steps.
glm::vec3 sample_map_one(const LightMap& map, const RsmOptions& options, const glm::vec3& position,
                         const glm::vec3& normal);

}   // namespace gnomon::light_quadtree
