// SPDX-License-Identifier: Apache-2.0
#pragma once
// Reproducible random numbers: the same on every machine and compiler, unlike the standard library's distributions.

#include <cstdint>

namespace gnomon {

/// PCG-XSH-RR 32 (O'Neill 2014).
class Random {
 public:
    explicit Random(std::uint64_t seed, std::uint64_t stream = 1) : increment_(stream * 2 + 1)
    {
        next();
        state_ += seed;
        next();
    }
    std::uint32_t next()
    {
        const std::uint64_t old = state_;
        state_ = old * 6364136223846793005ull + increment_;
        const auto shifted = static_cast<std::uint32_t>(((old >> 18) ^ old) >> 27);
        const auto turn = static_cast<std::uint32_t>(old >> 59);
        return (shifted >> turn) | (shifted << ((32u - turn) & 31u));
    }
    /// Uniform in [0, 1).
    float uniform() { return static_cast<float>(next() >> 8) * 0x1p-24f; }
    float uniform(float low, float high) { return low + (high - low) * uniform(); }
    /// Uniform in 0 ... n-1; n > 0.
    std::uint32_t below(std::uint32_t n)
    {
        return static_cast<std::uint32_t>((static_cast<std::uint64_t>(next()) * n) >> 32);
    }

 private:
    std::uint64_t state_ = 0;
    std::uint64_t increment_;
};

}   // namespace gnomon
