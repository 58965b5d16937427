// SPDX-License-Identifier: Apache-2.0
// The steps of the lobe filter: how densely the pixels around cast rays to where a ray ends; the sum of what the rays
// of a pixel and its neighbours bring; the mean of what pixels gathered whose lobes are nearly the same.
//
// Each has a row of a tile's pixels at once, for one neighbour and one of its rays after the other. The orders of sums
// are fixed, and the functions for pixels by themselves, the references, have the same.
#include <utility>

#include "trace/lobe_filter.h"
#include "trace/lobe_window.h"

namespace gnomon::trace {

namespace {

SeenPlace seen_place(const LobePixel& lobe, const LobePixel& from, const LobeRay& ray)
{
    const glm::vec3 facing = facing_of(ray);
    return place_seen(lobe.normal.x, lobe.normal.y, lobe.normal.z, lobe.to_viewer.x, lobe.to_viewer.y, lobe.to_viewer.z,
                      lobe.position.x, lobe.position.y, lobe.position.z, from.position.x, from.position.y,
                      from.position.z, ray.direction.x, ray.direction.y, ray.direction.z, ray.nearness, facing.x,
                      facing.y, facing.z);
}

// A row of pixels, and their neighbours in one direction.
struct Neighbours {
    const float *px, *py, *pz, *ax, *ay, *az, *width, *footprint;
    const float *other_px, *other_py, *other_pz, *other_ax, *other_ay, *other_az, *other_width, *other_footprint;
    const float* other_rays;
};

// As difference() and Likeness, for a row. Without branches, so that compilers use vectors.
// @param share    out: how far a neighbour counts
// @param counted  out: times how many rays it has
void find_shares(const Neighbours& n, int first, int end, float near, const Likeness& likeness, float edge,
                 float* __restrict share, float* __restrict counted)
{
    for (int x = first; x < end; ++x) {
        const float dx = n.other_px[x] - n.px[x], dy = n.other_py[x] - n.py[x], dz = n.other_pz[x] - n.pz[x];
        const float tx = n.other_ax[x] - n.ax[x], ty = n.other_ay[x] - n.ay[x], tz = n.other_az[x] - n.az[x];
        const float square = dx * dx + dy * dy + dz * dz, turn = tx * tx + ty * ty + tz * tz;
        const float a = n.footprint[x], b = n.other_footprint[x], footprint = a < b ? b : a;
        const float w = n.width[x], v = n.other_width[x], width = v < w ? v : w, wider = (v < w ? w : v) - width;
        const float close = square < near * (footprint * footprint) ? edge : 0.0f;
        const float apart = (turn + wider * wider) / (width * width);
        float t = (likeness.unlike - apart) * likeness.slope;
        t = t > 0 ? t : 0.0f;   // nor where a width is 0
        t = t < 1 ? t : 1.0f;
        share[x] = t * t * (3 - 2 * t) * close;
        counted[x] = share[x] * n.other_rays[x];
    }
}

void add_products(const float* __restrict share, const float* __restrict of, int first, int end, float* __restrict sum)
{
    for (int x = first; x < end; ++x) sum[x] += share[x] * of[x];
}

// Rows of lobes, and of rays that start elsewhere.
struct LobesAndRays {
    const float *nx, *ny, *nz, *vx, *vy, *vz, *px, *py, *pz, *width, *scale;
    const float *qx, *qy, *qz, *dx, *dy, *dz, *near, *fx, *fy, *fz;
};

[[gnu::always_inline]] inline SeenPlace seen_place(const LobesAndRays& r, int x)
{
    return place_seen(r.nx[x], r.ny[x], r.nz[x], r.vx[x], r.vy[x], r.vz[x], r.px[x], r.py[x], r.pz[x], r.qx[x], r.qy[x],
                      r.qz[x], r.dx[x], r.dy[x], r.dz[x], r.near[x], r.fx[x], r.fy[x], r.fz[x]);
}

// Adds a row of lobes to the densities of rays.
void add_densities(const LobesAndRays& r, const float* __restrict counted, int first, int end,
                   float* __restrict density)
{
    for (int x = first; x < end; ++x)
        density[x] += counted[x] * (r.scale[x] * density_of(seen_place(r, x), r.width[x] * r.width[x]));
}

// Rows of lobes and of where rays start, by component, and of one ray.
template <class Lobes, class Starts, class Ray>
LobesAndRays lobes_and_rays(const Lobes& lobe, const Starts& start, const Ray& ray)
{
    using W = LobeImage::Window;
    return {lobe(W::nx), lobe(W::ny), lobe(W::nz),    lobe(W::vx),    lobe(W::vy),  lobe(W::vz),  lobe(W::px),
            lobe(W::py), lobe(W::pz), lobe(W::width), lobe(W::scale), start(W::px), start(W::py), start(W::pz),
            ray(W::dx),  ray(W::dy),  ray(W::dz),     ray(W::near),   ray(W::fx),   ray(W::fy),   ray(W::fz)};
}

// How much rays of neighbours count.
void find_counts(const LobesAndRays& r, const float* __restrict counted, const float* __restrict density, int first,
                 int end, float* __restrict counts)
{
    for (int x = first; x < end; ++x) {
        const float own = r.scale[x] * density_of(seen_place(r, x), r.width[x] * r.width[x]);
        const float count = counted[x] * (own / density[x]);
        counts[x] = density[x] > 0 ? count : 0.0f;
    }
}

}   // namespace

// Fills the window of a tile.
// @param found   what its pixels found
// @param around  with the rays of the pixels around, too
void LobeImage::fill(int left, int top, glm::vec3 LobePixel::*found, bool around, Window& window) const
{
    window.clear(side_);
    for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.stride; ++x) {
            const int nx = left + x - k_half, ny = top + y - k_half;
            if (nx < 0 || ny < 0 || nx >= size_.width || ny >= size_.height || !tiles_[tile_of(nx, ny)]) continue;
            const LobePixel& pixel = tiles_[tile_of(nx, ny)][in_tile(nx, ny)];
            if (!(pixel.width > 0)) continue;
            window.take(x, y, pixel, pixel.*found);
            const bool inside = x >= k_half && y >= k_half && x < k_half + side_ && y < k_half + side_;
            if (around || inside) window.take(x, y, rays_of(nx, ny));
        }
}

