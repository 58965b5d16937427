// SPDX-License-Identifier: Apache-2.0
// LONG: the functions share reductions and series, which nothing else may call.
// The elementary functions of double precision, and of single precision by arithmetic of double precision: acos asin
// atan atan2 cbrt cos exp exp2 log log10 log2 pow sin sincos tan.
//
// The C library selects variants of these functions by the processor (with fused multiply-add or without), which differ
// in the last bit. The linker replaces all calls of the program by those below (cmake/ElementaryFunctions.cmake), whose
// results are the same on every processor. Errors: single precision below 0.5001 units in the last place; double
// precision below 0.51, because the leading terms of each series are Twofold. Angles above k_largest_angle are taken
// modulo the double nearest to 2 pi.
//
// The series are those of Taylor, after a reduction of the argument. Special values are those of C99, Annex F, but
// errno and floating-point exceptions are not set.
// LONG: one function after the other; they share series and reductions.
#include <cmath>
#include <limits>

#include "base/elementary/twofold.h"

namespace gnomon::elementary {

namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double k_inf = std::numeric_limits<double>::infinity();

// c[0] + c[1] x + c[2] x^2 ...
template <std::size_t n>
double polynomial(const double (&c)[n], double x)
{
    double sum = c[n - 1];
    for (std::size_t i = n - 1; i-- > 0;) sum = sum * x + c[i];
    return sum;
}

// 1 / n!
constexpr double per_factorial(int n)
{
    double product = 1;
    for (int i = 2; i <= n; ++i) product *= i;
    return 1 / product;
}

// ---- exponentials and logarithms

// The tail of e^t / t^4.
double exponential_tail(double t)
{
    static constexpr double c[] = {per_factorial(4),  per_factorial(5),  per_factorial(6),  per_factorial(7),
                                   per_factorial(8),  per_factorial(9),  per_factorial(10), per_factorial(11),
                                   per_factorial(12), per_factorial(13), per_factorial(14)};
    return polynomial(c, t);
}

// e^t. @pre |t| <= 0.35
Twofold small_exponential(const Twofold& t)
{
    const Twofold square = t * t, cube = square * t;
    const double fourth = square.hi * square.hi;
    const Twofold half(0.5 * square.hi, 0.5 * square.lo);
    return Twofold(1) + (t + (half + (k_sixth * cube + Twofold(fourth * exponential_tail(t.hi)))));
}
double small_exponential(double t)
{
    const double square = t * t;
    return 1 + (t + square * (0.5 + t * (per_factorial(3) + t * exponential_tail(t))));
}

// Rounds hi + lo times 2^n. For subnormal results, the sum is rounded twice.
double scaled(const Twofold& x, double n)
{
    return elementary::scaled(x.rounded(), static_cast<int>(n));
}

double exp2_of(const Twofold& power)
{
    if (power.hi != power.hi) return power.hi;
    if (power.hi > 1100) return k_inf;
    if (power.hi < -1200) return 0;
    const double n = std::nearbyint(power.hi);
    return scaled(small_exponential((power - Twofold(n)) * k_ln2), n);
}
double exp2_of(double power)
{
    if (power != power) return power;
    if (power > 1100) return k_inf;
    if (power < -1200) return 0;
    const double n = std::nearbyint(power);
    return elementary::scaled(small_exponential((power - n) * k_ln2.hi), static_cast<int>(n));
}

constexpr double k_ln2_head = 0x1.62e42fefa2p-1, k_ln2_rest = 0x1.9ef35793c7673p-41;   // 37 bits and what is left

double exp_of(double x)
{
    if (x != x) return x;
    if (x > 800) return k_inf;
    if (x < -800) return 0;
    const double n = std::nearbyint(x * k_per_ln2.hi);
    return scaled(small_exponential(exact_sum(x - n * k_ln2_head, -n * k_ln2_rest)), n);
}
double exp_in_double(double x)
{
    if (x != x) return x;
    if (x > 800) return k_inf;
    if (x < -800) return 0;
    const double n = std::nearbyint(x * k_per_ln2.hi);
    return elementary::scaled(small_exponential((x - n * k_ln2_head) - n * k_ln2_rest), static_cast<int>(n));
}

// The series 1/5 + z/7 + z^2/9 ... of the logarithm, z = s^2, |s| <= 0.172.
double logarithm_tail(double z)
{
    static constexpr double c[] = {1. / 5,  1. / 7,  1. / 9,  1. / 11, 1. / 13,
                                   1. / 15, 1. / 17, 1. / 19, 1. / 21, 1. / 23};
    return polynomial(c, z);
}

// The natural logarithm of a mantissa.
Twofold small_logarithm(double m)
{
    const Twofold s = exact_sum(m, -1) / exact_sum(m, 1), z = s * s;
    const Twofold series = Twofold(1) + (z * k_third + Twofold(z.hi * z.hi * logarithm_tail(z.hi)));
    const Twofold half = s * series;
    return {2 * half.hi, 2 * half.lo};
}
double small_logarithm_in_double(double m)
{
    const double s = (m - 1) / (m + 1), z = s * s;
    return 2 * (s + s * (z * (1. / 3 + z * logarithm_tail(z))));
}

// Whether x has no logarithm that is a finite number; `result`: what it has.
bool without_logarithm(double x, double& result)
{
    if (x > 0 && x < k_inf) return false;
    result = x == 0 ? -k_inf : x > 0 ? x : x != x ? x : k_nan;
    return true;
}

Twofold log2_twofold(double x)
{
    int e = 0;
    const double m = mantissa(x, e);
    return Twofold(e) + small_logarithm(m) * k_per_ln2;
}

double log_of(double x)
{
    double special = 0;
    if (without_logarithm(x, special)) return special;
    int e = 0;
    const Twofold m = small_logarithm(mantissa(x, e));
    return (Twofold(e) * k_ln2 + m).rounded();
}
double log2_of(double x)
{
    double special = 0;
    return without_logarithm(x, special) ? special : log2_twofold(x).rounded();
}
double log10_of(double x)
{
    double special = 0;
    if (without_logarithm(x, special)) return special;
    int e = 0;
    const Twofold m = small_logarithm(mantissa(x, e));
    return (Twofold(e) * k_log10_of_2 + m * k_per_ln10).rounded();
}
// @param unit  the logarithm of 2. @param per_ln  one unit per natural logarithm
double log_in_double(double x, double unit, double per_ln)
{
    double special = 0;
    if (without_logarithm(x, special)) return special;
    int e = 0;
    const double m = small_logarithm_in_double(mantissa(x, e));
    return e * unit + m * per_ln;
}

bool is_integer(double y)
{
    return std::nearbyint(y) == y;
}
bool is_odd(double y)
{
    return is_integer(y) && !is_integer(0.5 * y);
}

// Whether a power is a special value.
bool special_power(double x, double y, double& result)
{
    if (y == 0 || x == 1) return result = 1, true;
    if (x != x || y != y) return result = x + y, true;
    const double size = std::abs(x);
    const bool negative = std::signbit(x) && is_odd(y);
    if (std::abs(y) == k_inf) return result = size == 1 ? 1 : (size > 1) == (y > 0) ? k_inf : 0, true;
    if (size == 0 || size == k_inf)
        return result = std::copysign((size == 0) == (y > 0) ? 0 : k_inf, negative ? -1.0 : 1.0), true;
    if (x < 0 && !is_integer(y)) return result = k_nan, true;
    if (size == 1) return result = negative ? -1 : 1, true;
    return false;
}

constexpr double k_much = 0x1p70;   // exponents above which a power other than of 1 overflows or is 0

double pow_of(double x, double y)
{
    double special = 0;
    if (special_power(x, y, special)) return special;
    if (y == 1) return x;
    const Twofold log = log2_twofold(std::abs(x));
    const double size =
        std::abs(y) > k_much ? exp2_of((log.hi > 0) == (y > 0) ? k_inf : -k_inf) : exp2_of(log * Twofold(y));
    return x < 0 && is_odd(y) ? -size : size;
}
double pow_in_double(double x, double y)
{
    double special = 0;
    if (special_power(x, y, special)) return special;
    const double size = exp2_of(y * log_in_double(std::abs(x), 1, k_per_ln2.hi));
    return x < 0 && is_odd(y) ? -size : size;
}

double cbrt_of(double x)
{
    if (!(std::abs(x) < k_inf) || x == 0) return x;
    int e = 0;
    double m = mantissa(std::abs(x), e);
    // Make the exponent a multiple of 3.
    const int third = (e + 3000) / 3 - 1000;
    m = elementary::scaled(m, e - 3 * third);
    // One step of Newton's method from an estimate that is right to some 50 bits.
    const double r = exp_in_double(log_in_double(m, k_ln2.hi, 1) * (1. / 3));
    const Twofold rest = exact_product(r, r) * Twofold(r) - Twofold(m);
    return std::copysign(elementary::scaled(r - rest.rounded() / (3 * r * r), third), x);
}

// ---- angles

// Products of the first of these parts of pi / 2, of 33 bits each, and up to k_exact_turns are exact.
constexpr double k_parts[] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e037073p-69};
constexpr double k_exact_turns = 0x1p20;
constexpr double k_largest_angle = 0x1p52;

