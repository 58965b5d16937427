// SPDX-License-Identifier: Apache-2.0
#include "bench/indirect/images.h"

#include <algorithm>
#include <cmath>

#include "base/check.h"
#include "base/math.h"
#include "bench/report/image_figures.h"
#include "gnomon/renderer.h"

namespace gnomon::bench {

namespace {

constexpr int k_crops = 5;            // the shorter side of the image has room for this many crops
constexpr int k_steps = 4;            // positions tried per side of a crop
constexpr double k_deviation = 0.2;   // target of the larger standard deviation, as a fraction of the screen's range
constexpr double k_smooth = 0.05;     // least standard deviation assumed, as a fraction of the mean
constexpr double k_least_lit = 0.9;   // least fraction of a crop that is lit

double brightness(const glm::vec3& light)
{
    return static_cast<double>(luminance(light));
}

struct Spread {
    double mean = 0, deviation = 0, lit = 0;
};

// Statistics of the values in a square of the image; `lit` is the fraction that is not 0.
template <class Value>
Spread spread_in(int x0, int y0, int side, int width, const Value& value)
{
    double sum = 0, square = 0;
    int lit = 0;
    for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x) {
            const double v =
                value(static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
            sum += v, square += v * v, lit += v != 0;
        }
    const double count = static_cast<double>(side) * side, mean = sum / count;
    return {mean, std::sqrt(std::max(0.0, square / count - mean * mean)), lit / count};
}

}   // namespace

Frame direct_light(const Scene& scene, const IndirectStudy& study)
{
    RenderOptions options;
    options.size = study.options.size;
    options.camera = std::to_string(study.options.camera);
    options.indirect = Indirect::off;
    options.max_depth = 0;
    options.threads = study.options.threads;
    options.layers = true;
    return Renderer(options).render(scene, study.result.image.frame);
}

Image8 lit_image(const IndirectStudy& study, const std::vector<glm::vec3>& irradiance, bool with_direct)
{
    const Layer* const direct = study.direct.layer("direct");
    GNOMON_CHECK(direct != nullptr && direct->values().size() == 3 * irradiance.size());
    std::vector<float> color = direct->copy();
    if (!with_direct) std::fill(color.begin(), color.end(), 0.0f);
    for (std::size_t i = 0; i < irradiance.size(); ++i)
        for (int c = 0; c < 3; ++c)
            color[3 * i + static_cast<std::size_t>(c)] +=
                study.result.image.diffuse[i][c] * irradiance[i][c] / static_cast<float>(k_pi);
    Frame image = study.direct;
    image.layers = {*direct};
    image.layers.front().data = color.data();
    return image_of(image);
}

IndirectCrop most_patterned(Size size, const std::vector<glm::vec3>& smooth, const std::vector<glm::vec3>& patterned)
{
    IndirectCrop best;
    best.side = std::max(1, std::min(size.width, size.height) / k_crops);
    const int step = std::max(1, best.side / k_steps);
    double most = -1;
    for (int y = 0; y + best.side <= size.height; y += step)
        for (int x = 0; x + best.side <= size.width; x += step) {
            const auto own = [&](std::size_t i) { return brightness(smooth[i]); };
            const auto other = [&](std::size_t i) { return brightness(patterned[i]) - brightness(smooth[i]); };
            const Spread still = spread_in(x, y, best.side, size.width, own);
            if (!(still.mean > 0) || still.lit < k_least_lit) continue;
            const double pattern = spread_in(x, y, best.side, size.width, other).deviation;
            const double score = pattern / (still.deviation + k_smooth * still.mean);
            if (score <= most) continue;
            most = score;
            best.x = x, best.y = y;
            best.gain = k_deviation * still.mean / std::max({still.deviation, pattern, k_smooth * still.mean});
        }
    return best;
}

Image8 contrast_crop(const IndirectCrop& crop, Size size, const std::vector<glm::vec3>& irradiance)
{
    const auto value = [&](std::size_t i) { return brightness(irradiance[i]); };
    const double mean = spread_in(crop.x, crop.y, crop.side, size.width, value).mean;
    Image8 image(crop.side, crop.side, 3);
    for (int y = 0; y < crop.side; ++y)
        for (int x = 0; x < crop.side; ++x) {
            const double v = value(static_cast<std::size_t>(crop.y + y) * static_cast<std::size_t>(size.width) +
                                   static_cast<std::size_t>(crop.x + x));
            const double shown = mean > 0 ? std::clamp(0.5 + crop.gain * (v / mean - 1), 0.0, 1.0) : 0;
            for (int c = 0; c < 3; ++c)
                image.data[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(crop.side) +
                                static_cast<std::size_t>(x)) +
                           static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255 * shown));
        }
    return image;
}

}   // namespace gnomon::bench