// Calls use(dx, dy) for all neighbours in one direction of a row of the window's tile, with their shares.
template <class Use>
void LobeImage::for_each_neighbour(int y, int first, int end, float alike, float unlike, Window& window,
                                   const LobeFilterOptions& options, const Use& use) const
{
    using W = Window;
    const float near = options.near * options.near;
    const Likeness likeness(alike, unlike);
    const auto own = [&](W::Of of) { return window.row(of, y + k_half) + k_half; };
    for (int dy = -k_half; dy <= k_half; ++dy)
        for (int dx = -k_half; dx <= k_half; ++dx) {
            const auto other = [&](W::Of of) { return window.row(of, y + k_half + dy) + k_half + dx; };
            const Neighbours n{own(W::px),          own(W::py),    own(W::pz),        own(W::ax),   own(W::ay),
                               own(W::az),          own(W::width), own(W::footprint), other(W::px), other(W::py),
                               other(W::pz),        other(W::ax),  other(W::ay),      other(W::az), other(W::width),
                               other(W::footprint), other(W::rays)};
            find_shares(n, first, end, near, likeness, part_at(dx) * part_at(dy), window.share.data(),
                        window.counted.data());
            const float* const share = window.share.data();
            if (std::any_of(share + first, share + end, [](float s) { return s > 0; })) use(dx, dy);
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
void LobeImage::set_found(int first, int end, glm::vec3 LobePixel::*from, glm::vec3 LobePixel::*to, LobePixel* pixels,
                          const Window& window)
{
    for (int x = first; x < end; ++x) {
        LobePixel& pixel = pixels[x];
        if (pixel.weight == glm::vec3(0)) continue;
        for (int c = 0; c < 3; ++c) {
            const float light = window.light[c][static_cast<std::size_t>(x)];
            const float weight = window.weight[c][static_cast<std::size_t>(x)];
            (pixel.*to)[c] = pixel.width > 0 && weight > 0 ? pixel.weight[c] * (light / weight) : (pixel.*from)[c];
        }
    }
}

void LobeImage::find_densities(int left, int top, Window& window, const LobeFilterOptions& options)
{
    using W = Window;
    Rays& rays = rays_[tile_of(left, top)];
    if (rays.first.empty()) return;
    fill(left, top, &LobePixel::light, false, window);
    for_each_row(left, top, [&](int y, int first, int end, LobePixel*) {
        const int most = window.rays_of_row[static_cast<std::size_t>(y + k_half)];
        const auto own = [&](W::Of of) { return window.row(of, y + k_half) + k_half; };
        const auto ray = [&](W::OfRay of, int k) { return window.row(of, k, y + k_half) + k_half; };
        for (int k = 0; k < most; ++k) std::fill(ray(W::density, k) + first, ray(W::density, k) + end, 0.0f);
        std::fill(window.covered.begin(), window.covered.end(), 0.0f);
        for_each_neighbour(
            y, first, end, options.rays_alike, options.rays_unlike, window, options, [&](int dx, int dy) {
                const auto other = [&](W::Of of) { return window.row(of, y + k_half + dy) + k_half + dx; };
                for (int k = 0; k < most; ++k) {
                    const LobesAndRays rows = lobes_and_rays(other, own, [&](W::OfRay of) { return ray(of, k); });
                    window.for_each_run(k, y + k_half, k_half, first, end, [&](int from, int to) {
                        add_densities(rows, window.counted.data(), from, to, ray(W::density, k));
                    });
                }
                for (int x = first; x < end; ++x)
                    window.covered[static_cast<std::size_t>(x)] += window.share[static_cast<std::size_t>(x)];
            });
        for (int x = first; x < end; ++x) {
            const auto at = static_cast<std::size_t>(y * side_ + x);
            for (std::uint32_t k = rays.first[at]; k < rays.first[at + 1]; ++k) {
                rays.rays[k].density = ray(W::density, static_cast<int>(k - rays.first[at]))[x] /
                                       window.covered[static_cast<std::size_t>(x)];
            }
        }
    });
}

void LobeImage::gather(int left, int top, Window& window, const LobeFilterOptions& options)
{
    using W = Window;
    fill(left, top, &LobePixel::light, true, window);
    for_each_row(left, top, [&](int y, int first, int end, LobePixel* pixels) {
        window.clear_sums();
        const auto own = [&](W::Of of) { return window.row(of, y + k_half) + k_half; };
        for_each_neighbour(
            y, first, end, options.rays_alike, options.rays_unlike, window, options, [&](int dx, int dy) {
                const auto other = [&](W::Of of) { return window.row(of, y + k_half + dy) + k_half + dx; };
                for (int k = 0; k < window.rays_of_row[static_cast<std::size_t>(y + k_half + dy)]; ++k) {
                    const auto ray = [&](W::OfRay of) { return window.row(of, k, y + k_half + dy) + k_half + dx; };
                    float* const counts = window.found.data();
                    const LobesAndRays rows = lobes_and_rays(own, other, ray);
                    window.for_each_run(k, y + k_half + dy, k_half + dx, first, end, [&](int from, int to) {
                        find_counts(rows, window.counted.data(), ray(W::density), from, to, counts);
                        for (int c = 0; c < 3; ++c) {
                            add_products(counts, ray(static_cast<W::OfRay>(W::ray_lr + c)), from, to,
                                         window.light[c].data());
                            add_products(counts, ray(static_cast<W::OfRay>(W::ray_wr + c)), from, to,
                                         window.weight[c].data());
                        }
                    });
                }
            });
        set_found(first, end, &LobePixel::light, &LobePixel::gathered, pixels, window);
    });
}

void LobeImage::share_means(int left, int top, Window& window, const LobeFilterOptions& options)
{
    using W = Window;
    fill(left, top, &LobePixel::gathered, false, window);
    for_each_row(left, top, [&](int y, int first, int end, LobePixel* pixels) {
        window.clear_sums();
        for_each_neighbour(y, first, end, options.means_alike, options.means_unlike, window, options,
                           [&](int dx, int dy) {
                               const auto add = [&](int of, std::vector<float>& sum) {
                                   const float* const row = window.row(static_cast<W::Of>(of), y + k_half + dy);
                                   add_products(window.counted.data(), row + k_half + dx, first, end, sum.data());
                               };
                               for (int c = 0; c < 3; ++c)
                                   add(W::lr + c, window.light[c]), add(W::wr + c, window.weight[c]);
                           });
        set_found(first, end, &LobePixel::gathered, &LobePixel::filtered, pixels, window);
    });
}

namespace {

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

glm::vec3 times_mean(const LobePixel& own, const glm::vec3& light, const glm::vec3& weight, const glm::vec3& alone)
{
    glm::vec3 result(0);
    for (int c = 0; c < 3; ++c) result[c] = weight[c] > 0 ? own.weight[c] * (light[c] / weight[c]) : alone[c];
    return result;
}

}   // namespace

float LobeImage::density_around(int x, int y, const LobeRay& ray, const LobeFilterOptions& options) const
{
    float density = 0, shares = 0;
    for_each_alike(*this, size_, x, y, {options.rays_alike, options.rays_unlike}, options,
                   [&](int nx, int ny, float share, float counted) {
                       const LobePixel& lobe = at(nx, ny);
                       const float there = density_of(seen_place(lobe, at(x, y), ray), lobe.width * lobe.width);
                       density += counted * (lobe.scale * there), shares += share;
                   });
    return density / shares;
}

glm::vec3 LobeImage::gathered(int x, int y, const LobeFilterOptions& options) const
{
    const LobePixel& own = at(x, y);
    if (own.weight == glm::vec3(0)) return glm::vec3(0);
    if (!(own.width > 0)) return own.light;
    glm::vec3 light(0), weight(0);
    for_each_alike(*this, size_, x, y, {options.rays_alike, options.rays_unlike}, options,
                   [&](int nx, int ny, float, float counted) {
                       for (const PackedLobeRay& kept : rays_of(nx, ny)) {
                           const LobeRay ray = unpacked(kept);
                           const float density = density_around(nx, ny, ray, options);
                           if (!(density > 0)) continue;
                           const float there =
                               own.scale * density_of(seen_place(own, at(nx, ny), ray), own.width * own.width);
                           const float counts = counted * (there / density);
                           light += counts * ray.light, weight += counts * ray.weight;
                       }
                   });
    return times_mean(own, light, weight, own.light);
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
    return times_mean(own, light, weight, own.gathered);
}

}   // namespace gnomon::trace