double quarter_turns(double x, unsigned& quarters)
{
    const double n = std::nearbyint(x * (1 / k_half_pi.hi));
    quarters = static_cast<unsigned>(static_cast<std::int64_t>(n)) & 3;
    return n;
}

// Reduces an angle to [-pi/4, pi/4] and a number of quarter turns.
Twofold reduced(double x, unsigned& quarters)
{
    if (std::abs(x) > k_largest_angle) x = std::fmod(x, 2 * k_twofold_pi.hi);
    const double n = quarter_turns(x, quarters);
    if (std::abs(n) < k_exact_turns)
        return exact_sum(x - n * k_parts[0], -n * k_parts[1]) - exact_product(n, k_parts[2]);
    constexpr double k_beyond = -0x1.f1976b7ed8fbcp-110;   // of pi / 2, after the two of k_half_pi
    return ((Twofold(x) - exact_product(n, k_half_pi.hi)) - exact_product(n, k_half_pi.lo)) - Twofold(n * k_beyond);
}
double reduced_in_double(double x, unsigned& quarters)
{
    if (std::abs(x) > k_exact_turns) return reduced(x, quarters).rounded();
    const double n = quarter_turns(x, quarters);
    return (x - n * k_parts[0]) - n * (k_parts[1] + k_parts[2]);
}

