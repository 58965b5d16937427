// SPDX-License-Identifier: Apache-2.0
#include "image/tone_map.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/check.h"
#include "base/image.h"

namespace gnomon::image {

namespace {
constexpr float k_brightest = 1e6f;   // replaces infinite channels

// Automatic exposure: range and resolution of the histogram in stops, fractions of pixels ignored at its ends, key.
constexpr int k_bins_per_stop = 32;
constexpr int k_lowest_stop = -32;
constexpr int k_highest_stop = 32;
constexpr double k_ignore_darkest = 0.05;
constexpr double k_ignore_brightest = 0.05;
constexpr double k_key = 0.25;           // a uniform grey maps to 0.21, and a sunlit courtyard looks natural
constexpr double k_bright_rank = 0.95;   // of lit pixels: the luminance at this rank ...
constexpr double k_bright_level = 0.9;   // ... maps to no more than this
constexpr double k_exposure_limit = 20;

float sane(float value)
{
    return value > 0 ? std::min(value, k_brightest) : 0.0f;   // NaN compares false
}

glm::vec3 neutral(glm::vec3 color)
{
    constexpr float fresnel = 0.04f;   // reflectance of the dielectric at normal incidence, subtracted
    constexpr float start = 0.8f - fresnel;
    constexpr float desaturation = 0.15f;
    const float low = std::min({color.x, color.y, color.z});
    color -= low < 2 * fresnel ? low - low * low / (4 * fresnel) : fresnel;
    const float peak = std::max({color.x, color.y, color.z});
    if (peak < start) return color;

    constexpr float room = 1 - start;
    const float new_peak = 1 - room * room / (peak + room - start);
    color *= new_peak / peak;
    const float keep = 1 / (desaturation * (peak - new_peak) + 1);
    return glm::mix(glm::vec3(new_peak), color, keep);
}

glm::vec3 agx(const glm::vec3& color)
{
    const glm::mat3 inset(0.842479062253094f, 0.0423282422610123f, 0.0423756549057051f,    //
                          0.0784335999999992f, 0.878468636469772f, 0.0784336f,             //
                          0.0792237451477643f, 0.0791661274605434f, 0.879142973793104f);   // columns
    const glm::mat3 outset(1.19687900512017f, -0.0528968517574562f, -0.0529716355144438f, -0.0980208811401368f,
                           1.15190312990417f, -0.0980434501171241f, -0.0990297440797205f, -0.0989611768448433f,
                           1.15107367264116f);
    constexpr float lowest = -12.47393f, highest = 4.026069f;   // stops
    constexpr float tiny = 1e-10f;
    constexpr float display_gamma = 2.2f;

    glm::vec3 x = glm::log2(glm::max(inset * color, glm::vec3(tiny)));
    x = glm::clamp((x - lowest) / (highest - lowest), 0.0f, 1.0f);
    const glm::vec3 x2 = x * x, x4 = x2 * x2;
    x = 15.5f * x4 * x2 - 40.14f * x4 * x + 31.96f * x4 - 6.868f * x2 * x + 0.4298f * x2 + 0.1191f * x - 0.00232f;
    return glm::pow(glm::max(outset * x, glm::vec3(0)), glm::vec3(display_gamma));
}

glm::vec3 aces(const glm::vec3& color)
{
    const glm::mat3 in(0.59719f, 0.07600f, 0.02840f, 0.35458f, 0.90834f, 0.13383f, 0.04823f, 0.01566f, 0.83777f);
    const glm::mat3 out(1.60475f, -0.10208f, -0.00327f, -0.53108f, 1.10813f, -0.07276f, -0.07367f, -0.00605f, 1.07602f);
    const glm::vec3 v = in * color;
    const glm::vec3 a = v * (v + 0.0245786f) - 0.000090537f;
    const glm::vec3 b = v * (0.983729f * v + 0.4329510f) + 0.238081f;
    return out * (a / b);
}

// Computes the exact rounding of 255 * srgb(linear) without a power per channel: a first guess, then thresholds between
// bytes.
class SrgbTable {
 public:
    SrgbTable()
    {
        for (int i = 0; i < 255; ++i) threshold_[i] = linear_from_srgb((static_cast<float>(i) + 0.5f) / 255.0f);
        threshold_[255] = k_infinity;
        for (int i = 0; i <= k_guesses; ++i) {
            const float linear = static_cast<float>(i) / k_guesses;
            guess_[i] = static_cast<std::uint8_t>(std::upper_bound(threshold_.begin(), threshold_.end(), linear) -
                                                  threshold_.begin());
        }
    }
    /// @param linear  in 0 ... 1
    std::uint8_t encode(float linear) const
    {
        std::uint8_t byte = guess_[static_cast<int>(linear * k_guesses)];
        while (linear >= threshold_[byte]) ++byte;
        return byte;
    }

