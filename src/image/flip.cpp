// SPDX-License-Identifier: Apache-2.0
#include "image/flip.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "base/check.h"
#include "base/math.h"
#include "image/flip_filters.h"

namespace gnomon::image {

namespace {
constexpr double k_color_power = 0.7;         // q_c
constexpr double k_feature_power = 0.5;       // q_f
constexpr double k_p_c = 0.4, k_p_t = 0.95;   // the fraction p_c of the largest difference maps to the error p_t
constexpr int k_band = 32;                    // rows processed at once

// HDR: the exposures at which the brightest and the median luminance reach this fraction of the tone curve's range.
constexpr double k_exposure_target = 0.85;
constexpr double k_darkest = 1.1920929e-7;   // least luminance that counts as light

// Narkowicz's curve (a x^2 + b x) / (c x^2 + d x + e), with his exposure factor of 0.6 folded in.
struct Curve {
    double a = 0.6 * 0.6 * 2.51, b = 0.6 * 0.03, c = 0.6 * 0.6 * 2.43, d = 0.6 * 0.59, e = 0.14;
    float operator()(float x) const
    {
        const auto p = [x](double q) { return static_cast<float>(q) * x; };
        return x * (p(a) + static_cast<float>(b)) / (x * (p(c) + static_cast<float>(d)) + static_cast<float>(e));
    }
};

// Colour spaces: linear RGB (sRGB primaries, D65), XYZ, Y Cx Cz, L*a*b*.

const glm::mat3 k_xyz_from_rgb(10135552.0f / 24577794, 2613072.0f / 12288897, 1425312.0f / 73733382.0f,   // column R
                               8788810.0f / 24577794, 8788810.0f / 12288897, 8788810.0f / 73733382.0f,    // G
                               4435075.0f / 24577794, 887015.0f / 12288897, 70074185.0f / 73733382.0f);   // B
const glm::mat3 k_rgb_from_xyz = glm::inverse(k_xyz_from_rgb);
const glm::vec3 k_white = k_xyz_from_rgb * glm::vec3(1);

// Opponent space, linear in light: Y from -16 to 100, red-green, blue-yellow.
glm::vec3 opponent(const glm::vec3& rgb)
{
    const glm::vec3 t = k_xyz_from_rgb * rgb / k_white;
    return {116 * t.y - 16, 500 * (t.x - t.y), 200 * (t.y - t.z)};
}

glm::vec3 rgb_from_opponent(const glm::vec3& o)
{
    const float y = (o.x + 16) / 116;
    return k_rgb_from_xyz * (glm::vec3(y + o.y / 500, y, y - o.z / 200) * k_white);
}

float lab_curve(float t)
{
    constexpr float delta = 6.0f / 29;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
}

// L*a*b* with chroma scaled by lightness: colours look more saturated in bright light (Hunt effect) [2020, 4.1].
glm::vec3 hunt_lab(const glm::vec3& rgb)
{
    const glm::vec3 t = k_xyz_from_rgb * rgb / k_white;
    const glm::vec3 f(lab_curve(t.x), lab_curve(t.y), lab_curve(t.z));
    const float lightness = 116 * f.y - 16;
    return {lightness, 0.01f * lightness * 500 * (f.x - f.y), 0.01f * lightness * 200 * (f.y - f.z)};
}

float hyab(const glm::vec3& p, const glm::vec3& q)
{
    return std::abs(p.x - q.x) + std::hypot(p.y - q.y, p.z - q.z);
}

// An image displayed at one exposure.
struct Shown {
    const ImageF& image;
    bool tone_mapped = false;
    float factor = 1;

