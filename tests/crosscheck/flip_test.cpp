// SPDX-License-Identifier: Apache-2.0
// FLIP against its reference implementation: the paper's two-dimensional filters, tap by tap, in double precision.
#include "image/flip.h"

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "base/math.h"
#include "base/random.h"

namespace gnomon::render {
namespace {

using Color = glm::dvec3;
using Plane = std::vector<Color>;

struct SlowFlip {
    int width, height;
    double ppd = 67;

    // sRGB primaries and D65 [IEC 61966-2-1], with the digits of the paper's matrix.
    static glm::dmat3 xyz_from_rgb()
    {
        return {{0.41238656, 0.21263682, 0.01933062},
                {0.35759149, 0.71518298, 0.11919716},
                {0.18045049, 0.07218020, 0.95037259}};
    }
    static Color white() { return xyz_from_rgb() * Color(1); }

    static Color lab(const Color& rgb)
    {
        const Color t = xyz_from_rgb() * rgb / white();
        const auto f = [](double v) {
            return v > std::pow(6.0 / 29, 3) ? std::cbrt(v) : v * std::pow(29.0 / 6, 2) / 3 + 4.0 / 29;
        };
        const double lightness = 116 * f(t.y) - 16;
        return {lightness, 0.01 * lightness * 500 * (f(t.x) - f(t.y)), 0.01 * lightness * 200 * (f(t.y) - f(t.z))};
    }
    static double hyab(const Color& a, const Color& b)
    {
        return std::abs(a.x - b.x) + std::sqrt((a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z));
    }

    template <class Value>
    Value filtered(const std::vector<Value>& in, int x, int y, int radius,
                   const std::function<double(int, int)>& kernel) const
    {
        Value sum(0);
        for (int j = -radius; j <= radius; ++j)
            for (int i = -radius; i <= radius; ++i) {
                const int px = std::clamp(x + i, 0, width - 1), py = std::clamp(y + j, 0, height - 1);
                sum +=
                    kernel(i, j) *
                    in[static_cast<std::size_t>(py) * static_cast<std::size_t>(width) + static_cast<std::size_t>(px)];
            }
        return sum;
    }

    std::vector<double> run(const ImageF& test, const ImageF& reference) const
    {
        const std::array<const ImageF*, 2> images{&test, &reference};
        std::array<Plane, 2> seen;
        std::array<std::vector<double>, 2> edges, points;
        for (std::size_t k = 0; k < 2; ++k) look(*images[k], seen[k], edges[k], points[k]);
        const double largest = std::pow(hyab(lab({0, 1, 0}), lab({0, 0, 1})), 0.7);
        std::vector<double> errors;
        for (std::size_t i = 0; i < seen[0].size(); ++i) {
            const double power = std::pow(hyab(seen[0][i], seen[1][i]), 0.7);
            const double knee = 0.4 * largest;
            const double color = power < knee ? 0.95 * power / knee : 0.95 + 0.05 * (power - knee) / (largest - knee);
            const double feature = std::sqrt(
                std::max(std::abs(edges[0][i] - edges[1][i]), std::abs(points[0][i] - points[1][i])) / std::sqrt(2.0));
            errors.push_back(std::pow(color, 1 - feature));
        }
        return errors;
    }

    void look(const ImageF& image, Plane& seen, std::vector<double>& edges, std::vector<double>& points) const
    {
        Plane opponent;
        std::vector<double> bright;
        for (int i = 0; i < width * height; ++i) {
            const float* p = &image.data[static_cast<std::size_t>(i) * 3];
            const Color t = xyz_from_rgb() * Color(p[0], p[1], p[2]) / white();
            opponent.emplace_back(116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z));
            bright.push_back(t.y);
        }
        const int blur = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * k_pi * k_pi)) * ppd));
        const auto gauss = [&](double a, double b, int i, int j) {
            return a * std::sqrt(k_pi / b) * std::exp(-k_pi * k_pi * (i * i + j * j) / (ppd * ppd) / b);
        };
        const std::function<double(int, int)> contrast[3] = {
            [&](int i, int j) { return gauss(1, 0.0047, i, j); }, [&](int i, int j) { return gauss(1, 0.0053, i, j); },
            [&](int i, int j) { return gauss(34.1, 0.04, i, j) + gauss(13.5, 0.025, i, j); }};
        const double sigma = 0.5 * 0.082 * ppd;
        const int reach = static_cast<int>(std::ceil(3 * sigma));
        const auto bell = [&](int i, int j) { return std::exp(-(i * i + j * j) / (2 * sigma * sigma)); };
        const std::function<double(int, int)> edge = [&](int i, int j) { return -i * bell(i, j); };
        const std::function<double(int, int)> point = [&](int i, int j) {
            return (i * i / (sigma * sigma) - 1) * bell(i, j);
        };
        const auto sums = [](const std::function<double(int, int)>& kernel, int radius) {
            std::array<double, 2> result{0, 0};   // sums of the positive taps and of the negative ones
            for (int j = -radius; j <= radius; ++j)
                for (int i = -radius; i <= radius; ++i) result[kernel(i, j) < 0] += std::abs(kernel(i, j));
            return result;
        };
        const std::array<double, 2> edge_sums = sums(edge, reach), point_sums = sums(point, reach);
        double contrast_sums[3];
        for (int c = 0; c < 3; ++c) contrast_sums[c] = sums(contrast[c], blur)[0];

        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                Color o;
                for (int c = 0; c < 3; ++c) o[c] = filtered(opponent, x, y, blur, contrast[c])[c] / contrast_sums[c];
                const double l = (o.x + 16) / 116;
                const Color xyz = Color(l + o.y / 500, l, l - o.z / 200) * white();
                seen.push_back(lab(glm::clamp(glm::inverse(xyz_from_rgb()) * xyz, 0.0, 1.0)));
                const auto feature = [&](const std::function<double(int, int)>& kernel,
                                         const std::array<double, 2>& weight) {
                    const auto even = [&](int i, int j) { return kernel(i, j) / weight[kernel(i, j) < 0]; };
                    const double across = filtered(bright, x, y, reach, even);
                    const double down = filtered(bright, x, y, reach, [&](int i, int j) { return even(j, i); });
                    return std::hypot(across, down);
                };
                edges.push_back(feature(edge, edge_sums));
                points.push_back(feature(point, point_sums));
            }
    }
};

TEST(FlipReference, AgreesOnNoiseAndShapes)
{
    ImageF a(38, 35, 3), b(38, 35, 3);   // two bands of rows, the last one short
    Random random(6);
    for (std::size_t i = 0; i < a.data.size(); ++i) {
        a.data[i] = random.uniform();
        b.data[i] = std::clamp(a.data[i] + random.uniform(-0.2f, 0.2f), 0.0f, 1.0f);
    }
    for (int y = 8; y < 20; ++y)
        for (int x = 5; x < 30; ++x) a.pixel(x, y)[0] = 1, b.pixel(x, y)[2] = 0;
    b.pixel(33, 30)[0] = b.pixel(33, 30)[1] = b.pixel(33, 30)[2] = 1;

    Tasks tasks(2);
    const ImageF fast = image::flip_ldr(a, b, tasks);
    const std::vector<double> slow = SlowFlip{38, 35}.run(a, b);
    double largest = 0;
    for (std::size_t i = 0; i < slow.size(); ++i) {
        ASSERT_NEAR(fast.data[i], slow[i], 1e-3) << i % 38 << ' ' << i / 38;
        largest = std::max(largest, slow[i]);
    }
    EXPECT_GT(largest, 0.5);
}

}   // namespace
}   // namespace gnomon::render
