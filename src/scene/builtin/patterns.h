// SPDX-License-Identifier: Apache-2.0
#pragma once
// Procedural textures: stone, plaster, marble, the face of a sundial. They use value noise on a lattice that wraps, so
// every pattern except the dial tiles. The sRGB result depends on the arguments only. Cost: size squared times octaves.

#include <vector>

#include "base/image.h"
#include "base/math.h"

namespace gnomon::scene {

/// Octaves of smooth value noise over [0, 1) x [0, 1), periodic.
class TiledNoise {
 public:
    /// @param cells  lattice cells across at the first octave; each further octave doubles them
    TiledNoise(int cells, int octaves, std::uint32_t seed);
    /// 0 to 1, with a mean of about 0.5.
    float operator()(glm::vec2 p) const;

 private:
    struct Octave {
        int cells;
        std::vector<float> value;   // cells * cells
    };
    std::vector<Octave> octaves_;
};

/// Speckled stone: two colours mixed by noise, with pores.
Image8 stone_pattern(int size, const glm::vec3& light, const glm::vec3& dark, float pores, std::uint32_t seed);
/// Plaster, patchy and stained.
Image8 plaster_pattern(int size, const glm::vec3& color, std::uint32_t seed);
/// Marble with bent veins.
Image8 marble_pattern(int size, std::uint32_t seed);
/// A sundial's face: rings, hour lines that meet at the foot of the gnomon, half hours, a sun. Covers the unit square.
Image8 dial_pattern(int size);
/// One row of grey values that rise from 0 to `top` (0 to 1).
Image8 ramp_pattern(float top);

}   // namespace gnomon::scene
