// SPDX-License-Identifier: Apache-2.0
#include "trace/lobe_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.h"
#include "base/interruption.h"
#include "trace/lobe_window.h"
#include "trace/packed_lobe_ray.h"

namespace gnomon::trace {

namespace {

const LobePixel k_no_lobe;

// Of the rays of a pixel.
struct Sums {
    glm::vec3 weight{0}, counted{0};   // counted: each times its sample's rays
    float least = k_infinity, most = 0;

    void add(const LobeRay& ray)
    {
        weight += ray.weight, counted += ray.counts * ray.weight;
        least = std::min(least, ray.counts), most = std::max(most, ray.counts);
    }
    // By which a ray's light and weight are multiplied, so that their sum remains.
    glm::vec3 part_of(const LobeRay& ray) const
    {
        glm::vec3 part(1);
        if (least == most) return part;
        for (int c = 0; c < 3; ++c)
            if (counted[c] > 0) part[c] = ray.counts * (weight[c] / counted[c]);
        return part;
    }
};

}   // namespace

LobeImage::LobeImage(Size size, int side)
    : size_(size),
      side_(side),
      columns_((size.width + side - 1) / side),
      tiles_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>((size.height + side - 1) / side)),
      rays_(tiles_.size()),
      spread_(tiles_.size())
{
}

LobeImage::LobeImage(LobeImage&& other) noexcept = default;

LobeImage::~LobeImage() = default;

LobePixel& LobeImage::at(int x, int y)
{
    auto& tile = tiles_[tile_of(x, y)];
    if (!tile) tile = std::make_unique<LobePixel[]>(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    return tile[in_tile(x, y)];
}

const LobePixel& LobeImage::at(int x, int y) const
{
    const auto& tile = tiles_[tile_of(x, y)];
    return tile ? tile[in_tile(x, y)] : k_no_lobe;
}

std::array<glm::vec3, 9>& LobeImage::spread(int x, int y)
{
    auto& tile = spread_[tile_of(x, y)];
    if (!tile) {
        tile = std::make_unique<Spread[]>(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        std::fill_n(tile.get(), side_ * side_, Spread{});
    }
    return tile[in_tile(x, y)];
}

void LobeImage::set_rays(int left, int top, std::span<const std::uint32_t> pixels, std::span<const LobeRay> rays)
{
    // Order them by pixel.
    const std::size_t tile = tile_of(left, top);
    Rays& to = rays_[tile];
    to.first.assign(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_) + 1, 0);
    for (const std::uint32_t p : pixels) ++to.first[p + 1];
    for (std::size_t p = 1; p < to.first.size(); ++p) to.first[p] += to.first[p - 1];
    std::vector<std::uint32_t> next(to.first.begin(), to.first.end() - 1);
    std::vector<Sums> sums(to.first.size() - 1);
    for (std::size_t i = 0; i < rays.size(); ++i) sums[pixels[i]].add(rays[i]);
    to.rays.resize(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        LobeRay ray = rays[i];
        const glm::vec3 part = sums[pixels[i]].part_of(ray);
        ray.light *= part, ray.weight *= part;
        to.rays[next[pixels[i]]++] = packed(ray);
        LobePixel& pixel = tiles_[tile][pixels[i]];
        pixel.light += ray.light;
        if (ray.nearness == 0) pixel.left += ray.weight;
    }
    for (std::size_t p = 0; p < sums.size(); ++p) {
        LobePixel& pixel = tiles_[tile][p];
        const glm::vec3& weight = sums[p].weight;
        for (int c = 0; c < 3; ++c) {
            if (!(weight[c] > 0)) continue;
            const float all_of_pixel = pixel.weight[c] / weight[c];
            pixel.light[c] *= all_of_pixel, pixel.left[c] *= all_of_pixel;
        }
        const float all = pixel.weight.x + pixel.weight.y + pixel.weight.z;
        if (all > 0) pixel.cast = (weight.x + weight.y + weight.z) / all;
    }
}

void LobeImage::drop_rays()
{
    for (Rays& rays : rays_) rays = {};
}

std::size_t LobeImage::bytes_of_rays() const
{
    std::size_t bytes = 0;
    for (const Rays& rays : rays_) bytes += rays.rays.capacity() * sizeof(PackedLobeRay);
    return bytes;
}

std::span<const PackedLobeRay> LobeImage::rays_of(int x, int y) const
{
    const Rays& rays = rays_[tile_of(x, y)];
    if (rays.first.empty()) return {};
    const std::size_t at = in_tile(x, y);
    return std::span(rays.rays).subspan(rays.first[at], rays.first[at + 1] - rays.first[at]);
}

float LobeImage::rays_wanted(int x, int y, int left, int top, int width, int height,
                             const LobeFilterOptions& options) const
{
    // Of each ring of neighbours, ask four.
    const Likeness likeness(options.wanted_alike, options.wanted_unlike);
    const LobePixel& own = at(x, y);
    float alike = 1, step = k_apart;
    for (int ring = 1; ring <= k_half; ++ring) {
        int asked = 0;
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
            // Along the axes and the diagonals, in turn.
            const int dx = ring % 2 == 1 ? (k % 2 == 0 ? ring * (1 - k) : 0) : ring * (k % 2 == 0 ? 1 : -1);
            const int dy = ring % 2 == 1 ? (k % 2 == 1 ? ring * (2 - k) : 0) : ring * (k < 2 ? 1 : -1);
            const int nx = x + dx, ny = y + dy;
            if (nx < left || ny < top || nx >= left + width || ny >= top + height) continue;
            const float apart = difference(own, at(nx, ny), options);
            if (ring == 1) step = std::min(step, apart);
            sum += likeness(apart), ++asked;
        }
        const float pixels = ring == k_half ? 4 * k_half - 1 : 8 * ring;   // those of the last ring count half
        if (asked > 0) alike += pixels * sum / static_cast<float>(asked);
    }
    if (!(step < k_apart)) return options.rays;
    // Where neighbours are far apart, a narrow lobe shows little within one pixel.
    const float turn = std::sqrt(step);
    const float few = std::max(options.rays_across / std::max(turn, 1e-3f), options.own_rays);
    const float least = options.least_rays * std::min(1 + options.least_by_turn * turn, 2.0f);
    return std::min(std::max(options.rays / alike, least), few);
}