 private:
    static constexpr int k_guesses = 4096;
    std::array<float, 256> threshold_{};
    std::array<std::uint8_t, k_guesses + 1> guess_{};
};
}   // namespace

glm::vec3 tone_map(ToneMap curve, glm::vec3 linear)
{
    linear = {sane(linear.x), sane(linear.y), sane(linear.z)};
    switch (curve) {
        case ToneMap::none:
            break;
        case ToneMap::neutral:
            linear = neutral(linear);
            break;
        case ToneMap::agx:
            linear = agx(linear);
            break;
        case ToneMap::aces:
            linear = aces(linear);
            break;
    }
    return glm::clamp(linear, 0.0f, 1.0f);
}

double auto_exposure(std::span<const float> rgb)
{
    // Count the lit pixels by the logarithm of their luminance.
    constexpr int bins = (k_highest_stop - k_lowest_stop) * k_bins_per_stop;
    std::vector<std::int64_t> histogram(bins, 0);
    std::int64_t lit = 0;
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
        const float light = luminance(glm::vec3(sane(rgb[i]), sane(rgb[i + 1]), sane(rgb[i + 2])));
        if (!(light > 0)) continue;
        const int bin = static_cast<int>(std::floor((std::log2(light) - k_lowest_stop) * k_bins_per_stop));
        ++histogram[static_cast<std::size_t>(std::clamp(bin, 0, bins - 1))];
        ++lit;
    }
    if (lit == 0) return 0;

    // Average the luminance between the ranks that are kept.
    const auto first = static_cast<std::int64_t>(static_cast<double>(lit) * k_ignore_darkest);
    const auto last = lit - static_cast<std::int64_t>(static_cast<double>(lit) * k_ignore_brightest);
    const auto bright = static_cast<std::int64_t>(static_cast<double>(lit) * k_bright_rank);
    std::int64_t rank = 0, sum = 0;
    int bright_bin = 0;
    for (int bin = 0; bin < bins; ++bin) {
        const std::int64_t next = rank + histogram[static_cast<std::size_t>(bin)];
        if (rank <= bright && bright < next) bright_bin = bin;
        sum += bin * std::max<std::int64_t>(0, std::min(next, last) - std::max(rank, first));
        rank = next;
    }
    const double mean_bin = static_cast<double>(sum) / static_cast<double>(last - first) + 0.5;
    const double mean_stop = k_lowest_stop + mean_bin / k_bins_per_stop;

    // Limit the exposure of a dark image with bright parts, so that these do not clip.
    const double bright_stop = k_lowest_stop + (bright_bin + 0.5) / k_bins_per_stop;
    const double stops = std::min(std::log2(k_key) - mean_stop, std::log2(k_bright_level) - bright_stop);
    return std::clamp(stops, -k_exposure_limit, k_exposure_limit);
}

void encode_srgb8(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint8_t> out)
{
    GNOMON_CHECK_EQ(rgb.size(), out.size());
    static const SrgbTable table;
    const auto factor = static_cast<float>(std::exp2(exposure));
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
        const glm::vec3 shown = tone_map(curve, factor * glm::vec3(rgb[i], rgb[i + 1], rgb[i + 2]));
        for (int c = 0; c < 3; ++c) out[i + c] = table.encode(shown[c]);
    }
}

void encode_srgb16(std::span<const float> rgb, double exposure, ToneMap curve, std::span<std::uint16_t> out)
{
    GNOMON_CHECK_EQ(rgb.size(), out.size());
    const auto factor = static_cast<float>(std::exp2(exposure));
    for (std::size_t i = 0; i + 2 < rgb.size(); i += 3) {
        const glm::vec3 shown = tone_map(curve, factor * glm::vec3(rgb[i], rgb[i + 1], rgb[i + 2]));
        for (int c = 0; c < 3; ++c)
            out[i + c] = static_cast<std::uint16_t>(std::lround(65535 * srgb_from_linear(shown[c])));
    }
}

}   // namespace gnomon::image
