// SPDX-License-Identifier: Apache-2.0
#include "viewer/enlarge.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.h"

namespace gnomon::viewer {

namespace {

constexpr float k_alike = 0.8f;              // cosine between the normals of pixels that show one surface
constexpr float k_flat = 0.999f;             // the same of pixels that a shadow may separate
constexpr int k_most = 4;                    // times as wide
constexpr int k_most_pixels = 420 * 1000;    // of an enlarged image: a few milliseconds
constexpr int k_taps = 4;                    // in x and y
constexpr std::array k_inner{5, 6, 9, 10};   // of the taps: those that surround the place

using Weights = std::array<float, k_taps>;

Weights spline_weights(float t)
{
    const float s = 1 - t;
    const float first = s * s * s / 6, last = t * t * t / 6;
    const float second = 2.0f / 3 - t * t * (2 - t) / 2;
    return {first, second, 1 - first - second - last, last};
}

bool is_same(const SeenSurface& a, const SeenSurface& b)
{
    if (a.object != b.object) return false;
    if (a.object == 0) return true;
    const float cosine = glm::dot(a.normal, b.normal);
    if (!(cosine > k_alike)) return false;
    // What curves away from a light gets darker little by little.
    return !(cosine > k_flat) || ((a.lit & b.unlit) | (b.lit & a.unlit)) == 0;
}

// The 4 x 4 pixels around the places between four pixels' centres.
struct Cell {
    std::array<glm::vec4, k_taps * k_taps> color;                // and nearness, in the last component
    int surfaces = 0;                                            // among the inner taps
    std::array<std::array<float, k_taps * k_taps>, 4> shows{};   // by surface and tap: 1 where it is seen
};

class Enlarger {
 public:
    Enlarger(const Image8& image, const std::vector<SeenSurface>& surfaces, int factor);
    EnlargedImage run();

 private:
    // The first place between the centres of a pixel and the next one; below 0 before the image's first pixel.
    int first_after(int pixel) const { return pixel < 0 ? -((factor_ + 1) / 2) : factor_ * (2 * pixel + 1) / 2; }
    void gather(int x, int y);
    void find_surfaces(const std::array<std::size_t, k_taps * k_taps>& pixels);
    void fill(int x, int y, EnlargedImage& out) const;