    glm::vec3 at(int x, int y) const
    {
        const float* p = image.pixel(x, y);
        glm::vec3 result;
        for (int c = 0; c < 3; ++c) {
            float value = p[c] > 0 ? p[c] : 0.0f;   // NaN compares false
            if (tone_mapped) {
                constexpr float brightest = 1e9f;   // far up the curve's shoulder; its square is finite
                value = Curve()(std::min(value * factor, brightest));
            }
            result[c] = std::min(value, 1.0f);
        }
        return result;
    }
};

// The perceived appearance of a band of rows.
struct Appearance {
    FlipField lab;        // L a' b' of the blurred image
    FlipField features;   // x: strength of edges, y: strength of points
};

struct Scratch {
    FlipField light, between, filtered;
    Appearance test, reference;
};

void perceive(const Shown& shown, const FlipFilters& filters, int first, int rows, Scratch& scratch, Appearance& out)
{
    const int width = shown.image.width, height = shown.image.height;
    const int border = std::max(filters.contrast.radius, filters.features.radius);

    // Convert to opponent colours; repeat edge pixels outwards.
    FlipField& light = scratch.light;
    light.resize(width + 2 * border, rows + 2 * border);
    for (int y = 0; y < light.rows; ++y) {
        glm::vec4* row = light.row(y);
        const int from = std::clamp(first + y - border, 0, height - 1);
        for (int x = 0; x < width; ++x) {
            const glm::vec3 o = opponent(shown.at(x, from));
            row[x + border] = {o.x, o.y, o.z, o.z};
        }
        std::fill(row, row + border, row[border]);
        std::fill(row + border + width, row + light.width, row[border + width - 1]);
    }

    // Blur with the contrast sensitivity, clamp to displayable colours, and convert to L*a*b*.
    apply(filters.contrast, light, border, scratch.between, scratch.filtered);
    out.lab.resize(width, rows);
    for (std::size_t i = 0; i < out.lab.data.size(); ++i) {
        const glm::vec4& f = scratch.filtered.data[i];
        const glm::vec3 o(f.x, f.y, f.z * filters.blue_yellow_weight[0] + f.w * filters.blue_yellow_weight[1]);
        out.lab.data[i] = glm::vec4(hunt_lab(glm::clamp(rgb_from_opponent(o), 0.0f, 1.0f)), 0);
    }

    // Detect edges and points in the achromatic channel, scaled to 0 ... 1.
    for (glm::vec4& p : light.data) p = glm::vec4((p.x + 16) / 116);
    apply(filters.features, light, border, scratch.between, scratch.filtered);
    out.features.resize(width, rows);
    for (std::size_t i = 0; i < out.features.data.size(); ++i) {
        const glm::vec4& f = scratch.filtered.data[i];
        out.features.data[i] = {std::hypot(f.x, f.z), std::hypot(f.y, f.w), 0, 0};
    }
}

// Raises the colour difference to a power and maps it to 0 ... 1 in two linear segments [2020, 4.1, eq. 7 and 8].
float color_error(float difference, float largest)
{
    const float power = std::pow(difference, static_cast<float>(k_color_power));
    const float knee = static_cast<float>(k_p_c) * largest;
    const auto p_t = static_cast<float>(k_p_t);
    return power < knee ? p_t / knee * power : p_t + (power - knee) / (largest - knee) * (1 - p_t);
}

struct Exposure {
    bool tone_mapped;
    float factor;
};

ImageF flip(const ImageF& test, const ImageF& reference, const std::vector<Exposure>& exposures, Tasks& tasks,
            const FlipOptions& options)
{
    GNOMON_CHECK(test.channels == 3 && reference.channels == 3);
    GNOMON_CHECK(test.width == reference.width && test.height == reference.height && !test.empty());
    GNOMON_CHECK(options.pixels_per_degree > 0);
    const FlipFilters filters = make_flip_filters(options.pixels_per_degree);
    const float largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), static_cast<float>(k_color_power));

    ImageF errors(test.width, test.height, 1);
    const int bands = (test.height + k_band - 1) / k_band;
    std::vector<Scratch> workers(static_cast<std::size_t>(tasks.threads()));
    tasks.for_each(static_cast<std::size_t>(bands), [&](std::size_t band, int worker) {
        Scratch& scratch = workers[static_cast<std::size_t>(worker)];
        const int first = static_cast<int>(band) * k_band, rows = std::min(k_band, test.height - first);
        // Skip pixels around which the images are equal within the reach of all filters.
        const int reach = std::max(filters.contrast.radius, filters.features.radius);
        const int top = std::max(0, first - reach), bottom = std::min(test.height, first + rows + reach);
        if (std::equal(test.pixel(0, top), test.pixel(0, bottom), reference.pixel(0, top))) return;
        for (const Exposure& e : exposures) {
            perceive({test, e.tone_mapped, e.factor}, filters, first, rows, scratch, scratch.test);
            perceive({reference, e.tone_mapped, e.factor}, filters, first, rows, scratch, scratch.reference);
            float* error = errors.pixel(0, first);
            for (std::size_t i = 0; i < scratch.test.lab.data.size(); ++i) {
                const float color = color_error(hyab(scratch.test.lab.data[i], scratch.reference.lab.data[i]), largest);
                const glm::vec4 d = glm::abs(scratch.test.features.data[i] - scratch.reference.features.data[i]);
                const float feature =
                    std::pow(std::max(d.x, d.y) / std::numbers::sqrt2_v<float>, static_cast<float>(k_feature_power));
                // Combine colour and feature errors [2020, eq. 12].
                error[i] = std::max(error[i], std::pow(color, 1 - std::min(feature, 1.0f)));
            }
        }
    });
    return errors;
}
}   // namespace

