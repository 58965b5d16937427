// SPDX-License-Identifier: Apache-2.0
#include "shading/cosine_fit.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numbers>
#include <vector>

#include "shading/glossy.h"

namespace gnomon::shading {

namespace {

constexpr int k_side = 20;    // of the pattern of directions that a fit uses
constexpr int k_steps = 80;   // of the simplex search
constexpr double k_shear_penalty = 1e-3;

struct Direction {
    glm::dvec3 at;
    double weight;
};

// Directions that the lobe reflects, with weights that sum to 1.
std::vector<Direction> directions(const SurfacePoint& s)
{
    std::vector<Direction> result;
    double sum = 0;
    for (int i = 0; i < k_side; ++i)
        for (int j = 0; j < k_side; ++j) {
            const float u = (static_cast<float>(i) + 0.5f) / k_side, v = (static_cast<float>(j) + 0.5f) / k_side;
            const glm::vec3 direction = sample_glossy(s, u, v);
            const float density = glossy_density(s, direction);
            if (!(direction.z > 0) || !(density > 0)) continue;
            const double weight = static_cast<double>(reflect_glossy(s, direction).x / density);
            if (!(weight > 0)) continue;
            result.push_back({glm::dvec3(direction), weight});
            sum += weight;
        }
    for (Direction& d : result) d.weight /= sum;
    return result;
}

// The natural logarithm of a normal number above 0, within 1e-13 of its magnitude or of 1, without a call: a fit needs
// millions of them.
double logarithm(double x)
{
    constexpr std::uint64_t k_root_half = 0x3fe6a09e667f3bcd, k_mantissa = 0x000fffffffffffff;
    const std::uint64_t above = std::bit_cast<std::uint64_t>(x) - k_root_half;
    const auto exponent = static_cast<std::int32_t>(static_cast<std::int64_t>(above) >> 52);
    // m in [sqrt(1/2), sqrt(2)): log m = 2 artanh t
    const double m = std::bit_cast<double>((above & k_mantissa) + k_root_half);
    const double t = (m - 1) / (m + 1), t2 = t * t;
    double series = 1.0 / 17;
    for (const double term : {1.0 / 15, 1.0 / 13, 1.0 / 11, 1.0 / 9, 1.0 / 7, 1.0 / 5, 1.0 / 3, 1.0})
        series = series * t2 + term;
    return exponent * std::numbers::ln2 + 2 * t * series;
}

// Minus the mean logarithm of the transformed distribution (without its constant).
double misfit(const std::vector<Direction>& lobe, double alpha, double mirror_angle, const CosineFit& f)
{
    const glm::dmat3 inverse = glm::inverse(cosine_matrix(alpha, mirror_angle, f));
    const double determinant = std::abs(glm::determinant(inverse));
    std::array<double, k_side * k_side> terms;
    for (std::size_t i = 0; i < lobe.size(); ++i) {
        const glm::dvec3 w = inverse * lobe[i].at;
        const double square = glm::dot(w, w);
        // D = cos(w) / |w|^3 * |M^-1|, with cos(w) = w.z / |w|
        const double density = w.z > 0 ? w.z / (square * square) * determinant : 0;
        terms[i] = lobe[i].weight * logarithm(std::max(density, 1e-30));
    }
    double product_sum = 0;
    for (std::size_t i = 0; i < lobe.size(); ++i) product_sum += terms[i];
    return -product_sum;
}

using Point = std::array<double, 4>;   // log a, log b, c, tilt / alpha

CosineFit fit_of(const Point& p, double alpha)
{
    return {std::exp(p[0]), std::exp(p[1]), p[2], p[3] * alpha, 1};
}

// Finds the least misfit by the simplex method [Nelder and Mead 1965].
Point search(const std::vector<Direction>& lobe, double alpha, double mirror_angle, const Point& start)
{
    constexpr std::size_t n = 4;
    std::array<std::pair<double, Point>, n + 1> simplex;
    // A shear and a tilt do nearly the same: keep the shear small, so that neighbouring fits are alike.
    const auto value = [&](const Point& p) {
        return misfit(lobe, alpha, mirror_angle, fit_of(p, alpha)) + k_shear_penalty * p[2] * p[2];
    };
    for (std::size_t i = 0; i <= n; ++i) {
        Point p = start;
        if (i > 0) p[i - 1] += 0.1;
        simplex[i] = {value(p), p};
    }
    const auto along = [](const Point& from, const Point& to, double t) {
        Point p;
        for (std::size_t k = 0; k < n; ++k) p[k] = from[k] + t * (to[k] - from[k]);
        return p;
    };
    for (int step = 0; step < k_steps; ++step) {
        std::stable_sort(simplex.begin(), simplex.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        Point centre{};
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t k = 0; k < n; ++k) centre[k] += simplex[i].second[k] / static_cast<double>(n);
        auto& worst = simplex[n];
        const Point mirrored = along(worst.second, centre, 2);
        const double at_mirrored = value(mirrored);
        if (at_mirrored < simplex[0].first) {
            const Point further = along(worst.second, centre, 3);
            const double at_further = value(further);
            worst = at_further < at_mirrored ? std::pair(at_further, further) : std::pair(at_mirrored, mirrored);
        } else if (at_mirrored < simplex[n - 1].first) {
            worst = {at_mirrored, mirrored};
        } else {
            const Point nearer = along(worst.second, centre, at_mirrored < worst.first ? 1.5 : 0.5);
            const double at_nearer = value(nearer);
            if (at_nearer < std::min(at_mirrored, worst.first)) {
                worst = {at_nearer, nearer};
            } else {
                for (std::size_t i = 1; i <= n; ++i) {
                    simplex[i].second = along(simplex[0].second, simplex[i].second, 0.5);
                    simplex[i].first = value(simplex[i].second);
                }
            }
        }
    }
    return std::min_element(simplex.begin(), simplex.end(),
                            [](const auto& a, const auto& b) { return a.first < b.first; })
        ->second;
}

// The fraction of the transformed cosine that lies above the surface: all directions of the cosine, transformed.
double kept(double alpha, double mirror_angle, const CosineFit& f)
{
    constexpr int side = 32;
    static const std::vector<glm::dvec3> k_cosine = [] {
        std::vector<glm::dvec3> directions;
        for (int i = 0; i < side; ++i)
            for (int j = 0; j < side; ++j) {
                const double u = (i + 0.5) / side, phi = 2 * k_pi * (j + 0.5) / side, r = std::sqrt(u);
                directions.emplace_back(r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u));
            }
        return directions;
    }();
    const glm::dmat3 m = cosine_matrix(alpha, mirror_angle, f);
    int above = 0;
    for (const glm::dvec3& direction : k_cosine) above += (m * direction).z > 0;
    return static_cast<double>(above) / (side * side);
}

double roughness_of_row(int row)
{
    return k_first_cosine_roughness + (1 - k_first_cosine_roughness) * row / (k_cosine_rows - 1);
}

// Columns are evenly spaced in the sine of half the angle of the view.
double cosine_of_column(int column)
{
    const double t = 1 - static_cast<double>(column) / (k_cosine_columns - 1);
    return std::max(1 - t * t, k_least_view_cosine);
}

void fit_row(int row, CosineFits& fits)
{
    const double roughness = roughness_of_row(row), alpha = roughness * roughness;
    Point p{std::log(0.5), std::log(0.5), 0, 0};
    // From the steepest view to the most grazing one: each starts from the fit before.
    for (int column = k_cosine_columns - 1; column >= 0; --column) {
        const double n_v = cosine_of_column(column);
        SurfacePoint s;
        s.geometric_normal = s.normal = s.smooth_normal = {0, 0, 1};
        s.to_viewer = glm::vec3(glm::dvec3(std::sqrt(1 - n_v * n_v), 0, n_v));
        s.specular = glm::vec3(1);
        s.roughness = static_cast<float>(roughness);
        const double mirror_angle = std::acos(n_v);
        p = search(directions(s), alpha, mirror_angle, p);
        CosineFit& fit = fits[static_cast<std::size_t>(row * k_cosine_columns + column)];
        fit = fit_of(p, alpha);
        fit.scale = 1 / std::max(kept(alpha, mirror_angle, fit), 0.25);
        fit.tilt /= alpha;
    }
}

}   // namespace

glm::dmat3 cosine_matrix(double alpha, double mirror_angle, const CosineFit& f)
{
    // The mirror direction lies at x <= 0.
    const double turn = mirror_angle - f.tilt;
    const glm::dvec3 z(-std::sin(turn), 0, std::cos(turn)), x(std::cos(turn), 0, std::sin(turn)), y(0, 1, 0);
    const glm::dmat3 inner(glm::dvec3(f.a * alpha, 0, 0), glm::dvec3(0, f.b * alpha, 0), glm::dvec3(f.c * alpha, 0, 1));
    return glm::dmat3(x, y, z) * inner;
}

CosineFits fitted_cosines()
{
    CosineFits fits;
    for (int row = 0; row < k_cosine_rows; ++row) fit_row(row, fits);
    return fits;
}

}   // namespace gnomon::shading