constexpr double k_sine[] = {per_factorial(5),  -per_factorial(7),  per_factorial(9),  -per_factorial(11),
                             per_factorial(13), -per_factorial(15), per_factorial(17), -per_factorial(19)};
constexpr double k_cosine[] = {-per_factorial(6),  per_factorial(8),  -per_factorial(10), per_factorial(12),
                               -per_factorial(14), per_factorial(16), -per_factorial(18), per_factorial(20)};

Twofold small_sine(const Twofold& r, const Twofold& square)
{
    const double fourth = square.hi * square.hi;
    return r + r * (Twofold(fourth * polynomial(k_sine, square.hi)) - square * k_sixth);
}
Twofold small_cosine(const Twofold& square)
{
    const double sixth = square.hi * square.hi * square.hi;
    const Twofold half(0.5 * square.hi, 0.5 * square.lo);
    return Twofold(1) - (half - (square * square * k_24th + Twofold(sixth * polynomial(k_cosine, square.hi))));
}

void sine_and_cosine(double x, Twofold& sine, Twofold& cosine)
{
    unsigned quarters = 0;
    const Twofold r = reduced(x, quarters), square = r * r;
    const Twofold s = small_sine(r, square), c = small_cosine(square);
    sine = quarters & 1 ? c : s, cosine = quarters & 1 ? s : c;
    if (quarters & 2) sine = -sine;
    if (quarters == 1 || quarters == 2) cosine = -cosine;
}

// Whether an angle is so small that it is its own sine, or is no number.
bool own_sine(double x)
{
    return std::abs(x) < 0x1p-30;
}
bool no_angle(double x)
{
    return !(std::abs(x) < k_inf);
}
// The sine of a tiny angle, rounded.
double tiny_sine(double x)
{
    return x == 0 ? x : x - x * x * x * (1. / 6);
}

