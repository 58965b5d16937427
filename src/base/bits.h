// SPDX-License-Identifier: Apache-2.0
#pragma once
// Bitwise comparison of values.

#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace gnomon {

/// Whether two values are equal bit for bit: 0 differs from -0, and a NaN equals itself. For types without padding.
template <class T>
requires std::is_trivially_copyable_v<T>
bool same_bits(const T& a, const T& b)
{
    const auto mine = std::as_bytes(std::span<const T>(&a, 1)), other = std::as_bytes(std::span<const T>(&b, 1));
    return std::memcmp(mine.data(), other.data(), mine.size()) == 0;
}

/// The same for arrays; arrays of different lengths differ.
template <class T>
requires std::is_trivially_copyable_v<T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b)
{
    const auto mine = std::as_bytes(std::span<const T>(a)), other = std::as_bytes(std::span<const T>(b));
    if (mine.size() != other.size()) return false;
    return mine.empty() || std::memcmp(mine.data(), other.data(), mine.size()) == 0;
}

}   // namespace gnomon
