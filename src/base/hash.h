// SPDX-License-Identifier: Apache-2.0
#pragma once
// A 64-bit hash of bytes, for tests of equality. Not for security.

#include <cstdint>
#include <cstring>
#include <span>

namespace gnomon {

/// Folds bytes into a running hash (FNV-1a over 64-bit words; the tail by bytes). Feed the result back as `seed`.
inline std::uint64_t hash_bytes(const void* data, std::size_t size, std::uint64_t seed = 0xcbf29ce484222325ull)
{
    constexpr std::uint64_t prime = 0x100000001b3ull;
    const auto* p = static_cast<const unsigned char*>(data);
    std::uint64_t h = seed;
    for (; size >= 8; p += 8, size -= 8) {
        std::uint64_t word;
        std::memcpy(&word, p, 8);
        h = (h ^ word) * prime;
        h ^= h >> 29;
    }
    for (; size > 0; ++p, --size) h = (h ^ *p) * prime;
    return h ^ (h >> 32);
}

template <class T>
std::uint64_t hash_span(std::span<const T> values, std::uint64_t seed = 0xcbf29ce484222325ull)
{
    static_assert(std::is_trivially_copyable_v<T>);
    return hash_bytes(values.data(), values.size_bytes(), seed);
}

}   // namespace gnomon