double sin_of(double x)
{
    if (no_angle(x)) return k_nan;
    if (own_sine(x)) return tiny_sine(x);
    Twofold s, c;
    sine_and_cosine(x, s, c);
    return s.rounded();
}
double cos_of(double x)
{
    if (no_angle(x)) return k_nan;
    Twofold s, c;
    sine_and_cosine(x, s, c);
    return c.rounded();
}
double tan_of(double x)
{
    if (no_angle(x)) return k_nan;
    if (own_sine(x)) return x == 0 ? x : x + x * x * x * (1. / 3);
    Twofold s, c;
    sine_and_cosine(x, s, c);
    return (s / c).rounded();
}

struct SineAndCosine {
    double sine, cosine;
};
SineAndCosine in_double(double x)
{
    if (no_angle(x)) return {k_nan, k_nan};
    if (own_sine(x)) return {x, 1};
    unsigned quarters = 0;
    const double r = reduced_in_double(x, quarters), z = r * r;
    const double s = r + r * z * (z * polynomial(k_sine, z) - 1. / 6);
    const double c = 1 - z * (0.5 - z * (1. / 24 + z * polynomial(k_cosine, z)));
    const double sine = quarters & 1 ? c : s, cosine = quarters & 1 ? s : c;
    return {quarters & 2 ? -sine : sine, quarters == 1 || quarters == 2 ? -cosine : cosine};
}

// The series 1/5 - z/7 + z^2/9 ... of the arc tangent, z = t^2, |t| <= tan 15 degrees.
double arc_tangent_tail(double z)
{
    static constexpr double c[] = {1. / 5,   -1. / 7, 1. / 9,   -1. / 11, 1. / 13,  -1. / 15, 1. / 17,
                                   -1. / 19, 1. / 21, -1. / 23, 1. / 25,  -1. / 27, 1. / 29};
    return polynomial(c, z);
}

constexpr double k_tangent_of_15 = 0.268;

// @param t  0 to 1
Twofold small_arc_tangent(Twofold t)
{
    // Turn by 30 degrees.
    const bool turned = t.hi > k_tangent_of_15;
    if (turned) t = (t * k_root_3 - Twofold(1)) / (k_root_3 + t);
    const Twofold z = t * t;
    const Twofold own = t + t * (Twofold(z.hi * z.hi * arc_tangent_tail(z.hi)) - z * k_third);
    return turned ? k_sixth_pi + own : own;
}
double small_arc_tangent_in_double(double t)
{
    const bool turned = t > k_tangent_of_15;
    if (turned) t = (t * k_root_3.hi - 1) / (k_root_3.hi + t);
    const double z = t * t;
    const double own = t + t * (z * (z * arc_tangent_tail(z) - 1. / 3));
    return turned ? k_sixth_pi.hi + own : own;
}

Twofold size_of(const Twofold& x)
{
    return x.hi < 0 ? -x : x;
}
bool less(const Twofold& a, const Twofold& b)
{
    return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo);
}

// The angle of a point of the plane; both numbers are finite, neither is 0, and their ratio does not underflow.
Twofold angle_of(const Twofold& y, const Twofold& x)
{
    const Twofold up = size_of(y), right = size_of(x);
    Twofold angle = less(right, up) ? k_half_pi - small_arc_tangent(right / up) : small_arc_tangent(up / right);
    if (x.hi < 0) angle = k_twofold_pi - angle;
    return y.hi < 0 ? -angle : angle;
}
double angle_in_double(double y, double x)
{
    const double up = std::abs(y), right = std::abs(x);
    double angle =
        right < up ? k_half_pi.hi - small_arc_tangent_in_double(right / up) : small_arc_tangent_in_double(up / right);
    if (x < 0) angle = k_twofold_pi.hi - angle;
    return y < 0 ? -angle : angle;
}