template <class Done>
void LobeImage::filter(Tasks& tasks, const LobeFilterOptions& options, const Done& done)
{
    std::vector<std::size_t> there;
    for (std::size_t t = 0; t < tiles_.size(); ++t)
        if (tiles_[t]) there.push_back(t);
    std::vector<Window> windows(static_cast<std::size_t>(tasks.threads()));
    const auto for_each_tile = [&](const auto& body) {
        tasks.for_each(there.size(), [&](std::size_t i, int worker) {
            interruption_point();
            const int tile = static_cast<int>(there[i]);
            body(tile % columns_ * side_, tile / columns_ * side_, windows[static_cast<std::size_t>(worker)]);
        });
    };
    for_each_tile([&](int left, int top, Window& window) { find_densities(left, top, window, options); });
    for_each_tile([&](int left, int top, Window& window) { gather(left, top, window, options); });
    for_each_tile([&](int left, int top, Window& window) {
        share_means(left, top, window, options);
        for (int y = top; y < std::min(top + side_, size_.height); ++y)
            for (int x = left; x < std::min(left + side_, size_.width); ++x) done(x, y);
    });
}

void LobeImage::add_to(ImageF& color, float scale, Tasks& tasks, const LobeFilterOptions& options)
{
    GNOMON_CHECK(color.width == size_.width && color.height == size_.height);
    filter(tasks, options, [&](int x, int y) {
        const glm::vec3 light = scale * std::as_const(*this).at(x, y).filtered;
        float* const to = color.pixel(x, y);
        for (int c = 0; c < 3; ++c) to[c] += light[c];
    });
}

void LobeImage::add_to(image::SampleSums& sums, Tasks& tasks, const LobeFilterOptions& options)
{
    filter(tasks, options, [&](int x, int y) {
        const LobePixel& pixel = std::as_const(*this).at(x, y);
        const std::size_t tile = tile_of(x, y);
        if (pixel.weight == glm::vec3(0) || !spread_[tile]) return;
        // All samples of the pixel have the filtered light, each times its own weight.
        glm::vec3 radiance(0);
        for (int c = 0; c < 3; ++c)
            if (pixel.weight[c] > 0) radiance[c] = pixel.filtered[c] / pixel.weight[c];
        Spread light = spread_[tile][in_tile(x, y)];
        for (glm::vec3& to : light) to *= radiance;
        sums.add_light(tile, x % side_, y % side_, light);
    });
}

}   // namespace gnomon::trace
