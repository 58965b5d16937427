// SPDX-License-Identifier: Apache-2.0
#pragma once
// The (0, 2)-sequence [Sobol' 1967]: the two dimensions of point i, as fractions of 2^32.

#include <cstdint>

namespace gnomon {

/// The first dimension: the bits of i in reverse.
inline std::uint32_t reversed_bits(std::uint32_t x)
{
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

/// The second dimension: the matrix of binomial coefficients modulo 2.
inline std::uint32_t second_dimension(std::uint32_t i)
{
    std::uint32_t result = 0;
    for (std::uint32_t column = 1u << 31; i; i >>= 1, column ^= column >> 1)
        if (i & 1) result ^= column;
    return result;
}

}   // namespace gnomon