ImageF flip_ldr(const ImageF& test, const ImageF& reference, Tasks& tasks, const FlipOptions& options)
{
    return flip(test, reference, {{false, 1}}, tasks, options);
}

ImageF flip_hdr(const ImageF& test, const ImageF& reference, Tasks& tasks, const FlipOptions& options)
{
    const FlipExposures range = flip_exposures(reference);
    std::vector<Exposure> exposures;
    for (int i = 0; i < range.count; ++i) {
        const double stops = range.first + (range.last - range.first) * i / (range.count - 1);
        exposures.push_back({true, static_cast<float>(std::exp2(stops))});
    }
    return flip(test, reference, exposures, tasks, options);
}

FlipExposures flip_exposures(const ImageF& reference)
{
    GNOMON_CHECK(reference.channels == 3 && !reference.empty());
    // Find where the curve reaches the target: the larger root of (a - t c) x^2 + (b - t d) x - t e = 0.
    const Curve curve;
    const double t = k_exposure_target;
    const double a = curve.a - t * curve.c, b = curve.b - t * curve.d, c = -t * curve.e;
    const double shown = (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);

    std::vector<float> light(reference.data.size() / 3);
    for (std::size_t i = 0; i < light.size(); ++i) {
        const float* p = &reference.data[i * 3];
        const float l = luminance(glm::vec3(p[0], p[1], p[2]));
        light[i] = l > 0 ? std::min(l, std::numeric_limits<float>::max()) : 0.0f;
    }
    const auto middle = light.begin() + static_cast<std::ptrdiff_t>((light.size() - 1) / 2);
    std::nth_element(light.begin(), middle, light.end());
    const double median = std::max<double>(*middle, k_darkest);
    const double brightest = std::max<double>(*std::max_element(light.begin(), light.end()), k_darkest);
    FlipExposures range{std::log2(shown / brightest), std::log2(shown / median), 2};
    range.count = std::max(2, static_cast<int>(std::ceil(range.last - range.first)));
    return range;
}

double mean_of(const ImageF& map)
{
    double sum = 0;
    for (const float value : map.data) sum += value;
    return map.data.empty() ? 0 : sum / static_cast<double>(map.data.size());
}

Image8 heat_map(const ImageF& map)
{
    // Nine samples of magma, a perceptually uniform colour map from black over violet to pale yellow.
    constexpr std::array<std::array<float, 3>, 9> stations{{{0, 0, 4},
                                                            {28, 16, 68},
                                                            {79, 18, 123},
                                                            {129, 37, 129},
                                                            {181, 54, 122},
                                                            {229, 80, 100},
                                                            {251, 135, 97},
                                                            {254, 194, 135},
                                                            {252, 253, 191}}};
    Image8 image(map.width, map.height, 3);
    for (std::size_t i = 0; i < map.data.size(); ++i) {
        const float at = std::clamp(map.data[i], 0.0f, 1.0f) * (stations.size() - 1);
        const auto low = std::min(static_cast<std::size_t>(at), stations.size() - 2);
        const float t = at - static_cast<float>(low);
        for (std::size_t c = 0; c < 3; ++c)
            image.data[i * 3 + c] =
                static_cast<std::uint8_t>(stations[low][c] + t * (stations[low + 1][c] - stations[low][c]) + 0.5f);
    }
    return image;
}

}   // namespace gnomon::image
