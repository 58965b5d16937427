// SPDX-License-Identifier: Apache-2.0
#pragma once
// The glossy lobe of glossy.h as a linearly transformed cosine [Heitz et al. 2016]: the clamped cosine distribution,
// transformed by a matrix, so that its integral over a polygon is Lambert's sum over the transformed polygon.
//
// The matrices are fitted to the lobe by maximum likelihood (cosine_fit.h). They are stored relative to the mirror
// direction and to the lobe's width, which vary slowly, so that a small table suffices.
//
// Cost: a bilinear look-up per point.

#include <vector>

#include "base/math.h"

namespace gnomon::shading {

/// The lobe of one view direction and roughness, in the surface's frame: z is the shading normal, and the viewer's
/// direction lies in the plane of x and z, at x >= 0.
struct TransformedCosine {
    glm::dmat3 to_cosine{1};   // from directions of the lobe to those of the clamped cosine about z
    double scale = 1;          // of the integral, so that all of the hemisphere above the surface has 1
};

/// @param n_v        cosine of the view, above 0
/// @param roughness  perceptual, 0.05 to 1
TransformedCosine transformed_cosine(float n_v, float roughness);

/// One fit of the table, for shaders, which mix neighbouring ones and compute the matrix (lobe_shared.h). The matrix is
/// R(turn) [a 0 c; 0 b 0; 0 0 1], where R turns the z axis in the plane of x and z onto the lobe's axis, which is
/// `tilt` away from the mirror direction, towards the normal. All but the scale are in units of alpha.
struct TransformedCosineFit {
    float a = 1, b = 1, c = 0, tilt = 0;
    float scale = 1;
};
/// Row by row of roughness, by the view.
std::vector<TransformedCosineFit> transformed_cosine_fits();

}   // namespace gnomon::shading