    const Image8& image_;
    const std::vector<SeenSurface>& surfaces_;
    int factor_;
    std::vector<Weights> weights_;   // by place within a cell
    Cell cell_;
};

Enlarger::Enlarger(const Image8& image, const std::vector<SeenSurface>& surfaces, int factor)
    : image_(image), surfaces_(surfaces), factor_(factor)
{
    for (int i = 0; i < factor; ++i)
        weights_.push_back(
            spline_weights((static_cast<float>(first_after(0) + i) + 0.5f) / static_cast<float>(factor) - 0.5f));
}

// Reads the pixels around a cell; those beyond the image are its outermost ones.
void Enlarger::gather(int x, int y)
{
    std::array<std::size_t, k_taps * k_taps> pixels{};
    for (int j = 0; j < k_taps; ++j)
        for (int i = 0; i < k_taps; ++i) {
            const int px = std::clamp(x + i - 1, 0, image_.width - 1), py = std::clamp(y + j - 1, 0, image_.height - 1);
            const auto tap = static_cast<std::size_t>(j * k_taps + i);
            const std::uint8_t* const c = image_.pixel(px, py);
            pixels[tap] =
                static_cast<std::size_t>(py) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(px);
            cell_.color[tap] = glm::vec4(c[0], c[1], c[2], surfaces_[pixels[tap]].nearness);
        }
    find_surfaces(pixels);
}

// Finds the surfaces that the inner taps show. One that curves is joined from pixel to pixel.
void Enlarger::find_surfaces(const std::array<std::size_t, k_taps * k_taps>& pixels)
{
    std::array<unsigned, 4> seen{};   // by inner tap: one bit for each tap
    bool all = true;
    for (std::size_t c = 0; c < 4; ++c) {
        const SeenSurface& centre = surfaces_[pixels[static_cast<std::size_t>(k_inner[c])]];
        for (std::size_t tap = 0; tap < pixels.size(); ++tap)
            seen[c] |= (is_same(centre, surfaces_[pixels[tap]]) ? 1u : 0u) << tap;
        all = all && seen[c] == 0xffffu;
    }
    cell_.surfaces = 0;
    if (all) return;
    for (int round = 0; round < 2; ++round)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = 0; b < 4; ++b)
                if (seen[a] >> k_inner[b] & 1u) seen[a] = seen[b] = seen[a] | seen[b];
    for (std::size_t c = 0; c < 4; ++c) {
        if (std::find(seen.begin(), seen.begin() + static_cast<std::ptrdiff_t>(c), seen[c]) !=
            seen.begin() + static_cast<std::ptrdiff_t>(c))
            continue;
        auto& shows = cell_.shows[static_cast<std::size_t>(cell_.surfaces++)];
        for (std::size_t tap = 0; tap < shows.size(); ++tap) shows[tap] = seen[c] >> tap & 1u ? 1.0f : 0.0f;
    }
}

// Fills the places of a cell.
void Enlarger::fill(int x, int y, EnlargedImage& out) const
{
    const int first_x = first_after(x), end_x = std::min(first_after(x + 1), out.image.width);
    const int first_y = first_after(y), end_y = std::min(first_after(y + 1), out.image.height);
    for (int oy = std::max(first_y, 0); oy < end_y; ++oy) {
        const Weights& down = weights_[static_cast<std::size_t>(oy - first_y)];
        // Where one surface is all around, columns are summed once.
        std::array<glm::vec4, k_taps> column{};
        if (cell_.surfaces == 0)
            for (std::size_t i = 0; i < k_taps; ++i)
                for (std::size_t j = 0; j < k_taps; ++j) column[i] += down[j] * cell_.color[j * k_taps + i];
        for (int ox = std::max(first_x, 0); ox < end_x; ++ox) {
            const Weights& across = weights_[static_cast<std::size_t>(ox - first_x)];
            glm::vec4 color(0);
            if (cell_.surfaces == 0) {
                for (std::size_t i = 0; i < k_taps; ++i) color += across[i] * column[i];
            } else {
                // Let the pixels vote.
                std::array<float, k_taps * k_taps> weight;
                for (std::size_t j = 0; j < k_taps; ++j)
                    for (std::size_t i = 0; i < k_taps; ++i) weight[j * k_taps + i] = down[j] * across[i];
                float most = 0;
                const std::array<float, k_taps* k_taps>* winner = nullptr;
                for (int s = 0; s < cell_.surfaces; ++s) {
                    const auto& shows = cell_.shows[static_cast<std::size_t>(s)];
                    float sum = 0;
                    for (std::size_t tap = 0; tap < weight.size(); ++tap) sum += shows[tap] * weight[tap];
                    if (sum > most) most = sum, winner = &shows;
                }
                for (std::size_t tap = 0; tap < weight.size(); ++tap)
                    color += (*winner)[tap] * weight[tap] * cell_.color[tap];
                color /= most;
            }
            const std::size_t place =
                static_cast<std::size_t>(oy) * static_cast<std::size_t>(out.image.width) + static_cast<std::size_t>(ox);
            out.nearness[place] = color.w;
            std::uint8_t* const to = out.image.data.data() + 3 * place;
            for (int channel = 0; channel < 3; ++channel)
                to[channel] = static_cast<std::uint8_t>(std::clamp(color[channel] + 0.5f, 0.0f, 255.0f));
        }
    }
}

EnlargedImage Enlarger::run()
{
    EnlargedImage out;
    Image8& image = out.image;
    image.width = image_.width * factor_, image.height = image_.height * factor_, image.channels = 3;
    out.nearness.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    image.data.resize(3 * out.nearness.size());
    for (int y = -1; y < image_.height; ++y)
        for (int x = -1; x < image_.width; ++x) {
            gather(x, y);
            fill(x, y, out);
        }
    return out;
}

}   // namespace

EnlargedImage enlarged(const Image8& image, const std::vector<SeenSurface>& surfaces, int factor)
{
    GNOMON_CHECK(image.channels == 3 && factor > 0);
    GNOMON_CHECK(surfaces.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    if (factor > 1) return Enlarger(image, surfaces, factor).run();
    EnlargedImage same{image, {}};
    for (const SeenSurface& surface : surfaces) same.nearness.push_back(surface.nearness);
    return same;
}

int enlargement(Size image, int divisor)
{
    int factor = std::min(divisor, k_most);
    while (factor > 1 && image.width * factor * (image.height * factor) > k_most_pixels) --factor;
    return std::max(factor, 1);
}

}   // namespace gnomon::viewer