// The same for a point so near to the right half of the horizontal axis that double precision suffices for all but the
// first term of the series, unless the result might be rounded otherwise than that of angle_of().
// @pre 0 < y, x
bool flat_angle(double y, double x, double& result)
{
    constexpr double k_flattest = 0x1p-5, k_certain = 0x1p-57;   // a sixteenth of a unit in the last place, or less
    const double t = y / x;
    if (!(t < k_flattest)) return false;
    // What the quotient was rounded by, and all further terms.
    const Twofold product = exact_product(t, x);
    const double rest = ((y - product.hi) - product.lo) / x, z = t * t;
    const Twofold sum = quick_sum(t, rest + t * (z * (z * arc_tangent_tail(z) - 1. / 3)));
    result = sum.hi + (sum.lo - k_certain * t);
    return result == sum.hi + (sum.lo + k_certain * t);
}

// Whether the angle is that of an axis or a diagonal of infinite length.
bool special_angle(double y, double x, double& result)
{
    if (x != x || y != y) return result = x + y, true;
    const double up = std::abs(y), right = std::abs(x);
    double angle = 0;
    if (up == k_inf && right == k_inf)
        angle = 0.5 * k_half_pi.hi;
    else if (up == k_inf || right == 0)
        angle = up == 0 ? 0 : k_half_pi.hi;
    else if (!(right == k_inf || up == 0))
        return false;
    if (std::signbit(x)) angle = angle == 0 ? k_twofold_pi.hi : angle == k_half_pi.hi ? angle : 3 * angle;
    return result = std::copysign(angle, y), true;
}

double atan2_of(double y, double x)
{
    double special = 0;
    if (special_angle(y, x, special)) return special;
    // Scale, so that no product underflows or overflows.
    int above = 0, beside = 0;
    double up = mantissa(std::abs(y), above), right = mantissa(std::abs(x), beside);
    constexpr int k_apart = 200;
    const int apart = above - beside;
    if (apart > k_apart) return std::copysign(k_half_pi.hi, y);
    if (apart < -k_apart) {
        if (x < 0) return std::copysign(k_twofold_pi.hi, y);
        return std::copysign(elementary::scaled((Twofold(up) / Twofold(right)).rounded(), apart), y);
    }
    up = elementary::scaled(up, apart);
    if (double angle = 0; x > 0 && flat_angle(up, right, angle)) return std::copysign(angle, y);
    return angle_of(Twofold(std::copysign(up, y)), Twofold(std::copysign(right, x))).rounded();
}
double atan2_in_double(double y, double x)
{
    double special = 0;
    return special_angle(y, x, special) ? special : angle_in_double(y, x);
}

double atan_of(double x)
{
    return atan2_of(x, 1);
}

// sqrt(1 - x^2)
Twofold other_side(double x)
{
    const Twofold square = exact_product(x, x);
    return square_root(Twofold(1) - square);
}

double asin_of(double x)
{
    if (!(std::abs(x) <= 1)) return k_nan;
    if (std::abs(x) == 1) return std::copysign(k_half_pi.hi, x);
    if (own_sine(x)) return x + x * x * x * (1. / 6);
    return angle_of(Twofold(x), other_side(x)).rounded();
}
double acos_of(double x)
{
    if (!(std::abs(x) <= 1)) return k_nan;
    if (std::abs(x) == 1) return x > 0 ? 0 : k_twofold_pi.hi;
    if (std::abs(x) < 0x1p-60) return k_half_pi.hi;
    if (own_sine(x)) return (k_half_pi - Twofold(x)).rounded();
    return angle_of(other_side(x), Twofold(x)).rounded();
}
double asin_in_double(double x)
{
    return std::abs(x) <= 1 ? atan2_in_double(x, std::sqrt((1 - x) * (1 + x))) : k_nan;
}
double acos_in_double(double x)
{
    return std::abs(x) <= 1 ? atan2_in_double(std::sqrt((1 - x) * (1 + x)), x) : k_nan;
}

float single(double x)
{
    return static_cast<float>(x);
}

}   // namespace

}   // namespace gnomon::elementary

