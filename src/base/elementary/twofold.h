// SPDX-License-Identifier: Apache-2.0
#pragma once
// Numbers of about 106 bits, as unevaluated sums of two doubles [Dekker 1971, 'A floating-point technique for extending
// the available precision'; Knuth, 'The Art of Computer Programming', 4.2.2].
//
// Only additions, multiplications, divisions and square roots of doubles are used, each rounded once, so that the
// results are the same on every processor.

#include <bit>
#include <cmath>
#include <cstdint>

namespace gnomon::elementary {

/// hi is the sum, rounded.
struct Twofold {
    double hi = 0, lo = 0;
    constexpr Twofold(double h = 0, double l = 0) : hi(h), lo(l) {}
    double rounded() const { return hi + lo; }
    Twofold operator-() const { return {-hi, -lo}; }
};

/// @pre |a| >= |b|, or a is 0
inline Twofold quick_sum(double a, double b)
{
    const double s = a + b;
    return {s, b - (s - a)};
}
/// a + b, exact.
inline Twofold exact_sum(double a, double b)
{
    const double s = a + b, part = s - a;
    return {s, (a - (s - part)) + (b - part)};
}
/// a * b, exact. @pre |a|, |b| < 2^990; the product is 0 or above 2^-960
inline Twofold exact_product(double a, double b)
{
    constexpr double k_split = 0x1p27 + 1;
    const double a_big = k_split * a, b_big = k_split * b;
    const double a1 = a_big - (a_big - a), b1 = b_big - (b_big - b);
    const double a2 = a - a1, b2 = b - b1, p = a * b;
    return {p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2};
}
inline Twofold operator+(const Twofold& a, const Twofold& b)
{
    const Twofold s = exact_sum(a.hi, b.hi);
    return quick_sum(s.hi, s.lo + (a.lo + b.lo));
}
inline Twofold operator-(const Twofold& a, const Twofold& b)
{
    return a + -b;
}
inline Twofold operator*(const Twofold& a, const Twofold& b)
{
    const Twofold p = exact_product(a.hi, b.hi);
    return quick_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}
inline Twofold operator/(const Twofold& a, const Twofold& b)
{
    const double q = a.hi / b.hi;
    const Twofold rest = a - b * Twofold(q);
    return quick_sum(q, rest.hi / b.hi);
}
/// @pre a > 0
inline Twofold square_root(const Twofold& a)
{
    const double s = std::sqrt(a.hi);
    const Twofold rest = a - exact_product(s, s);
    return quick_sum(s, rest.hi / (2 * s));
}

inline constexpr Twofold k_ln2(0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56);
inline constexpr Twofold k_per_ln2(0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56);
inline constexpr Twofold k_per_ln10(0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57);
inline constexpr Twofold k_log10_of_2(0x1.34413509f79ffp-2, -0x1.9dc1da994fd21p-59);
inline constexpr Twofold k_twofold_pi(0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53);
inline constexpr Twofold k_half_pi(0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54);
inline constexpr Twofold k_sixth_pi(0x1.0c152382d7366p-1, -0x1.ee6913347c2a6p-55);
inline constexpr Twofold k_root_3(0x1.bb67ae8584caap+0, 0x1.cec95d0b5c1e3p-54);
inline constexpr Twofold k_third(0x1.5555555555555p-2, 0x1.5555555555555p-56);
inline constexpr Twofold k_sixth(0x1.5555555555555p-3, 0x1.5555555555555p-57);
inline constexpr Twofold k_24th(0x1.5555555555555p-5, 0x1.5555555555555p-59);

/// x * 2^n, rounded once where it is subnormal. @pre |n| < 3000
inline double scaled(double x, int n)
{
    const auto power = [](int e) { return std::bit_cast<double>(static_cast<std::uint64_t>(e + 1023) << 52); };
    constexpr int k_step = 900;
    for (; n > k_step; n -= k_step) x *= power(k_step);
    if (n >= -k_step) return x * power(n);
    // Multiply by the smallest power last, so that only that product is rounded.
    if (n < -2 * k_step) return x * power(-k_step) * power(-k_step);
    return x * power(n + k_step) * power(-k_step);
}

/// The mantissa of a positive finite number, from sqrt(1/2) to sqrt(2), and its exponent.
inline double mantissa(double x, int& exponent)
{
    exponent = 0;
    if (x < 0x1p-1022) x *= 0x1p54, exponent = -54;
    auto bits = std::bit_cast<std::uint64_t>(x);
    exponent += static_cast<int>(bits >> 52) - 1023;
    bits = (bits & 0x000fffffffffffffu) | 0x3ff0000000000000u;
    double m = std::bit_cast<double>(bits);
    if (m > 0x1.6a09e667f3bcdp+0) m *= 0.5, ++exponent;
    return m;
}

}   // namespace gnomon::elementary
