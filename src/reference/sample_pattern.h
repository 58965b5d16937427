// SPDX-License-Identifier: Apache-2.0
#pragma once
// Randomised low-discrepancy points of the unit square, and directions made from them, for the reference's rays.
//
// A batch is the first n points of the (0, 2)-sequence [Sobol' 1967; Kollig and Keller 2002, "Efficient
// Multidimensional Sampling"], its bits flipped at random. So every point is uniform by itself, the n points of a batch
// leave no large gap, and batches with different flips are independent: their spread measures the error.
//
// The points come in Morton order. Flipping bits keeps it, up to the order of whole cells: neighbours in the list are
// neighbours in the square, and rays made from them share packets.

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "base/math.h"

namespace gnomon::reference {

class SamplePattern {
 public:
    using Point = std::pair<std::uint32_t, std::uint32_t>;   // fractions, in units of 2^-32

    /// The first `count` points. Cost: count * log(count) in the first call with that count, then none.
    const std::vector<Point>& points(int count);

 private:
    std::map<int, std::vector<Point>> kept_;
};

/// The random numbers of one path. Each decision has a point of its own sequence: the (0, 2)-sequence with Owen's
/// scrambling [1998], by hashes of the decision [Burley 2020, "Practical Hash-based Owen Scrambling"; Laine and Karras
/// 2011]. Over the paths of a batch, every decision is spread over the square as evenly as the first.
class PathNumbers {
 public:
    /// @param seed   of the batch
    /// @param index  of the path in its batch
    PathNumbers(std::uint64_t seed, std::uint32_t index) : seed_(seed), index_(index) {}
    /// Two numbers in [0, 1), those of a decision.
    glm::vec2 pair(std::uint32_t decision) const;
    float one(std::uint32_t decision) const;

 private:
    /// The path's place in the shuffled sequence of a decision with this seed.
    std::uint32_t shuffled(std::uint64_t seed) const;
    std::uint64_t seed_;
    std::uint32_t index_;
};

/// Returns a fraction in [0, 1) from random bits.
inline float unit_fraction(std::uint32_t bits)
{
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

/// Returns a direction about the unit vector n, with density cosine / pi; neighbours in the square stay neighbours
/// [Shirley and Chiu 1997]. u, v in [0, 1).
glm::vec3 cosine_direction(const glm::vec3& n, float u, float v);

/// Mixes two numbers into the seed of an independent stream of random numbers.
std::uint64_t mix(std::uint64_t a, std::uint64_t b);

}   // namespace gnomon::reference