// The names that the linker gives to the calls.
// NOLINTBEGIN(bugprone-reserved-identifier)
namespace el = gnomon::elementary;
extern "C" {
double __wrap_acos(double x);
double __wrap_asin(double x);
double __wrap_atan(double x);
double __wrap_atan2(double y, double x);
double __wrap_cbrt(double x);
double __wrap_cos(double x);
double __wrap_exp(double x);
double __wrap_exp2(double x);
double __wrap_log(double x);
double __wrap_log10(double x);
double __wrap_log2(double x);
double __wrap_pow(double x, double y);
double __wrap_sin(double x);
void __wrap_sincos(double x, double* sine, double* cosine);
double __wrap_tan(double x);
float __wrap_acosf(float x);
float __wrap_asinf(float x);
float __wrap_atanf(float x);
float __wrap_atan2f(float y, float x);
float __wrap_cbrtf(float x);
float __wrap_cosf(float x);
float __wrap_expf(float x);
float __wrap_exp2f(float x);
float __wrap_logf(float x);
float __wrap_log10f(float x);
float __wrap_log2f(float x);
float __wrap_powf(float x, float y);
float __wrap_sinf(float x);
void __wrap_sincosf(float x, float* sine, float* cosine);
float __wrap_tanf(float x);

double __wrap_acos(double x)
{
    return el::acos_of(x);
}
double __wrap_asin(double x)
{
    return el::asin_of(x);
}
double __wrap_atan(double x)
{
    return el::atan_of(x);
}
double __wrap_atan2(double y, double x)
{
    return el::atan2_of(y, x);
}
double __wrap_cbrt(double x)
{
    return el::cbrt_of(x);
}
double __wrap_cos(double x)
{
    return el::cos_of(x);
}
double __wrap_exp(double x)
{
    return el::exp_of(x);
}
double __wrap_exp2(double x)
{
    return el::exp2_of(el::Twofold(x));
}
double __wrap_log(double x)
{
    return el::log_of(x);
}
double __wrap_log10(double x)
{
    return el::log10_of(x);
}
double __wrap_log2(double x)
{
    return el::log2_of(x);
}
double __wrap_pow(double x, double y)
{
    return el::pow_of(x, y);
}
double __wrap_sin(double x)
{
    return el::sin_of(x);
}
void __wrap_sincos(double x, double* sine, double* cosine)
{
    *sine = el::sin_of(x);
    *cosine = el::cos_of(x);
}
double __wrap_tan(double x)
{
    return el::tan_of(x);
}
float __wrap_acosf(float x)
{
    return el::single(el::acos_in_double(static_cast<double>(x)));
}
float __wrap_asinf(float x)
{
    return el::single(el::asin_in_double(static_cast<double>(x)));
}
float __wrap_atanf(float x)
{
    return el::single(el::atan2_in_double(static_cast<double>(x), 1));
}
float __wrap_atan2f(float y, float x)
{
    return el::single(el::atan2_in_double(static_cast<double>(y), static_cast<double>(x)));
}
float __wrap_cbrtf(float x)
{
    return el::single(el::cbrt_of(static_cast<double>(x)));
}
float __wrap_cosf(float x)
{
    return el::single(el::in_double(static_cast<double>(x)).cosine);
}
float __wrap_expf(float x)
{
    return el::single(el::exp_in_double(static_cast<double>(x)));
}
float __wrap_exp2f(float x)
{
    return el::single(el::exp2_of(static_cast<double>(x)));
}
float __wrap_logf(float x)
{
    return el::single(el::log_in_double(static_cast<double>(x), el::k_ln2.hi, 1));
}
float __wrap_log10f(float x)
{
    return el::single(el::log_in_double(static_cast<double>(x), el::k_log10_of_2.hi, el::k_per_ln10.hi));
}
float __wrap_log2f(float x)
{
    return el::single(el::log_in_double(static_cast<double>(x), 1, el::k_per_ln2.hi));
}
float __wrap_powf(float x, float y)
{
    return el::single(el::pow_in_double(static_cast<double>(x), static_cast<double>(y)));
}
float __wrap_sinf(float x)
{
    return el::single(el::in_double(static_cast<double>(x)).sine);
}
void __wrap_sincosf(float x, float* sine, float* cosine)
{
    const el::SineAndCosine both = el::in_double(static_cast<double>(x));
    *sine = el::single(both.sine);
    *cosine = el::single(both.cosine);
}
float __wrap_tanf(float x)
{
    const el::SineAndCosine both = el::in_double(static_cast<double>(x));
    return el::single(both.sine / both.cosine);
}
}
// NOLINTEND(bugprone-reserved-identifier)
