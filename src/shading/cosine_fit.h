// SPDX-License-Identifier: Apache-2.0
#pragma once
// The fits of transformed_cosines.h: how they are found, and the table of them.
//
// A fit makes the mean logarithm of the transformed distribution largest, over a fixed pattern of directions of the
// lobe. It is deterministic. The table (cosine_fits.cpp) holds what fitted_cosines() returns, so that no program has
// to look for it; a test compares them.

#include <array>

#include "base/math.h"
#include "shading/lobe_shared.h"

namespace gnomon::shading {

inline constexpr int k_cosine_rows = GNOMON_COSINE_ROWS, k_cosine_columns = GNOMON_COSINE_COLUMNS;
inline constexpr double k_first_cosine_roughness = 0.05;   // to the double
inline constexpr double k_least_view_cosine = 2e-3;

/// One fit, relative to the mirror direction and to the lobe's width alpha, which is the roughness squared.
struct CosineFit {
    double a = 1, b = 1, c = 0;   // in units of alpha
    double tilt = 0;              // radians, of the lobe's axis from the mirror direction, towards the normal; in units
                                  // of alpha in tables
    double scale = 1;
};
/// Row by row of roughness, by the view.
using CosineFits = std::array<CosineFit, std::size_t{k_cosine_rows} * k_cosine_columns>;

extern const CosineFits k_cosine_fits;

/// Finds the table. Cost: .3 s of processor time (2 cores, AMD EPYC with AVX-512).
CosineFits fitted_cosines();

/// From directions of the clamped cosine about z to those of the lobe: R(turn) [a 0 c; 0 b 0; 0 0 1], where R turns the
/// z axis in the plane of x and z onto the lobe's axis.
/// @param mirror_angle  radians, between the normal and the mirror direction
/// @param f             its tilt in radians
glm::dmat3 cosine_matrix(double alpha, double mirror_angle, const CosineFit& f);

}   // namespace gnomon::shading
