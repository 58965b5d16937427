// SPDX-License-Identifier: Apache-2.0
#include "shading/centre_samples.h"

#include <algorithm>
#include <cmath>

namespace gnomon::shading {

namespace {

glm::vec3 color_at(const ImageF& image, int x, int y)
{
    const float* const c = image.pixel(x, y);
    return {c[0], c[1], c[2]};
}

}   // namespace

bool same_surface(const CentreSample& a, const CentreSample& b, const RefineOptions& options)
{
    if (a.object != b.object || a.material != b.material) return false;
    if (a.width == 0 && b.width == 0) return true;   // both show the background
    if (!(glm::dot(a.normal, b.normal) > options.same_normal)) return false;
    const glm::vec3 apart = b.position - a.position;
    const float reach = options.off_plane * std::max(a.width, b.width);
    return std::abs(glm::dot(apart, a.normal)) < reach || std::abs(glm::dot(apart, b.normal)) < reach;
}

// What the comparison of some rows reads: of each pixel its light as shown(), and what it has in common with the pixels
// right of it and below it.
class CentreSamples::Rows {
 public:
    Rows(const CentreSamples& samples, int begin, int end, const ImageF& color, const RefineOptions& options);

    glm::vec3 light(int x, int y) const
    {
        const float* const from = light_.data() + 3 * index(x, y);
        return {from[0], from[1], from[2]};
    }
    /// Whether two pixels show one surface, of which the second is right of the first or below it, or above it on the
    /// right.
    bool same(int x, int y, int dx, int dy) const
    {
        if (dy < 0) return (common_[index(x + dx, y + dy)] & k_below_left) != 0;
        return (common_[index(x, y)] & (dy == 0 ? k_right : dx == 0 ? k_below : k_below_right)) != 0;
    }
    /// Whether a pixel and the eight around it show one surface of one reflectance, so that their light is compared as
    /// it is.
    bool plain(int x, int y) const
    {
        if (x == 0 || y == first_ || x + 1 == width_) return false;
        const std::uint8_t* const own = common_.data() + index(x, y);
        const std::uint8_t* const above = own - width_;
        return own[0] >> k_plain == k_all && (own[-1] >> k_plain & k_right) && (above[0] >> k_plain & k_below) &&
               (above[-1] >> k_plain & k_below_right) && (above[1] >> k_plain & k_below_left);
    }
    /// Finds the plain pixels of a row that need more samples.
    /// @param uneven  out: by pixel and channel, whether its light differs too much from that between two neighbours.
    ///                Undefined at pixels that are not plain
    void find_uneven(int y, float most, std::vector<int>& uneven) const;

