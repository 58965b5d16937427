// SPDX-License-Identifier: Apache-2.0
#include "image/image_metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/check.h"
#include "base/math.h"

namespace gnomon::image {

namespace {
constexpr double k_relative_floor = 0.01;   // epsilon of relmse
constexpr int k_window = 11;                // of ssim, pixels
constexpr double k_window_sigma = 1.5;
constexpr double k_1 = 0.01, k_2 = 0.03;
constexpr int k_band = 32;   // rows of windows processed at once

void check_alike(const ImageF& a, const ImageF& b)
{
    GNOMON_CHECK(a.width == b.width && a.height == b.height && a.channels == b.channels && !a.empty());
}

double sane(float value)
{
    constexpr float largest = std::numeric_limits<float>::max();
    return std::isnan(value) ? 0.0 : static_cast<double>(std::clamp(value, -largest, largest));
}

template <class Term>
double mean_over_values(const ImageF& test, const ImageF& reference, Term term)
{
    check_alike(test, reference);
    double sum = 0;
    for (std::size_t i = 0; i < test.data.size(); ++i) sum += term(sane(test.data[i]), sane(reference.data[i]));
    return sum / static_cast<double>(test.data.size());
}

// The value that windows cover: luminance, or one channel.
double gray(const ImageF& image, int x, int y, int channel)
{
    const float* p = image.pixel(x, y);
    if (channel >= 0) return sane(p[channel]);
    return luminance(glm::dvec3(sane(p[0]), sane(p[1]), sane(p[2])));
}

// Positions of windows along one axis, and their weights, which sum to 1 even if cut.
struct Windows {
    int first = 0, count = 0;   // centres
    int length = 0;             // of the axis

