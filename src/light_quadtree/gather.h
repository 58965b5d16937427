// SPDX-License-Identifier: Apache-2.0
#pragma once
// The sum over lights at receivers, many receivers at a time, with what the processor at hand offers (Highway); and its
// twins for one receiver.
//
// A light of flux P and area A at distance d: E = P / pi * cosine there * cosine here / (d^2 + A / pi).
// DEVIATION(Ki 2007, eq. 5): a disk's kernel for 1 / d^2, since the point's is unbounded where surfaces meet. Written
// with the same dot products, n_C.(x - x_C) as light leaves along n_C (the paper prints its negative).
//
// Additions, multiplications, divisions and comparisons in single precision, in the order of the lights: every
// instruction set and the twins find the same bits.
// Cost: 31 operations and a division a pair.

#include <vector>

#include "light_quadtree/clusters.h"

namespace gnomon::light_quadtree {

/// Receivers and what they receive come in steps of this many.
inline constexpr std::size_t k_receiver_step = 32;

/// Where light is wanted; arrays are padded to the step.
struct Receivers {
    std::vector<float> x, y, z;
    std::vector<float> nx, ny, nz;   // unit
    std::vector<float> r, g, b;      // out: irradiance

    std::size_t size() const { return count_; }
    void resize(std::size_t count);
    void set(std::size_t i, const glm::vec3& position, const glm::vec3& normal);
    glm::vec3 irradiance(std::size_t i) const { return {r[i], g[i], b[i]}; }

 private:
    std::size_t count_ = 0;
};

/// Root mean square error of what receivers have, over the mean of `truth`; all channels together.
double nrmse(const Receivers& test, const Receivers& truth);

/// Irradiance of all clusters at receivers [begin, end), multiples of the step or the padded end.
void gather(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end);
inline void gather(const Clusters& clusters, Receivers& receivers)
{
    gather(clusters, receivers, 0, receivers.x.size());
}

/// One light at one receiver, added to `irradiance`. The twin of a lane.
void add_light(const Clusters& clusters, std::size_t light, const glm::vec3& position, const glm::vec3& normal,
               glm::vec3& irradiance);
/// The sum by single steps.
glm::vec3 gather_one(const Clusters& clusters, const glm::vec3& position, const glm::vec3& normal);

/// As printed [Ki and Oh 2007, 3.2]: one pass a level over all nodes of the level; a node lights if it is valid, or at
/// the limit level, and all its ancestors from the start level on are invalid.
/// @param nodes_looked_at  optional; counts up
glm::vec3 gather_as_printed(const LightMap& map, const CutLevels& levels, const glm::vec3& position,
                            const glm::vec3& normal, std::uint64_t* nodes_looked_at = nullptr);

}   // namespace gnomon::light_quadtree