 private:
    // With the pixel right of it, below it, below it on the right and on the left: it shows the same surface, and, in
    // the bits above, of the same reflectance.
    static constexpr std::uint8_t k_right = 1, k_below = 2, k_below_right = 4, k_below_left = 8, k_all = 15;
    static constexpr int k_plain = 4;
    std::size_t index(int x, int y) const
    {
        return static_cast<std::size_t>(y - first_) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    int first_, last_, width_;   // the rows
    std::vector<float> light_;
    std::vector<std::uint8_t> common_;
};

CentreSamples::Rows::Rows(const CentreSamples& samples, int begin, int end, const ImageF& color,
                          const RefineOptions& options)
    : first_(std::max(begin - 1, 0)), last_(std::min(end, samples.size_.height - 1)), width_(samples.size_.width)
{
    const auto pixels = static_cast<std::size_t>(last_ + 1 - first_) * static_cast<std::size_t>(width_);
    light_.resize(3 * pixels), common_.resize(pixels);
    for (int y = first_; y <= last_; ++y)
        for (int x = 0; x < width_; ++x) {
            const glm::vec3 light = shown(color_at(color, x, y), options.exposure);
            for (int c = 0; c < 3; ++c) light_[3 * index(x, y) + static_cast<std::size_t>(c)] = light[c];
            const CentreSample& own = samples.at(x, y);
            unsigned common = 0;
            const auto compare = [&](int nx, int ny, unsigned bit) {
                if (nx < 0 || nx >= width_ || ny > last_) return;
                const CentreSample& other = samples.at(nx, ny);
                if (!same_surface(own, other, options)) return;
                common |= bit;
                if (own.reflectance == other.reflectance && own.mirrored == glm::vec3(0) &&
                    other.mirrored == glm::vec3(0))
                    common |= bit << k_plain;
            };
            compare(x + 1, y, k_right);
            compare(x, y + 1, k_below), compare(x + 1, y + 1, k_below_right), compare(x - 1, y + 1, k_below_left);
            common_[index(x, y)] = static_cast<std::uint8_t>(common);
        }
}

void CentreSamples::Rows::find_uneven(int y, float most, std::vector<int>& uneven) const
{
    const std::size_t row = 3 * static_cast<std::size_t>(width_);
    uneven.assign(row, 0);
    if (y == first_ || y == last_) return;
    const float* const here = light_.data() + 3 * index(0, y);
    const float *const above = here - row, *const below = here + row;
    const auto differs = [most](float a, float b, float c) {
        return static_cast<int>(2 * std::abs(a - 0.5f * (b + c)) > most);
    };
    for (std::size_t i = 3; i + 3 < row; ++i)
        uneven[i] = differs(here[i], here[i - 3], here[i + 3]) | differs(here[i], above[i], below[i]) |
                    differs(here[i], above[i - 3], below[i + 3]) | differs(here[i], above[i + 3], below[i - 3]);
}

void CentreSamples::find_more(int begin, int end, const ImageF& color, const RefineOptions& options,
                              std::span<std::uint8_t> more) const
{
    const Rows rows(*this, begin, end, color, options);
    // Light of a neighbour, as the pixel's surface would reflect it.
    const auto light_of = [&](int x, int y, const CentreSample& own) {
        return shown(relit(color_at(color, x, y), at(x, y), own.reflectance), options.exposure);
    };
    const auto needs_more = [&](int x, int y) {
        const CentreSample& own = at(x, y);
        const glm::vec3 here = rows.light(x, y);

        // Compare the pixel with each pair of opposite neighbours.
        constexpr int k_ways[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
        for (const auto& way : k_ways) {
            glm::vec3 light[2];
            int same = 0;
            for (int side = 0; side < 2; ++side) {
                const int nx = side == 0 ? x - way[0] : x + way[0], ny = side == 0 ? y - way[1] : y + way[1];
                if (!inside(nx, ny)) continue;
                if (side == 0 ? rows.same(nx, ny, way[0], way[1]) : rows.same(x, y, way[0], way[1]))
                    light[same++] = light_of(nx, ny, own);
                else if (difference(here, rows.light(nx, ny)) > options.edge)
                    return true;   // something ends between the two
            }
            // On one surface, light may change evenly. A step makes half of its height of a difference.
            if (same == 2 && 2 * difference(here, 0.5f * (light[0] + light[1])) > options.light) return true;
            if (same == 1 && difference(here, light[0]) > 2 * options.light) return true;
        }
        return false;
    };

    // Most pixels are plain, and compared side by side.
    std::vector<int> uneven;
    std::size_t pixel = 0;
    for (int y = begin; y < end; ++y) {
        rows.find_uneven(y, options.light, uneven);
        for (int x = 0; x < size_.width; ++x) {
            const int* const own = uneven.data() + 3 * static_cast<std::size_t>(x);
            const bool found = rows.plain(x, y) ? (own[0] | own[1] | own[2]) != 0 : needs_more(x, y);
            more[pixel++] = found ? 1 : 0;
        }
    }
}

bool CentreSamples::covered_in_part(int x, int y) const
{
    const bool own = at(x, y).width > 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (inside(x + dx, y + dy) && (at(x + dx, y + dy).width > 0) != own) return true;
    return false;
}

bool CentreSamples::varies(int x, int y, const ImageF& color, const RefineOptions& options) const
{
    const CentreSample& own = at(x, y);
    if (!own.textured) return false;
    const glm::vec3 light = color_at(color, x, y), here = shown(light, options.exposure);
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            if (!inside(x + dx, y + dy)) continue;
            const CentreSample& other = at(x + dx, y + dy);
            if (other.object != own.object || other.material != own.material) continue;
            if (other.reflectance == own.reflectance) continue;
            const glm::vec3 there = shown(relit(light, own, other.reflectance), options.exposure);
            if (difference(here, there) > options.texture) return true;
        }
    return false;
}

}   // namespace gnomon::shading