    explicit Windows(int n) : length(n)
    {
        const bool whole = n >= k_window;
        first = whole ? k_window / 2 : 0;
        count = whole ? n - k_window + 1 : n;
    }
    int begin(int centre) const { return std::max(0, centre - k_window / 2); }
    int end(int centre) const { return std::min(length, centre + k_window / 2 + 1); }
    double weight(int centre, int i) const
    {
        double sum = 0;
        for (int j = begin(centre); j < end(centre); ++j) sum += tap(j - centre);
        return tap(i - centre) / sum;
    }
    static double tap(int d) { return std::exp(-d * d / (2 * k_window_sigma * k_window_sigma)); }
};

using Moments = std::array<double, 5>;   // means of a, b, a^2, b^2, a b

double ssim_of_channel(const ImageF& a, const ImageF& b, int channel, double range, Tasks& tasks)
{
    const Windows across(a.width), down(a.height);
    const double c1 = k_1 * k_1 * range * range, c2 = k_2 * k_2 * range * range;

    // Compute weights per centre; they differ only where windows are cut.
    const auto weights_of = [](const Windows& w) {
        std::vector<std::array<double, k_window>> all(static_cast<std::size_t>(w.count));
        for (int i = 0; i < w.count; ++i) {
            const int centre = w.first + i;
            if (i > 0 && w.length >= k_window) {
                all[static_cast<std::size_t>(i)] = all[0];
                continue;
            }
            for (int j = w.begin(centre); j < w.end(centre); ++j)
                all[static_cast<std::size_t>(i)][static_cast<std::size_t>(j - w.begin(centre))] = w.weight(centre, j);
        }
        return all;
    };
    const auto weight_x = weights_of(across), weight_y = weights_of(down);

    std::vector<double> row_sums(static_cast<std::size_t>(down.count));
    const int bands = (down.count + k_band - 1) / k_band;
    tasks.for_each(static_cast<std::size_t>(bands), [&](std::size_t band, int) {
        const int first = static_cast<int>(band) * k_band, last = std::min(first + k_band, down.count) - 1;
        const int top = down.begin(down.first + first), bottom = down.end(down.first + last);

        // Compute moments along the rows that this band's windows touch.
        const auto width = static_cast<std::size_t>(across.count);
        std::vector<Moments> moments(static_cast<std::size_t>(bottom - top) * width);
        std::vector<double> row_a(static_cast<std::size_t>(a.width)), row_b(row_a.size());
        for (int y = top; y < bottom; ++y) {
            for (int x = 0; x < a.width; ++x) {
                row_a[static_cast<std::size_t>(x)] = gray(a, x, y, channel);
                row_b[static_cast<std::size_t>(x)] = gray(b, x, y, channel);
            }
            for (std::size_t x = 0; x < width; ++x) {
                const int centre = across.first + static_cast<int>(x), begin = across.begin(centre);
                Moments& m = moments[static_cast<std::size_t>(y - top) * width + x];
                for (int j = begin; j < across.end(centre); ++j) {
                    const double w = weight_x[x][static_cast<std::size_t>(j - begin)];
                    const double p = row_a[static_cast<std::size_t>(j)], q = row_b[static_cast<std::size_t>(j)];
                    m[0] += w * p, m[1] += w * q, m[2] += w * (p * p), m[3] += w * (q * q), m[4] += w * (p * q);
                }
            }
        }
        // Then sum down the columns and compute the index [Wang et al. 2004, eq. 13].
        for (int i = first; i <= last; ++i) {
            const int centre = down.first + i, begin = down.begin(centre);
            double sum = 0;
            for (std::size_t x = 0; x < width; ++x) {
                Moments m{};
                for (int j = begin; j < down.end(centre); ++j) {
                    const double w = weight_y[static_cast<std::size_t>(i)][static_cast<std::size_t>(j - begin)];
                    const Moments& part = moments[static_cast<std::size_t>(j - top) * width + x];
                    for (std::size_t k = 0; k < m.size(); ++k) m[k] += w * part[k];
                }
                const double aa = m[0] * m[0], bb = m[1] * m[1], ab = m[0] * m[1];
                sum += (2 * ab + c1) * (2 * (m[4] - ab) + c2) / ((aa + bb + c1) * (m[2] - aa + m[3] - bb + c2));
            }
            row_sums[static_cast<std::size_t>(i)] = sum;
        }
    });
    double total = 0;
    for (const double sum : row_sums) total += sum;
    return total / (static_cast<double>(across.count) * static_cast<double>(down.count));
}
}   // namespace

double mean_squared_error(const ImageF& test, const ImageF& reference)
{
    return mean_over_values(test, reference, [](double a, double b) { return (a - b) * (a - b); });
}

double relative_mse(const ImageF& test, const ImageF& reference)
{
    return mean_over_values(test, reference,
                            [](double a, double b) { return (a - b) * (a - b) / (b * b + k_relative_floor); });
}

std::optional<double> psnr(double mse, double peak)
{
    if (!(mse > 0)) return std::nullopt;
    return 10 * std::log10(peak * peak / mse);
}

double max_abs_difference(const ImageF& test, const ImageF& reference)
{
    check_alike(test, reference);
    double largest = 0;
    for (std::size_t i = 0; i < test.data.size(); ++i)
        largest = std::max(largest, std::abs(sane(test.data[i]) - sane(reference.data[i])));
    return largest;
}

double pixels_different(const ImageF& test, const ImageF& reference)
{
    check_alike(test, reference);
    const auto channels = static_cast<std::size_t>(test.channels);
    std::size_t different = 0;
    for (std::size_t i = 0; i < test.data.size(); i += channels) {
        bool differs = false;
        for (std::size_t c = i; c < i + channels; ++c) {
            const float a = test.data[c], b = reference.data[c];
            differs = differs || !(a == b || (std::isnan(a) && std::isnan(b)));
        }
        different += differs;
    }
    return static_cast<double>(different) / (static_cast<double>(test.data.size()) / test.channels);
}

double ssim(const ImageF& test, const ImageF& reference, double range, Tasks& tasks)
{
    check_alike(test, reference);
    GNOMON_CHECK(range > 0);
    if (test.channels == 3) return ssim_of_channel(test, reference, -1, range, tasks);
    double sum = 0;
    for (int c = 0; c < test.channels; ++c) sum += ssim_of_channel(test, reference, c, range, tasks);
    return sum / test.channels;
}

}   // namespace gnomon::image
