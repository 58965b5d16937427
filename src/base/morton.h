// SPDX-License-Identifier: Apache-2.0
#pragma once
// Morton codes: the bits of two numbers in turn, so that codes close to each other are places close to each other.

#include <cstdint>

namespace gnomon {

/// The low 32 bits of x as every second bit, from the lowest.
constexpr std::uint64_t spread_bits(std::uint64_t x)
{
    x &= 0x00000000ffffffffull;
    x = (x | (x << 16)) & 0x0000ffff0000ffffull;
    x = (x | (x << 8)) & 0x00ff00ff00ff00ffull;
    x = (x | (x << 4)) & 0x0f0f0f0f0f0f0f0full;
    x = (x | (x << 2)) & 0x3333333333333333ull;
    return (x | (x << 1)) & 0x5555555555555555ull;
}

/// The inverse of spread_bits for 16 bits: every second bit of a code, from the lowest. even_bits(code) is x, and
/// even_bits(code >> 1) is y.
constexpr std::uint32_t even_bits(std::uint32_t code)
{
    code &= 0x55555555u;
    code = (code | (code >> 1)) & 0x33333333u;
    code = (code | (code >> 2)) & 0x0f0f0f0fu;
    code = (code | (code >> 4)) & 0x00ff00ffu;
    return (code | (code >> 8)) & 0x0000ffffu;
}

/// The bits of x and y in turn; the lowest is x's.
constexpr std::uint64_t morton_code(std::uint32_t x, std::uint32_t y)
{
    return spread_bits(x) | (spread_bits(y) << 1);
}

}   // namespace gnomon
