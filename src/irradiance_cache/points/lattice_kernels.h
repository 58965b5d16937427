// SPDX-License-Identifier: Apache-2.0
#pragma once
// Interpolation between the four anchors of a lattice cell, for many points of one cell at once, with what the
// processor at hand offers (Highway). Every point is reckoned by itself and in one order: its bits do not depend on how
// many stand side by side.

#include <cstddef>
#include <vector>

namespace gnomon::irradiance_cache {

/// Four lattice anchors, side by side.
struct CellAnchors {
    float x[4], y[4], z[4], nx[4], ny[4], nz[4];   // x infinite: there is none
    // Places that are open to the anchor, along the other two axes; and by how much less of one for a unit further
    // along the other, where the wall that ends the way stands at an angle: low b, high b, low c, high c.
    float low_b[4], high_b[4], low_c[4], high_c[4];
    float slope[4][4];   // by which, by anchor
    float light[9][4];   // by colour and axis
    int axis;
};

/// Points in a structure of arrays, padded so that the last vector may be read whole.
struct LatticePoints {
    std::vector<float> x, y, z;      // positions
    std::vector<float> gx, gy, gz;   // geometric normals, unit
    std::vector<float> nx, ny, nz;   // shading normals, unit
    std::vector<float> fx, fy;       // place in the cell, 0 to 1
    void resize(std::size_t count);
    static constexpr std::size_t k_pad = 16;
};

/// What a cell says at points: irradiance by colour, and how much of the four anchors' bilinear weight (1 in all) can
/// speak for the point. 0 where the weight is 0.
struct LatticeLight {
    std::vector<float> r, g, b, weight;
    void resize(std::size_t count);
};

/// What an anchor may be interpolated to.
struct LatticeReach {
    float plane;      // distance from the point's plane, scene units: no weight from there on
    float facing;     // cosine between the normals: no weight below
    bool open_only;   // only to places that are open to it
};

/// Fills light[first ... first + count) from the points there, all of one cell. May write up to k_pad - 1 behind.
void interpolate_cell(const CellAnchors& cell, const LatticeReach& reach, const LatticePoints& points,
                      std::size_t first, std::size_t count, LatticeLight& light);

}   // namespace gnomon::irradiance_cache
