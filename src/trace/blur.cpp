// SPDX-License-Identifier: Apache-2.0
#include "trace/blur.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/check.h"
#include "base/interruption.h"
#include "base/random.h"
#include "base/sobol.h"
#include "trace/refinement.h"

namespace gnomon::trace {

namespace {

constexpr std::array<std::uint32_t, 5> k_totals{k_first_blur_samples, 16, 32, 64, 128};   // samples of a pixel
constexpr int k_posed_rounds = 2;        // where poses cost as much as samples
constexpr float k_convergence = 0.66f;   // power of the samples' number by which their error falls; 0.5: of random ones
constexpr int k_reach = 2;               // pixels around whose samples tell of a pixel's error

std::uint32_t mixed(std::uint32_t x)
{
    x ^= x >> 16, x *= 0x7feb352du;
    x ^= x >> 15, x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// Permutes numbers so that each bit depends on itself and the lower ones [Burley 2020, Listing 2].
std::uint32_t permuted(std::uint32_t x, std::uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ x * 0x8d22f6e6u;
}

// Scrambles a fraction of 2^32 as Owen does.
std::uint32_t scrambled(std::uint32_t x, std::uint32_t seed)
{
    return reversed_bits(permuted(reversed_bits(x), seed));
}

// A colour as a display encodes it, about: 1 for its white, and little more for what is brighter.
glm::vec3 displayed(const glm::vec3& color)
{
    const auto encoded = [](float x) { return x < 1 ? std::sqrt(std::max(x, 0.0f)) : 1.5f - 0.5f / x; };
    return {encoded(color.x), encoded(color.y), encoded(color.z)};
}

float fraction(std::uint32_t x)
{
    return static_cast<float>(x >> 8) * 0x1p-24f;
}

// The third dimension of Sobol's sequence, for as many points as a pixel may have samples: its direction numbers follow
// from the polynomial x^2 + x + 1.
constexpr int k_sobol_bits = 12;
constexpr std::array<std::uint32_t, k_sobol_bits> third_directions()
{
    std::array<std::uint32_t, k_sobol_bits> result{1u << 31, 3u << 30};
    for (std::size_t i = 2; i < result.size(); ++i) result[i] = result[i - 2] ^ (result[i - 2] >> 2) ^ result[i - 1];
    return result;
}

std::uint32_t third_dimension(std::uint32_t i)
{
    static constexpr std::array<std::uint32_t, k_sobol_bits> k_directions = third_directions();
    std::uint32_t result = 0;
    for (std::size_t bit = 0; bit < k_directions.size(); ++bit)
        if (i >> bit & 1) result ^= k_directions[bit];
    return result;
}

constexpr int k_pattern = 4;   // pixels a side after which a pixel's phase is that of the first again
constexpr std::uint32_t k_eighths = k_most_blur_times / k_first_blur_samples;   // of a stratum of the first samples

// The place within a stratum, in its eighths, that a pixel's first samples have: the middle of one of `phases` equal
// parts. Pixels beside each other have parts that are far apart, and strata in turn opposite ones, so that the mean
// time of every pixel's samples is the shutter's middle.
std::uint32_t phase_of(const glm::ivec2& pixel, std::uint32_t stratum, int phases)
{
    const auto x = static_cast<std::uint32_t>(pixel.x), y = static_cast<std::uint32_t>(pixel.y);
    const std::uint32_t eighth = ((x ^ y) & 1) << 2 | (y & 1) << 1 | ((x ^ y) >> 1 & 1);
    const auto parts = static_cast<std::uint32_t>(phases), part = eighth * parts / k_eighths;
    const std::uint32_t width = k_eighths / parts;
    return (stratum % 2 == 0 ? part : parts - 1 - part) * width + width / 2;
}

// The pose of a sample.
int time_of(const glm::ivec2& pixel, std::uint32_t number, const BlurMotion& motion)
{
    constexpr std::uint32_t k_bits = 6;
    std::uint32_t at = reversed_bits(number) >> (32 - k_bits);
    at ^= phase_of(pixel, at / k_eighths, motion.phases);
    if (number % 32 >= k_first_blur_samples) at ^= static_cast<std::uint32_t>(pixel.x + pixel.y) & 1;
    return static_cast<int>(at) * motion.times / k_most_blur_times;
}

}   // namespace

BlurSample blur_sample(const glm::ivec2& pixel, std::uint32_t number, const BlurMotion& motion, bool random)
{
    const std::uint32_t seed = mixed(static_cast<std::uint32_t>(pixel.x) * 0x9e3779b9u +
                                     mixed(static_cast<std::uint32_t>(pixel.y) + 0x51ed270bu));
    BlurSample sample;
    if (random) {
        Random numbers(seed, number);
        sample.offset = {numbers.uniform(), numbers.uniform()};
        sample.lens = scene::disc_point({numbers.uniform(), numbers.uniform()});
        sample.time = static_cast<int>(numbers.below(static_cast<std::uint32_t>(motion.times)));
        return sample;
    }
    // The time is the first dimension of Sobol's sequence. So it is well spread together with the place in the pixel,
    // which decides about moving edges.
    const auto place = [&](std::uint32_t point, std::uint32_t dimension) {
        return fraction(scrambled(point, mixed(seed + dimension)));
    };
    sample.offset = {place(second_dimension(number), 1), place(third_dimension(number), 2)};
    // Exchange blocks of points, so that each run of a power of two of points stays such a run, of other times.
    const std::uint32_t i = scrambled(number, mixed(seed)) & 0xffffu;
    sample.lens = scene::disc_point({place(reversed_bits(i), 3), place(second_dimension(i), 4)});
    sample.time = time_of(pixel, number, motion);
    return sample;
}

float blur_path_place(const glm::ivec2& pixel, std::uint32_t number, int depth)
{
    // Multiples of the golden section fill the unit interval evenly.
    constexpr std::uint32_t k_golden = 0x9e3779b9u;
    const std::uint32_t start =
        mixed(mixed(static_cast<std::uint32_t>(pixel.x)) + static_cast<std::uint32_t>(pixel.y)) +
        mixed(static_cast<std::uint32_t>(depth) + 1);
    return fraction(start + number * k_golden);
}

int Blur::time(const glm::ivec2& pixel, std::uint32_t number) const
{
    return options_.random ? sample(pixel, number).time : time_of(pixel, number, motion_);
}

bool Blur::any_active(const Tile& tile) const
{
    for (int y = tile.y; y < tile.y + tile.height; ++y)
        for (int x = tile.x; x < tile.x + tile.width; ++x)
            if (active(x, y)) return true;
    return false;
}

void Blur::keep(image::SampleSums&& sums, const image::SampleWeights& centre, int share, int tile)
{
    others_ = std::move(sums), centre_ = centre, share_ = static_cast<float>(share), tile_ = tile;
}

void Blur::begin(Size size, int channels, float exposure, std::optional<LobeImage> lobes)
{
    GNOMON_CHECK(size.width == size_.width && size.height == size_.height);
    exposure_ = exposure;
    sums_ = ImageF(size.width, size.height, channels);
    squares_ = ImageF(size.width, size.height, 3);
    lobes_ = lobes ? ImageF(size.width, size.height, 8) : ImageF();
    active_ = Image8(size.width, size.height, 1);
    still_lobes_.reset();
    if (!lobes || motion_.times > 1) return;
    lobes->drop_rays();
    still_lobes_.emplace(std::move(*lobes));
}

void Blur::keep_light(std::span<const ImageF* const> layers)
{
    if (motion_.times > 1) return;
    for (const ImageF* layer : layers) still_.push_back(*layer);
    for (const ImageF& layer : still_) still_layers_.push_back(&layer);
}

bool Blur::next_round(Tasks& tasks)
{
    if (!any_) return false;
    if (round_ < 0) {
        totals_.assign(k_totals.begin(), k_totals.end());
        if (options_.samples > 0) totals_ = {static_cast<std::uint32_t>(options_.samples)};
    }
    if (round_ + 1 == most_rounds()) return false;
    const bool posed = motion_.times > 1;
    // Go on with the pixels whose error is too large.
    Image8 next(size_.width, size_.height, 1);
    std::vector<std::size_t> last(static_cast<std::size_t>(size_.height), 0);   // of each row, 1 and the largest total
    tasks.for_each(static_cast<std::size_t>(size_.height), [&](std::size_t row, int) {
        interruption_point();
        const int y = static_cast<int>(row);
        for (int x = 0; x < size_.width; ++x) {
            const bool goes_on = round_ < 0 ? touched(x, y) : active(x, y) && error_at(x, y, end_) > options_.error;
            if (!goes_on) continue;
            const std::size_t total = round_ < 0 ? 0 : posed ? next_total(x, y) : static_cast<std::size_t>(round_) + 1;
            *next.pixel(x, y) = static_cast<std::uint8_t>(total + 1);
            last[row] = std::max(last[row], total + 1);
        }
    });
    const std::size_t largest = *std::ranges::max_element(last);
    if (largest == 0) return false;
    ++round_;
    first_ = end_;
    end_ = totals_[largest - 1];
    use_times();
    for (int y = 0; y < size_.height; ++y)
        for (int x = 0; x < size_.width; ++x)
            if (*next.pixel(x, y) != 0) *rounds_.pixel(x, y) = static_cast<std::uint8_t>(*next.pixel(x, y) + 1);
    active_ = std::move(next);
    return true;
}

int Blur::most_rounds() const
{
    const int totals = static_cast<int>(totals_.size());
    return motion_.times > 1 ? std::min(k_posed_rounds, totals) : totals;
}

double Blur::progress(double times) const
{
    return (round_ + times / motion_.times) / most_rounds();
}

// The number of the least total with which a pixel's error is small enough, or of the last one.
std::size_t Blur::next_total(int x, int y) const
{
    std::size_t total = static_cast<std::size_t>(round_) + 1;
    while (total + 1 < totals_.size() && error_at(x, y, totals_[total]) > options_.error) ++total;
    return total;
}

// Notes the times of the round's samples.
void Blur::use_times()
{
    used_.assign(static_cast<std::size_t>(motion_.times), options_.random ? 1 : 0);
    for (std::uint32_t s = first_; s < end_; ++s)
        for (int p = 0; p < k_pattern * k_pattern; ++p)
            used_[static_cast<std::size_t>(time_of({p % k_pattern, p / k_pattern}, s, motion_))] = 1;
}

// How far a pixel's mean of a number of samples may be from the true one, as a display shows it. Variance and mean are
// those of other pixels around, so that the number of a pixel's samples does not depend on what they show: a pixel that
// happens to miss the light of a thin line would stop earlier than one that meets it. The largest of several estimates
// counts: of all pixels around, and of two on either side, because a line fills few of the pixels around.
float Blur::error_at(int x, int y, std::uint32_t samples) const
{
    const float falls = std::pow(static_cast<float>(samples), -k_convergence);
    const auto error_of = [&](const Spread& of) {
        if (of.pixels == 0) return 0.0f;
        const float share = 1.0f / static_cast<float>(of.pixels);
        const glm::vec3 mean = share * of.mean, error = falls * glm::sqrt(share * of.variance);
        const glm::vec3 at_mean = displayed(exposure_ * mean), above = displayed(exposure_ * (mean + error));
        const float off = shading::difference(above, at_mean);
        // Above white nothing gets brighter, but a pixel that meets none of the light is black.
        constexpr float k_missed = 2;   // of the error
        const bool white = std::max({above.x, above.y, above.z}) > 1;
        return white ? std::max(off, shading::difference(displayed(exposure_ * (mean - k_missed * error)), at_mean))
                     : off;
    };
    Spread around;
    for (int v = y - k_reach; v <= y + k_reach; ++v)
        for (int u = x - k_reach; u <= x + k_reach; ++u)
            if (u != x || v != y) add_spread(u, v, around);
    if (around.pixels == 0) add_spread(x, y, around);
    float error = error_of(around);
    for (const glm::ivec2& side : {glm::ivec2(1, 0), {0, 1}, {1, 1}, {1, -1}}) {
        Spread pair;
        add_spread(x - side.x, y - side.y, pair), add_spread(x + side.x, y + side.y, pair);
        error = std::max(error, error_of(pair));
    }
    return error;
}

// Adds mean and variance of a pixel's samples, if it is in the image and has some.
void Blur::add_spread(int x, int y, Spread& to) const
{
    if (x < 0 || y < 0 || x >= size_.width || y >= size_.height || *rounds_.pixel(x, y) < 2) return;
    const auto n = static_cast<float>(end_sample(x, y));
    const float *const sum = sums_.pixel(x, y), *const square = squares_.pixel(x, y);
    for (int c = 0; c < 3; ++c) {
        to.mean[c] += sum[c] / n;
        to.variance[c] += std::max(square[c] - sum[c] * sum[c] / n, 0.0f) / (n - 1);
    }
    ++to.pixels;
}

void Blur::add(int x, int y, const float* values)
{
    float* const sum = sums_.pixel(x, y);
    for (int c = 0; c < sums_.channels; ++c) sum[c] += values[c];
    float* const square = squares_.pixel(x, y);
    for (int c = 0; c < 3; ++c) square[c] += values[c] * values[c];
}

void Blur::add_lobe(int x, int y, const BlurredLobe& lobe)
{
    float* const sum = lobes_.pixel(x, y);
    for (int c = 0; c < 3; ++c) sum[c] += lobe.light[c], sum[3 + c] += lobe.counts * lobe.light[c];
    sum[6] += lobe.weight, sum[7] += lobe.counts * lobe.weight;
}

// The mean of a pixel's samples.
void Blur::mean_of(int x, int y, std::span<float> mean) const
{
    const auto n = static_cast<float>(end_sample(x, y));
    const float* const sum = sums_.pixel(x, y);
    for (std::size_t c = 0; c < mean.size(); ++c) mean[c] = sum[c] / n;
    if (lobes_.data.empty()) return;
    const float* const lobe = lobes_.pixel(x, y);
    for (std::size_t c = 0; c < 3 && lobe[7] > 0; ++c)
        mean[c] = std::max(mean[c] + (lobe[3 + c] * (lobe[6] / lobe[7]) - lobe[c]) / n, 0.0f);
}

void Blur::finish(const std::vector<ImageF*>& layers, Tasks& tasks) const
{
    const int columns = (size_.width + tile_ - 1) / tile_, rows = (size_.height + tile_ - 1) / tile_;
    const auto tiles = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    const auto write = [&](int x, int y, const float* values) {
        for (ImageF* layer : layers) {
            std::copy_n(values, layer->channels, layer->pixel(x, y));
            values += layer->channels;
        }
    };
    // Without kept sums, the other pixels lie in the layers already.
    std::optional<image::SampleSums> all = others_;
    tasks.for_each(tiles, [&](std::size_t tile, int) {
        const int left = static_cast<int>(tile) % columns * tile_, top = static_cast<int>(tile) / columns * tile_;
        std::vector<float> mean(static_cast<std::size_t>(sums_.channels));
        for (int y = top; y < std::min(top + tile_, size_.height); ++y)
            for (int x = left; x < std::min(left + tile_, size_.width); ++x) {
                if (!touched(x, y)) continue;
                mean_of(x, y, mean);
                if (all)
                    all->add(tile, x - left, y - top, centre_, share_, mean.data(), image::LightWeight::linear);
                else
                    write(x, y, mean.data());
            }
    });
    if (!all) return;
    tasks.for_each(tiles, [&](std::size_t tile, int) { all->resolve(tile, write); });
}

std::uint64_t Blur::touched_pixels() const
{
    if (!any_) return 0;
    return static_cast<std::uint64_t>(
        std::count_if(rounds_.data.begin(), rounds_.data.end(), [](std::uint8_t r) { return r > 0; }));
}

}   // namespace gnomon::trace
