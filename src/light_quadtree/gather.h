// SPDX-License-Identifier: Apache-2.0
#pragma once
// Sums the irradiance by clusters at many receivers with SIMD (Highway), and reference implementations for one
// receiver.
//
// A cluster of flux P and area A at distance d: E = P / pi * cosine there * cosine here / (d^2 + A / pi).
// DEVIATION(Ki 2007, eq. 5): the kernel of a disk instead of 1 / d^2, because that of a point is unbounded where
// surfaces meet. It uses the same dot products, with n_C.(x - x_C) for light that leaves along n_C (the paper prints
// its negative).
//
// It uses additions, multiplications, divisions and comparisons in single precision, in the order of the clusters, so
// every instruction set and the reference implementations give the same bits. Cost: 31 operations and a division per
// pair.

#include <vector>

#include "light_quadtree/clusters.h"

namespace gnomon::light_quadtree {

/// The number of receivers is padded to a multiple of this.
inline constexpr std::size_t k_receiver_step = 32;

/// The points at which irradiance is computed; arrays are padded to the step.
struct Receivers {
    std::vector<float> x, y, z;
    std::vector<float> nx, ny, nz;   // unit
    std::vector<float> r, g, b;      // result: irradiance

    std::size_t size() const { return count_; }
    void resize(std::size_t count);
    void set(std::size_t i, const glm::vec3& position, const glm::vec3& normal);
    glm::vec3 irradiance(std::size_t i) const { return {r[i], g[i], b[i]}; }

 private:
    std::size_t count_ = 0;
};

/// Root mean square error of the receivers' irradiance, divided by the mean of `truth`; over all channels.
double nrmse(const Receivers& test, const Receivers& truth);

/// Computes irradiance by all clusters at receivers [begin, end), which are multiples of the step or the padded end.
void gather(const Clusters& clusters, Receivers& receivers, std::size_t begin, std::size_t end);
inline void gather(const Clusters& clusters, Receivers& receivers)
{
    gather(clusters, receivers, 0, receivers.x.size());
}

/// Adds the irradiance by one cluster at one receiver. The same operations as in one SIMD lane.
void add_light(const Clusters& clusters, std::size_t light, const glm::vec3& position, const glm::vec3& normal,
               glm::vec3& irradiance);
/// The sum for one receiver, without SIMD.
glm::vec3 gather_one(const Clusters& clusters, const glm::vec3& position, const glm::vec3& normal);

/// The method as printed [Ki and Oh 2007, 3.2]: one pass per level over all nodes of the level. A node contributes if
/// it is valid, or at the limit level, and all its ancestors from the start level on are invalid.
/// @param nodes_looked_at  optional; is increased by the number of nodes visited
glm::vec3 gather_as_printed(const LightMap& map, const CutLevels& levels, const glm::vec3& position,
                            const glm::vec3& normal, std::uint64_t* nodes_looked_at = nullptr);

}   // namespace gnomon::light_quadtree
