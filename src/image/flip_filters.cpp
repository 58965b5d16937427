// SPDX-License-Identifier: Apache-2.0
#include "image/flip_filters.h"

#include <algorithm>
#include <limits>

namespace gnomon::image {

namespace {
// Contrast sensitivity: sums of Gaussians a sqrt(pi/b) exp(-pi^2 x^2 / b), x in degrees [2020, Table 1].
struct Lobe {
    double a, b;
};
constexpr Lobe k_achromatic{1, 0.0047}, k_red_green{1, 0.0053}, k_blue_yellow[2] = {{34.1, 0.04}, {13.5, 0.025}};
constexpr double k_feature_width = 0.082;   // degrees [2020, 4.2]
}   // namespace

FlipFilters make_flip_filters(double pixels_per_degree)
{
    FlipFilters filters;

    // Compute the Gaussians of the contrast sensitivity, each with sum 1.
    const double widest = std::max({k_achromatic.b, k_red_green.b, k_blue_yellow[0].b, k_blue_yellow[1].b});
    const int r = static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * k_pi * k_pi)) * pixels_per_degree));
    const auto count = 2 * static_cast<std::size_t>(r) + 1;
    filters.contrast.radius = r;
    filters.contrast.across.resize(count);
    const Lobe lobes[4] = {k_achromatic, k_red_green, k_blue_yellow[0], k_blue_yellow[1]};
    double volume[4];   // of the two-dimensional lobe
    for (int c = 0; c < 4; ++c) {
        const auto tap = [&](int i) {
            const double x = i / pixels_per_degree;
            return std::exp(-k_pi * k_pi * x * x / lobes[c].b);
        };
        double sum = 0;
        for (int i = -r; i <= r; ++i) sum += tap(i);
        for (std::size_t i = 0; i < count; ++i)
            filters.contrast.across[i][c] = static_cast<float>(tap(static_cast<int>(i) - r) / sum);
        volume[c] = lobes[c].a * std::sqrt(k_pi / lobes[c].b) * sum * sum;
    }
    filters.contrast.down = filters.contrast.across;
    for (int c = 0; c < 2; ++c)
        filters.blue_yellow_weight[c] = static_cast<float>(volume[2 + c] / (volume[2] + volume[3]));

    // Compute the first and second derivative of a Gaussian; positive taps sum to 1, negative ones to -1.
    const double sigma = 0.5 * k_feature_width * pixels_per_degree;
    const int s = static_cast<int>(std::ceil(3 * sigma));
    std::vector<double> gauss, edge, point;
    for (int i = -s; i <= s; ++i) {
        const double g = std::exp(-i * i / (2 * sigma * sigma));
        gauss.push_back(g);
        edge.push_back(-i * g);
        point.push_back((i * i / (sigma * sigma) - 1) * g);
    }
    const auto normalise = [](std::vector<double>& taps) {
        double positive = 0, negative = 0;
        for (const double t : taps) (t > 0 ? positive : negative) += std::abs(t);
        for (double& t : taps) t /= t > 0 ? positive : std::max(negative, std::numeric_limits<double>::min());
    };
    for (auto* taps : {&gauss, &edge, &point}) normalise(*taps);
    filters.features.radius = s;
    for (std::size_t i = 0; i < gauss.size(); ++i) {
        filters.features.across.emplace_back(edge[i], point[i], gauss[i], gauss[i]);
        filters.features.down.emplace_back(gauss[i], gauss[i], edge[i], point[i]);
    }
    return filters;
}

void FlipField::resize(int w, int h)
{
    width = w, rows = h;
    data.resize(static_cast<std::size_t>(w) * static_cast<std::size_t>(h));
}

void apply(const FlipFilter& filter, const FlipField& in, int border, FlipField& between, FlipField& out)
{
    const int r = filter.radius, width = in.width - 2 * border, rows = in.rows - 2 * border;
    between.resize(width, rows + 2 * r);
    for (int y = 0; y < between.rows; ++y) {
        const glm::vec4* from = in.row(y + border - r) + (border - r);
        glm::vec4* to = between.row(y);
        for (int x = 0; x < width; ++x) {
            glm::vec4 sum(0);
            for (int i = 0; i <= 2 * r; ++i) sum += filter.across[static_cast<std::size_t>(i)] * from[x + i];
            to[x] = sum;
        }
    }
    out.resize(width, rows);
    for (int y = 0; y < rows; ++y) {
        glm::vec4* to = out.row(y);
        std::fill(to, to + width, glm::vec4(0));
        for (int i = 0; i <= 2 * r; ++i) {
            const glm::vec4 tap = filter.down[static_cast<std::size_t>(i)];
            const glm::vec4* from = between.row(y + i);
            for (int x = 0; x < width; ++x) to[x] += tap * from[x];
        }
    }
}

}   // namespace gnomon::image
