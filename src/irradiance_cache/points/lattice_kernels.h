// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interpolates the four cache points of a lattice cell at many surface points of the cell, in the widest instruction
// set of the CPU (Highway). Each point is computed by itself in a fixed order of operations, so its bits do not depend
// on how many are computed together.

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace gnomon::irradiance_cache {

/// The four cache points of a cell, as a structure of arrays.
struct CellAnchors {
    float x[4], y[4], z[4], nx[4], ny[4], nz[4];   // x is infinite if a point does not exist
    // Free ranges around the point along the lattice's other two axes, and how much shorter they get per unit along the
    // other axis if the wall that ends them stands at an angle: low b, high b, low c, high c.
    float low_b[4], high_b[4], low_c[4], high_c[4];
    float slope[4][4];    // by range and point
    float light[9][4];    // by colour and axis
    float facing[3][4];   // by axis
    // Whether all have one normal. Otherwise each gives its light for a normal half-way to the surface point's.
    bool one_normal;
    int axis;
};

/// Surface points in a structure of arrays, padded so that the last vector may be read completely.
struct LatticePoints {
    std::vector<float> x, y, z;      // positions
    std::vector<float> gx, gy, gz;   // geometric normals, unit
    std::vector<float> nx, ny, nz;   // shading normals, unit
    std::vector<float> fx, fy;       // place in the cell, 0 to 1
    void resize(std::size_t count);
    static constexpr std::size_t k_pad = 16;
};

/// Interpolated irradiance by colour, form factor, and the part of the bilinear weight (1 in total) of the cache points
/// that contribute: in all, and by cache point. Irradiance and form factor are 0 where the weight is 0.
struct LatticeLight {
    std::vector<float> r, g, b, form_factor, weight, weight_of[4];
    void resize(std::size_t count);
};

/// The surface points to which a cache point contributes.
struct LatticeReach {
    float plane;      // distance from their plane, scene units: no weight from there on
    float facing;     // cosine between the normals: no weight below
    bool open_only;   // only within the free ranges
};

/// The normal for which a cache point of a curved surface gives its light to a surface point: half-way between its own
/// and the surface point's, which a normal map may turn from the mean of those between which the point lies. For the
/// surface point's own, it would lack what comes from below its horizon; for its own, light would change along a
/// straight line between cache points. Half-way the two errors cancel: light that is a quadratic function of the
/// normal's angle is exact. Of such a length that along its own normal a cache point gives all its light.
/// @param own   unit
/// @param mean  unit: of these, by weight
inline glm::vec3 halfway_normal(const glm::vec3& own, const glm::vec3& mean, const glm::vec3& normal)
{
    return (own + (normal - mean) + normal) / (1 + (own.x * mean.x + own.y * mean.y + own.z * mean.z));
}

/// Fills light[first ... first + count) for the points there, all of one cell. May write up to k_pad - 1 beyond.
void interpolate_cell(const CellAnchors& cell, const LatticeReach& reach, const LatticePoints& points,
                      std::size_t first, std::size_t count, LatticeLight& light);

}   // namespace gnomon::irradiance_cache
