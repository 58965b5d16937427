// SPDX-License-Identifier: Apache-2.0
// The steps of the lobe filter: how densely the pixels around cast rays to where a ray ends; the sum of what the rays
// of a pixel and its neighbours bring; the mean of what pixels gathered whose lobes are nearly the same.
//
// Each has a row of a tile's pixels at once (lobe_sums.h). The orders of sums are fixed, and the functions for pixels
// by themselves, the references, have the same.
#include <utility>

#include "trace/lobe_filter.h"
#include "trace/lobe_sums.h"
#include "trace/lobe_window.h"

namespace gnomon::trace {

namespace {

const LobePixel k_no_lobe;

// What rays of a pixel bring, and what it sees of the environment image where some of them leave the scene.
// @param light, weight, left  sums of the rays; those without weight do not count, but the pixel's own
glm::vec3 found_of(const LobePixel& own, const glm::vec3& light, const glm::vec3& weight, const glm::vec3& left)
{
    glm::vec3 found(0);
    for (int c = 0; c < 3; ++c) {
        const bool some = own.width > 0 && weight[c] > 0;
        found[c] = some ? own.weight[c] * (light[c] / weight[c]) : own.light[c];
        const float open = some ? left[c] / weight[c] : own.weight[c] > 0 ? own.left[c] / own.weight[c] : 0.0f;
        if (open > 0) found[c] += open * own.open[c];
    }
    return found;
}

// The mean of what pixels gathered; their own without weights.
glm::vec3 times_mean(const LobePixel& own, const glm::vec3& light, const glm::vec3& weight)
{
    glm::vec3 mean = own.gathered;
    for (int c = 0; c < 3; ++c)
        if (own.width > 0 && weight[c] > 0) mean[c] = own.weight[c] * (light[c] / weight[c]);
    return mean;
}

LobeSharing sharing_of(const LobeFilterOptions& options, float alike, float unlike)
{
    return {options.near * options.near, {alike, unlike}};
}

}   // namespace

// Fills the window of a tile.
// @param found   what its pixels found
// @param with_rays  with the rays of all of them that count by their densities
void LobeImage::fill(int left, int top, glm::vec3 LobePixel::*found, bool with_rays, Window& window) const
{
    window.resize(side_);
    const auto pixel_at = [&](int x, int y) -> const LobePixel& {
        const int nx = left + x - k_half, ny = top + y - k_half;
        return nx >= 0 && ny >= 0 && nx < size_.width && ny < size_.height ? at(nx, ny) : k_no_lobe;
    };
    for (int y = 0; y < window.height; ++y) {
        std::size_t most = 0;
        for (int x = 0; x < window.stride; ++x) {
            const LobePixel& pixel = pixel_at(x, y);
            window.take(x, y, pixel, pixel.*found);
            if (with_rays && pixel.width > 0 && pixel.uneven > 0)
                most = std::max(most, rays_of(left + x - k_half, top + y - k_half).size());
        }
        window.begin_rays(y, static_cast<int>(most));
        if (most == 0) continue;
        for (int x = 0; x < window.stride; ++x) {
            const LobePixel& pixel = pixel_at(x, y);
            if (pixel.width > 0 && pixel.uneven > 0)
                window.take(x, y, rays_of(left + x - k_half, top + y - k_half), pixel.uneven);
        }
    }
}

// Calls row(y, first, end, pixels) for each row of a tile, with the part of it that has lobes.
template <class Row>
void LobeImage::for_each_row(int left, int top, const Row& row)
{
    for (int y = 0; y < side_ && top + y < size_.height; ++y) {
        LobePixel* const pixels = tiles_[tile_of(left, top)].get() + y * side_;
        int first = side_, end = 0;
        for (int x = 0; x < side_; ++x)
            if (pixels[x].weight != glm::vec3(0)) first = std::min(first, x), end = x + 1;
        if (first < end) row(y, first, end, pixels);
    }
}

// Sets what the pixels of a row have found, from the window's sums.
// @param open  with what they see of the environment image
void LobeImage::set_found(int first, int end, bool open, glm::vec3 LobePixel::*to, LobePixel* pixels,
                          const Window& window)
{
    const auto sum = [](const std::vector<float>* sums, int x) {
        const auto at = static_cast<std::size_t>(x);
        return glm::vec3(sums[0][at], sums[1][at], sums[2][at]);
    };
    for (int x = first; x < end; ++x) {
        LobePixel& pixel = pixels[x];
        if (pixel.weight == glm::vec3(0)) continue;
        const glm::vec3 light = sum(window.light, x), weight = sum(window.weight, x);
        pixel.*to = open ? found_of(pixel, light, weight, sum(window.open, x)) : times_mean(pixel, light, weight);
    }
}

void LobeImage::find_densities(int left, int top, Window& window, const LobeFilterOptions& options)
{
    Rays& rays = rays_[tile_of(left, top)];
    if (rays.first.empty()) return;
    fill(left, top, &LobePixel::light, false, window);
    const LobeSharing sharing = sharing_of(options, options.rays_alike, options.rays_unlike);
    for_each_row(left, top, [&](int y, int first, int end, LobePixel* pixels) {
        const int row = y + k_half;
        for (int x = first; x < end; ++x) window.set(Window::nearest, x + k_half, row, nearest_of(left + x, top + y));
        find_same(window, sharing, {options.even_alike, options.even_unlike}, y, first, end);
        std::size_t most = 0;
        for (int x = first; x < end; ++x) {
            const auto at = static_cast<std::size_t>(x);
            pixels[x].set_evenness(window.same[at], window.covered[at], window.counted[at]);
            if (pixels[x].uneven > 0) most = std::max(most, rays_of(left + x, top + y).size());
        }
        if (most == 0) return;
        // Find densities of the rays that count by them.
        window.begin_rays(row, static_cast<int>(most));
        for (int x = first; x < end; ++x)
            if (pixels[x].uneven > 0) window.take(x + k_half, row, rays_of(left + x, top + y), 1);
        sum_densities(window, sharing, y, first, end);
        for (int x = first; x < end; ++x) {
            if (!(pixels[x].uneven > 0)) continue;
            const std::uint32_t* const list = rays.first.data() + y * side_ + x;
            for (std::uint32_t k = list[0]; k < list[1]; ++k)
                rays.rays[k].density = window.density[(k - list[0]) * static_cast<std::size_t>(window.padded) +
                                                      static_cast<std::size_t>(x)] /
                                       window.covered[static_cast<std::size_t>(x)];
        }
    });
}

float LobeImage::nearest_of(int x, int y) const
{
    float nearest = 0;
    for (const PackedLobeRay& ray : rays_of(x, y)) nearest = std::max(nearest, ray.nearness);
    return nearest;
}

void LobeImage::gather(int left, int top, Window& window, const LobeFilterOptions& options)
{
    fill(left, top, &LobePixel::light, true, window);
    const LobeSharing sharing = sharing_of(options, options.rays_alike, options.rays_unlike);
    for_each_row(left, top, [&](int y, int first, int end, LobePixel* pixels) {
        sum_rays(window, sharing, y, first, end);
        set_found(first, end, true, &LobePixel::gathered, pixels, window);
    });
}

void LobeImage::share_means(int left, int top, Window& window, const LobeFilterOptions& options)
{
    fill(left, top, &LobePixel::gathered, false, window);
    const LobeSharing sharing = sharing_of(options, options.means_alike, options.means_unlike);
    for_each_row(left, top, [&](int y, int first, int end, LobePixel* pixels) {
        sum_means(window, sharing, y, first, end);
        set_found(first, end, false, &LobePixel::filtered, pixels, window);
    });
}

namespace {

float dot(const glm::vec3& a, const glm::vec3& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// How densely a lobe casts rays to where the ray of another pixel ends: per steradian as that pixel sees the place.
// Microfacets reflect the viewer's direction there whose normal is h, the sum of both directions.
float density_of(const LobePixel& lobe, const LobePixel& other, const LobeRay& ray)
{
    // See the place from where the lobe starts, in units of the ray's length.
    const glm::vec3 from = other.position - lobe.position, to = ray.direction + ray.nearness * from;
    const float slant = 1 + dot(facing_of(ray), from), length = std::sqrt(dot(to, to));
    // Find the parts of h along the lobe's normal and across, and the distribution of normals there [Walter et al.
    // 2007], relative to that of the lobe's normal.
    const glm::vec3 h = to + length * lobe.to_viewer, &n = lobe.normal;
    const glm::vec3 cross(n.y * h.z - n.z * h.y, n.z * h.x - n.x * h.z, n.x * h.y - n.y * h.x);
    const float above = dot(n, to), along = dot(n, h), along2 = along * along, across = dot(cross, cross);
    const float below = lobe.width * lobe.width * along2 + across, inverse = 1 / (below * length);
    const float peak = (along2 + across) * length * inverse, nearer = below * inverse;
    const float density = lobe.scale * (peak * peak * slant * (nearer * nearer * nearer));
    return above > 0 && along > 0 && slant > 0 ? density : 0;
}

// Calls use(x, y, share, share times rays) for each neighbour of a pixel that counts.
template <class Use>
void for_each_alike(const LobeImage& image, Size size, int x, int y, const Likeness& likeness,
                    const LobeFilterOptions& options, const Use& use)
{
    const LobePixel& own = image.at(x, y);
    for (int dy = -k_half; dy <= k_half; ++dy)
        for (int dx = -k_half; dx <= k_half; ++dx) {
            const int nx = x + dx, ny = y + dy;
            if (nx < 0 || ny < 0 || nx >= size.width || ny >= size.height) continue;
            const LobePixel& other = image.at(nx, ny);
            if (!(other.width > 0)) continue;
            const float share = likeness(difference(own, other, options)) * (part_at(dx) * part_at(dy));
            use(nx, ny, share, share * other.rays);
        }
}

}   // namespace

// A pixel whose window's lobes have been compared.
LobePixel LobeImage::with_evenness(int x, int y, const LobeFilterOptions& options) const
{
    LobePixel own = at(x, y);
    const float near = nearest_of(x, y), parallax = near * near / (own.width * own.width);
    float most = 0, covered = 0, counted_all = 0;
    for_each_alike(*this, size_, x, y, {options.rays_alike, options.rays_unlike}, options,
                   [&](int nx, int ny, float share, float counted) {
                       const LobePixel& other = at(nx, ny);
                       const glm::vec3 apart = other.position - own.position;
                       const float turn = difference(own, other, options);
                       if (share > 0) most = std::max(most, 2 * (turn + parallax * dot(apart, apart)));
                       covered += share, counted_all += counted;
                   });
    own.set_evenness(Likeness(options.even_alike, options.even_unlike)(most), covered, counted_all);
    return own;
}

float LobeImage::density_around(int x, int y, const LobeRay& ray, const LobeFilterOptions& options) const
{
    float density = 0, shares = 0;
    for_each_alike(*this, size_, x, y, {options.rays_alike, options.rays_unlike}, options,
                   [&](int nx, int ny, float share, float counted) {
                       density += counted * density_of(at(nx, ny), at(x, y), ray), shares += share;
                   });
    return density / shares;
}

glm::vec3 LobeImage::gathered(int x, int y, const LobeFilterOptions& options) const
{
    const LobePixel& own = at(x, y);
    if (own.weight == glm::vec3(0)) return glm::vec3(0);
    glm::vec3 light(0), weight(0), left(0);
    if (!(own.width > 0)) return found_of(own, light, weight, left);
    for_each_alike(*this, size_, x, y, {options.rays_alike, options.rays_unlike}, options,
                   [&](int nx, int ny, float, float counted) {
                       const LobePixel other = with_evenness(nx, ny, options);
                       light += counted * other.even * other.light, weight += counted * other.even * other.weight;
                       left += counted * other.even * other.left;
                       if (!(other.uneven > 0)) return;
                       for (const PackedLobeRay& kept : rays_of(nx, ny)) {
                           LobeRay ray = unpacked(kept);
                           ray.density = density_around(nx, ny, ray, options);
                           const float counts =
                               counted * (density_of(own, at(nx, ny), ray) * (rarity_of(ray) * other.uneven));
                           light += counts * ray.light, weight += counts * ray.weight;
                           if (ray.nearness == 0) left += counts * ray.weight;
                       }
                   });
    return found_of(own, light, weight, left);
}

glm::vec3 LobeImage::mean(int x, int y, const LobeFilterOptions& options) const
{
    const LobePixel& own = at(x, y);
    if (own.weight == glm::vec3(0)) return glm::vec3(0);
    if (!(own.width > 0)) return own.gathered;
    glm::vec3 light(0), weight(0);
    for_each_alike(*this, size_, x, y, {options.means_alike, options.means_unlike}, options,
                   [&](int nx, int ny, float, float counted) {
                       light += counted * at(nx, ny).gathered, weight += counted * at(nx, ny).weight;
                   });
    return times_mean(own, light, weight);
}

}   // namespace gnomon::trace
